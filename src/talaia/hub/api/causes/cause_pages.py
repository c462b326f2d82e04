"""From an anomaly, alarm or event to its cause: what else was unusual, and when it was so before.

What was commanded, said and seen in that minute has routes of its own, with their rights: the
logbook's and the sightings'.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query, Request

from talaia.hub.anomaly.causes import ONE_CAUSE_US, Beginning, gather_episodes, most_similar
from talaia.hub.anomaly.episode_runner import score_address
from talaia.hub.api.access import address_of, live_of, who_of
from talaia.hub.api.causes.cause_schemas import (
    CauseShape,
    KnownAsk,
    KnownShape,
    SimilarShape,
    StateShape,
    UnusualShape,
)
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.sites.anomaly_views import share_shapes
from talaia.hub.auth.permissions import Right, sees_signal
from talaia.hub.live.detection.known_anomalies import MOST_KNOWN, KnownAnomaly, new_key
from talaia.hub.store.audit import PART_OF_ANOMALY, AuditFilter
from talaia.model.alarms.signal_groups import group_named
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.clock import Clock
    from talaia.hub.anomaly.causes import Episode
    from talaia.hub.anomaly.episode_runner import EpisodeRunner
    from talaia.hub.live.detection.anomaly_service import AnomalyService
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.ports import History
    from talaia.hub.store.audit import Audit
    from talaia.model.site import Site

__all__ = ["CausePages"]

_BEGAN = f"anomaly began,{PART_OF_ANOMALY} began"
_VERDICTS = ("anomaly confirmed", "anomaly forgiven", "anomaly known")
# Rows of the log that are looked through for an episode like this one, and points of a score.
_MOST_ROWS, _POINTS = 1000, 500
# Below such a part of its bar a score is nothing unusual, and so many are named.
_LEAST_PART, _MOST_NAMED = 0.5, 30
_MOST_STATES = 20


class CausePages:
    """The routes of causes."""

    def __init__(
        self, *, watching: AnomalyService, history: History, audit: Audit, clock: Clock
    ) -> None:
        """Answer from ``watching`` and what is stored; what a person says goes to ``audit``."""
        self._watching, self._history = watching, history
        self._audit, self._clock = audit, clock

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/causes"
        router.get(at)(self.show)
        router.post(at + "/known", status_code=201)(self.add_known)
        router.delete(at + "/known/{known}", status_code=204)(self.end_known)
        return router

    async def show(
        self, site: str, request: Request, at_us: Annotated[int, Query(ge=0, le=2**53)]
    ) -> CauseShape:
        """Say what was unusual within a minute of a moment, and when it was like that before."""
        live, grants = live_of(request), who_of(request).grants
        runners = [
            runner
            for runner in self._watching.detectors_of(site)
            if sees_signal(grants, live.description, *runner.address.split("/", 1))
        ]
        from_us, to_us = at_us - ONE_CAUSE_US, at_us + ONE_CAUSE_US
        return CauseShape(
            at_us=at_us,
            from_us=from_us,
            to_us=to_us,
            unusual=await self._rank_unusual(live, runners, from_us, to_us),
            similar=await self._find_similar(request, live, runners, at_us),
            states=await self._states_at(request, live, at_us),
            known=[
                _known_shape(live, one, holds=self._watching.known.holds(live, one))
                for one in await self._watching.known.read_site(site)
                if any(runner.address == one.address for runner in runners)
            ],
            may_use=grants.has_right(Right.USE, site),
        )

    async def add_known(self, site: str, asked: KnownAsk, request: Request) -> KnownShape:
        """Say that a detector's anomalies are known while the machine is in a state."""
        live = live_of(request)
        if not any(
            (runner.address, runner.word) == (asked.address, asked.detector)
            for runner in self._watching.detectors_of(site)
        ):
            raise ApiProblem(404, "unknown", "no such detector is at work")
        if asked.state and not _state_name(live.description, asked.state, asked.value):
            raise ApiProblem(422, "invalid", f"{asked.state!r} has no such state")
        if len(await self._watching.known.read_site(site)) >= MOST_KNOWN:
            raise ApiProblem(409, "full", f"at most {MOST_KNOWN} are kept; end one that is over")
        known = KnownAnomaly(
            key=new_key(),
            address=asked.address,
            detector=asked.detector,
            state=asked.state,
            value=asked.value,
            who=who_of(request).name,
            comment=asked.comment,
            since_us=self._clock.wall_ns() // 1000,
        )
        await self._watching.known.add_known(site, known)
        shape = _known_shape(live, known, holds=self._watching.known.holds(live, known))
        self._append_record("anomaly known", request, site=site, known=known, shape=shape)
        return shape

    async def end_known(self, site: str, known: str, request: Request) -> None:
        """Tell of it again."""
        live = live_of(request)
        ended = await self._watching.known.end_known(site, known)
        if ended is None:
            raise ApiProblem(404, "unknown", "there is no such entry; it may be ended already")
        shape = _known_shape(live, ended, holds=False)
        self._append_record("anomaly told again", request, site=site, known=ended, shape=shape)

    # ── what is shown ───────────────────────────────────────────────────────────────────────

    async def _rank_unusual(
        self, live: LiveSite, runners: Sequence[EpisodeRunner], from_us: int, to_us: int
    ) -> list[UnusualShape]:
        addresses = [score_address(runner.address, runner.word) for runner in runners]
        series = await self._history.read_series(
            live.name, addresses, from_us, to_us, width=_POINTS
        )
        found = []
        for runner, one in zip(runners, series, strict=True):
            if not one.value.size or one.value.max() < _LEAST_PART * runner.episodes.bar:
                continue
            at = int(one.value.argmax())
            at_us, score = int(one.time_us[at]), float(one.value[at])
            newest = _is_newest(runner, at_us)
            found.append(
                UnusualShape(
                    address=runner.address,
                    detector=runner.word,
                    title=_title_of(live.description, runner.address),
                    score=score,
                    bar=runner.episodes.bar,
                    at_us=at_us,
                    newest=newest,
                    shares=share_shapes(runner, runner.shares if newest else ()),
                )
            )
        # By how far beyond the bar, of what is left up to 1: bars differ from detector to detector.
        found.sort(key=lambda one: (one.score - one.bar) / max(1e-9, 1 - one.bar), reverse=True)
        return found[:_MOST_NAMED]

    async def _find_similar(
        self, request: Request, live: LiveSite, runners: Sequence[EpisodeRunner], at_us: int
    ) -> SimilarShape | None:
        devices = who_of(request).grants.devices(Right.VIEW, live.name)
        wanted = AuditFilter(
            site=live.name, kind=_BEGAN, to_us=at_us + ONE_CAUSE_US + 1, devices=devices
        )
        rows, _ = await self._audit.find_records(wanted, _MOST_ROWS)
        episodes = gather_episodes(
            Beginning(entry.time_us, entry.device, entry.message.partition(": ")[0])
            for _, entry in rows
        )
        now = [one for one in episodes if one.last_us >= at_us - ONE_CAUSE_US]
        before = [one for one in episodes if one.last_us < at_us - ONE_CAUSE_US]
        names = frozenset[tuple[str, str]]().union(*(one.names for one in now))
        found = most_similar(names, before)
        if found is None:
            return None
        episode, likeness = found
        after = next((one for one in episodes if one.began_us > episode.last_us), None)
        verdict = await self._find_verdict(live, runners, episode, after)
        return SimilarShape(
            began_us=episode.began_us,
            names=sorted(name for _, name in episode.names),
            likeness=likeness,
            verdict=verdict[0],
            comment=verdict[1],
            who=verdict[2],
        )

    async def _find_verdict(
        self,
        live: LiveSite,
        runners: Sequence[EpisodeRunner],
        episode: Episode,
        after: Episode | None,
    ) -> tuple[str, str, str]:
        """Find what a person said of an episode before the next one: the kind, words and who."""
        about = tuple(
            f"{runner.address}, "
            for runner in runners
            if any(
                _title_of(live.description, runner.address).endswith(name)
                for _, name in episode.names
            )
        )
        wanted = AuditFilter(
            site=live.name,
            kind=",".join(_VERDICTS),
            from_us=episode.began_us,
            to_us=None if after is None else after.began_us,
        )
        rows, _ = await self._audit.find_records(wanted, _MOST_ROWS)
        for _, entry in rows:
            if entry.message.startswith(about):
                said = entry.message.partition(": ")[2]
                return entry.kind.rpartition(" ")[2], said, entry.who
        return "", "", ""

    async def _states_at(self, request: Request, live: LiveSite, at_us: int) -> list[StateShape]:
        grants, site = who_of(request).grants, live.description
        addresses = [
            f"{device_id}/{signal_id}"
            for device_id, device in site.devices.items()
            for signal_id, signal in device.signals.items()
            if signal.type is SignalType.STATE and sees_signal(grants, site, device_id, signal_id)
        ][:_MOST_STATES]
        readings = await self._history.last_readings(live.name, addresses, at_us)
        found = []
        for address in addresses:
            # NaN is equal to nothing, itself included.
            value = readings[address][1] if address in readings else -1.0
            name = _state_name(site, address, int(value)) if value == value else ""
            if name:
                title = _title_of(site, address)
                found.append(StateShape(address=address, title=title, value=int(value), name=name))
        return found

    def _append_record(
        self, kind: str, request: Request, *, site: str, known: KnownAnomaly, shape: KnownShape
    ) -> None:
        while_it = f"while {shape.state_name}" if shape.state_name else "at all times"
        why = f"; {known.comment}" if known.comment else ""
        self._audit.append_record(
            kind,
            who=who_of(request).name,
            address=address_of(request),
            site=site,
            device=known.address.partition("/")[0],
            message=f"{known.address}, {known.detector}: {while_it}{why}",
        )


def _title_of(site: Site, address: str) -> str:
    """Name a signal with its device, or a group."""
    device, _, name = address.partition("/")
    if not device:
        group = group_named(site, name)
        return name if group is None else group.name
    signal = site.signal(address)
    return address if signal is None else f"{site.devices[device].name} {signal.name}"


def _state_name(site: Site, address: str, value: int) -> str:
    """Name a state; empty where there is no such one."""
    signal = site.signal(address)
    if signal is None or signal.type is not SignalType.STATE or value < 0:
        return ""
    return signal.states[value] if value < len(signal.states) else ""


def _known_shape(live: LiveSite, known: KnownAnomaly, *, holds: bool) -> KnownShape:
    site = live.description
    name = _state_name(site, known.state, known.value) if known.state else ""
    return KnownShape(
        key=known.key,
        address=known.address,
        detector=known.detector,
        title=_title_of(site, known.address),
        state=known.state,
        state_name=f"{_title_of(site, known.state)} is {name}" if known.state else "",
        who=known.who,
        comment=known.comment,
        since_us=known.since_us,
        holds=holds,
    )


def _is_newest(runner: EpisodeRunner, at_us: int) -> bool:
    """Tell whether it lies in a detector's newest anomaly, which alone can be judged."""
    return 0 < runner.from_us <= at_us <= (runner.to_us or runner.episodes.last_us)
