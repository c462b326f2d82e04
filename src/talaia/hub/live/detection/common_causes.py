"""Gathers the anomalies of each site into episodes of one cause, and tells alarms of those.

What is open is kept beside what detectors have learned. Detectors forget over a restart which of
their anomalies was on: an episode goes on as it was for three minutes, and what no detector has
found again by then has ended.
"""

from __future__ import annotations

import asyncio
import logging
from contextlib import suppress
from typing import TYPE_CHECKING

import msgspec
from sqlalchemy.exc import SQLAlchemyError

from talaia.errors import TalaiaError
from talaia.hub.anomaly.episode_runner import excess_of, shares_of
from talaia.hub.anomaly.shared_causes import AGAIN_US, CauseMember, SharedCauses
from talaia.hub.ports import SharedCause
from talaia.model.alarms.cause_parts import cause_parts
from talaia.model.alarms.signal_groups import groups_of

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.anomaly.shared_causes import Cause
    from talaia.hub.live.detection.anomaly_service import AnomalyService
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.ports import AnomalyReport, CauseSink
    from talaia.hub.store.sites.detector_state import DetectorState
    from talaia.model.site import Site

__all__ = ["CommonCauses"]

_LOG = logging.getLogger(__name__)
# Where they are kept among what detectors have learned.
_KEPT = ("", "~causes")
_FAILS = (SQLAlchemyError, TalaiaError, OSError)
_TICK_S = 1.0
# Shares are told again when one moved so far, and why at most so often (µs).
_MOVED, _TOLD_AGAIN_US = 0.1, 5_000_000
# Signals that are named in words; the page lists all.
_MOST_NAMED, _LEAST_NAMED = 5, 0.01


class CommonCauses:
    """What is unusual together, of all sites."""

    def __init__(
        self,
        *,
        sites: Sites,
        detectors: AnomalyService,
        events: RobotEvents,
        alarms: CauseSink,
        learned: DetectorState,
        clock: Clock,
    ) -> None:
        """Write lines to ``events``, tell ``alarms``, and keep what is open in ``learned``."""
        self._sites, self._detectors = sites, detectors
        self._events, self._alarms = events, alarms
        self._learned, self._clock = learned, clock
        # By site.
        self._of: dict[str, SharedCauses] = {}
        # By site: a description, and the part of each address that detectors look at.
        self._parts: dict[str, tuple[Site, dict[str, str]]] = {}
        # By site and part: what alarms were told last, and when (µs).
        self._told: dict[tuple[str, str], tuple[SharedCause, int]] = {}
        # Sites of which something is not kept yet.
        self._unsaved: set[str] = set()
        self._failing = False
        # Until then what was on before the start may be found again (µs).
        self._sure_us = 0

    def report_anomaly(self, news: AnomalyReport) -> None:
        """Put an anomaly into its episode; see `talaia.hub.ports.AnomalySink`."""
        live = self._sites.find_site(news.site)
        if live is None:
            return
        causes, part = self._causes_of(live), self._part_of(live, news.channel)
        if news.ended_us is None:
            member = CauseMember(
                address=news.channel,
                detector=news.detector,
                began_us=news.began_us,
                score=news.score,
                excess=news.excess,
                shares=news.shares,
                why=news.why,
            )
            opened, first = causes.begin_member(part, member, self._now_us())
            self._events.report_anomaly(news, joined=not first)
            self._publish_cause(live, part, opened)
        else:
            cause = causes.end_member(part, news.channel, news.detector)
            self._report_end(news, cause)
            if cause is not None:
                self._publish_cause(live, part, cause)
        self._unsaved.add(live.name)

    async def open(self) -> None:
        """Bring back what was open when the hub ended."""
        now_us = self._now_us()
        self._sure_us = now_us + AGAIN_US
        try:
            # Of all at once: who takes over for another hub is waited for.
            every = await self._learned.states_named(_KEPT)
        except _FAILS as error:
            _LOG.warning("open anomalies are not known: %s", error)
            return
        for live in self._sites:
            kept = every.get(live.name)
            if kept is None:
                continue
            try:
                causes = msgspec.msgpack.decode(kept, type=SharedCauses)
            except msgspec.MsgspecError as error:
                _LOG.warning("open anomalies of %s are not known: %s", live.name, error)
                continue
            causes.mark_unsure(now_us)
            self._of[live.name] = causes
            for part, cause in causes.open.items():
                self._publish_cause(live, part, cause)

    async def run(self) -> None:
        """Close what is over and keep what is open; until cancelled."""
        while True:
            await asyncio.sleep(_TICK_S)
            self.follow_time()
            try:
                await self._save_all()
            except _FAILS as error:
                if not self._failing:
                    _LOG.warning("which anomalies are open is not kept: %s", error)
                self._failing = True
            else:
                self._failing = False

    async def close(self) -> None:
        """Keep what is open; `run` has ended."""
        with suppress(*_FAILS):
            await self._save_all()

    def follow_time(self) -> None:
        """Follow detectors that stand otherwise, and close what is over."""
        now_us = self._now_us()
        for site, causes in self._of.items():
            live = self._sites.find_site(site)
            if live is None or not causes.open:
                continue
            self._parts_of(live)
            if now_us >= self._sure_us and causes.end_unsure():
                self._unsaved.add(site)
            self._follow_detectors(live, causes)
            for part, cause in causes.close_over(now_us):
                self._report_news(_shared_cause(live, part, cause, over=True), now_us)
                del self._told[site, part]
                self._unsaved.add(site)
            for part, cause in causes.open.items():
                self._publish_cause(live, part, cause)

    def _follow_detectors(self, live: LiveSite, causes: SharedCauses) -> None:
        runners = {(one.address, one.word): one for one in self._detectors.detectors_of(live.name)}
        for member in [one for cause in causes.open.values() for one in cause.members]:
            runner = runners.get(member.key)
            if not member.on or member.unsure:
                continue
            if runner is None or runner.episodes.began_us < 0:
                # It began anew, or nobody asks for it any more.
                member.on = False
                self._unsaved.add(live.name)
                continue
            excess = excess_of(runner, runner.episodes.top)
            if excess > member.excess:
                member.score, member.excess = runner.episodes.top, excess
                member.shares, member.why = shares_of(runner), runner.why

    def _report_end(self, news: AnomalyReport, cause: Cause | None) -> None:
        """Write down that an anomaly ended; the last one of an episode ends it, under its name."""
        alone = cause is None or (len(cause.members) == 1 and not cause.told_over)
        self._events.report_anomaly(news, joined=not alone)
        if cause is None or cause.on or cause.told_over:
            return
        cause.told_over = True
        if not alone:
            whole = news._replace(channel=cause.first.address, why=cause.first.why)
            others = [one.address for one in cause.members if one is not cause.first]
            self._events.report_anomaly(whole, among=list(dict.fromkeys(others)))

    def _publish_cause(self, live: LiveSite, part: str, cause: Cause) -> None:
        """Tell alarms how an episode stands, if that is news."""
        now_us = self._now_us()
        news = _shared_cause(live, part, cause, over=False)
        before, told_us = self._told.get((live.name, part), (None, 0))
        if before is not None and before.began_us == news.began_us:
            if not _differs(before, news):
                return
            grown = {one[0] for one in before.shares} != {one[0] for one in news.shares}
            if not grown and now_us - told_us < _TOLD_AGAIN_US:
                return
        self._report_news(news, now_us)
        if before is not None and before.began_us != news.began_us:
            # After it: an alarm that is on then knows of another cause.
            self._alarms.report_cause(before._replace(over=True))

    def _report_news(self, news: SharedCause, now_us: int) -> None:
        self._told[news.site, news.part] = (news, now_us)
        self._alarms.report_cause(news)

    def _causes_of(self, live: LiveSite) -> SharedCauses:
        self._parts_of(live)
        return self._of.setdefault(live.name, SharedCauses(open={}))

    def _part_of(self, live: LiveSite, address: str) -> str:
        return self._parts_of(live).get(address, address.partition("/")[0] or address)

    def _parts_of(self, live: LiveSite) -> dict[str, str]:
        """Give the part of each address; made anew for another description."""
        known = self._parts.get(live.name)
        if known is not None and known[0] is live.description:
            return known[1]
        site = live.description
        named = {device: devices[0] for device, devices in cause_parts(site).items()}
        parts = {
            f"{device}/{key}": named[device]
            for device, described in site.devices.items()
            for key in described.signals
        }
        for group in groups_of(site)[0]:
            parts[group.address] = parts[group.signals[0]]
        self._parts[live.name] = (site, parts)
        causes = self._of.get(live.name)
        if known is not None and causes is not None:
            before = set(causes.open)
            causes.keep_parts(parts, named.values())
            for part in before - set(causes.open):
                news, _ = self._told.pop((live.name, part))
                self._alarms.report_cause(news._replace(over=True))
        return parts

    async def _save_all(self) -> None:
        due = sorted(self._unsaved)
        if not due:
            return
        self._unsaved.clear()
        rows = [(site, *_KEPT, msgspec.msgpack.encode(self._of[site])) for site in due]
        try:
            await self._learned.save_states(rows)
        except _FAILS:
            self._unsaved.update(due)
            raise

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def _shared_cause(live: LiveSite, part: str, cause: Cause, *, over: bool) -> SharedCause:
    parts = cause.signal_parts()
    named = [
        f"{_name_of(live, one.address)} {100 * one.share:.0f} %"
        for one in parts[:_MOST_NAMED]
        if one.share >= _LEAST_NAMED
    ]
    more = f" and {len(parts) - _MOST_NAMED} more" if len(parts) > _MOST_NAMED else ""
    why = cause.worst.why
    # Of a single signal its share says nothing.
    said = ", ".join(named) + more if len(parts) > 1 else _name_of(live, parts[0].address)
    return SharedCause(
        site=live.name,
        part=part,
        began_us=cause.began_us,
        score=max(one.score for one in cause.members),
        why=f"{said}: {why}".rstrip(": ")[:500],
        shares=tuple((one.address, one.share, one.on and not over) for one in parts),
        over=over,
    )


def _name_of(live: LiveSite, address: str) -> str:
    signal = live.description.signal(address)
    return address.lstrip("/") if signal is None else signal.name


def _differs(before: SharedCause, now: SharedCause) -> bool:
    """Tell whether signals came, ended, or have another share than was told."""
    was = {address: (share, on) for address, share, on in before.shares}
    return len(was) != len(now.shares) or any(
        address not in was or was[address][1] is not on or abs(was[address][0] - share) >= _MOVED
        for address, share, on in now.shares
    )
