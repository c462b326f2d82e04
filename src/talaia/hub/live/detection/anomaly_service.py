"""Anomaly detectors at work on what comes in, without holding it up.

The link hands over its samples and goes on: they wait in a bounded queue, and those that find no
room are skipped and counted. Detectors run on the event loop a millisecond at a time, behind all
that is ready to run. Scores go to the pages that look, and into the history as channels of their
own, under a run of the hub's; what was learned goes to the database now and then, and at the end.

Long, because the whole life of a detector at the hub is told here.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from sqlalchemy.exc import SQLAlchemyError

from talaia.errors import TalaiaError
from talaia.hub.anomaly.episode_runner import (
    AnomalyBegan,
    AnomalyEnded,
    excess_of,
    score_address,
    shares_of,
)
from talaia.hub.anomaly.groups.group_runner import GroupRunner
from talaia.hub.anomaly.guarded import GuardedDetector
from talaia.hub.anomaly.runner import DetectorRunner
from talaia.hub.live.detection.known_anomalies import KnownAnomalies
from talaia.hub.live.detection.score_writer import ScoreWriter
from talaia.hub.live.detection.site_watch import SiteWatch, watch_site
from talaia.hub.ports import AnomalyReport
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.clock import Clock
    from talaia.hub.anomaly.episode_runner import EpisodeRunner
    from talaia.hub.anomaly.groups.modal_group import ModalGroup
    from talaia.hub.live.pages.fanout import Fanout
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.ports import AnomalySink, DetectorSink, History
    from talaia.hub.store.sites.detector_state import DetectorState

__all__ = ["AnomalyService"]

_LOG = logging.getLogger(__name__)
# Samples that may wait to be looked at; a second of a hub with many fast signals.
_MOST_WAITING = 20_000
# So long detectors run before all else has its turn.
_SLICE_S = 0.001
# How often silence is looked for, and scores are written (s).
_TICK_S = 1.0
# What was learned is written down: so many detectors a tick, each at most this often.
_SAVES_A_TICK = 4
_SAVE_EVERY_S = 900.0
# While these are raised the database is away; anything else is a defect.
_FAILS = (SQLAlchemyError, TalaiaError, OSError)


class _Piece(NamedTuple):
    """Samples of watched channels of one site, in the order they came."""

    # Samples of one batch; the lists have one item for each.
    live: LiveSite
    addresses: list[str]
    times: list[int]
    values: list[float]


class AnomalyService:
    """Runs the detectors that site descriptions ask for.

    Attributes:
        known: what nobody is told of.
        skipped: samples for which there was no room, since the start.

    """

    def __init__(
        self,
        *,
        sites: Sites,
        history: History,
        learned: DetectorState,
        fanout: Fanout,
        clock: Clock,
    ) -> None:
        """Keep scores in ``history`` and what is learned in ``learned``; show scores live."""
        # What people know, and are not told of.
        self.known = KnownAnomalies(learned)
        # The sites as they are now.
        self._sites = sites
        # Shows scores on pages.
        self._fanout = fanout
        # What detectors have learned, in the database.
        self._learned = learned
        # Monotonic for when things were saved, wall for silence.
        self._clock = clock
        # Told of each anomaly that begins or ends, the alarms among them.
        self._sinks: list[AnomalySink] = []
        # Told how a detector stands.
        self._shown_to: list[DetectorSink] = []
        # By site; made anew for another description.
        self._of: dict[str, SiteWatch] = {}
        # In the order they came; bounded by `_MOST_WAITING`.
        self._waiting: deque[_Piece] = deque()
        # Samples in all that waits.
        self._count = 0
        self.skipped = 0
        # Something waits.
        self._news = asyncio.Event()
        # Scores on their way to the history.
        self._scores = ScoreWriter(history)
        # When each detector was last saved (monotonic, s), by site, address and name.
        self._saved_at: dict[tuple[str, str, str], float] = {}
        # It was logged that the database fails; once for each failure.
        self._failing = False

    @property
    def waiting(self) -> int:
        """So many samples wait to be looked at."""
        return self._count

    def add_listener(self, sink: AnomalySink) -> None:
        """Tell ``sink`` of every anomaly from now on."""
        self._sinks.append(sink)

    def add_display(self, sink: DetectorSink) -> None:
        """Tell ``sink`` from now on whenever a detector stands otherwise."""
        self._shown_to.append(sink)

    def enqueue_samples(self, live: LiveSite, columns: Columns) -> None:
        """Take what is watched out of a batch; never waits."""
        watch = self._watch_of(live)
        if not watch.addresses or not len(columns):
            return
        at = watch.pick_samples(columns)
        if not at.size:
            return
        if self._count + at.size > _MOST_WAITING:
            self.skipped += int(at.size)
            return
        addresses = [watch.addresses[index] for index in columns.channel[at].tolist()]
        times, values = columns.time_us[at].tolist(), columns.value[at].tolist()
        self._waiting.append(_Piece(live, addresses, times, values))
        self._count += int(at.size)
        self._news.set()

    def detectors_of(self, site: str) -> list[EpisodeRunner]:
        """List the detectors of a site that are at work now."""
        live = self._sites.find_site(site)
        return [] if live is None else self._watch_of(live).all_runners()

    def dismiss_peak(self, site: str, address: str, detector: str) -> bool | None:
        """Let a detector learn that its latest peak was none; None if there is no such one.

        Returns:
            False where the detector cannot learn.

        """
        live = self._sites.find_site(site)
        runner = None if live is None else self._watch_of(live).find_runner(address, detector)
        if live is None or runner is None:
            return None
        learns = runner.dismiss_peak()
        runner.confirmed = False
        # A person's word is kept with the next tick.
        self._saved_at[site, address, detector] = -_SAVE_EVERY_S
        if learns:
            if (ended := runner.end_anomaly()) is not None:
                self._publish_anomaly(live, runner, ended)
            else:
                self._publish_standing(live, runner)
        return learns

    def confirm_newest(self, site: str, address: str, detector: str) -> tuple[int, int] | None:
        """Take it that a detector's newest anomaly was one, and give its stretch (µs), if any."""
        live = self._sites.find_site(site)
        runner = None if live is None else self._watch_of(live).find_runner(address, detector)
        if live is None or runner is None or runner.from_us == 0:
            return None
        runner.confirmed, runner.forgiven = True, False
        self._publish_standing(live, runner)
        return runner.from_us, runner.to_us or runner.episodes.last_us

    def find_group(self, site: str, address: str) -> GroupRunner | None:
        """Find a group of signals that is at work now."""
        for runner in self.detectors_of(site):
            if isinstance(runner, GroupRunner) and runner.address == address:
                return runner
        return None

    def take_learned(self, site: str, runner: GroupRunner, detector: ModalGroup) -> None:
        """Let a group go on with what was learned from a stretch of the past."""
        live = self._sites.find_site(site)
        if live is None:
            return
        # A person's word is kept with the next tick.
        self._saved_at[site, runner.address, runner.word] = -_SAVE_EVERY_S
        if (ended := runner.take_learned(detector)) is not None:
            self._publish_anomaly(live, runner, ended)
        else:
            self._publish_standing(live, runner)

    async def run(self) -> None:
        """Look at samples, write scores, keep what is learned; until cancelled."""
        ticking = asyncio.create_task(self._tick_loop())
        try:
            while True:
                await self._news.wait()
                self._news.clear()
                while self._waiting:
                    # Taken out only after it: what is being looked at counts as waiting.
                    await self._evaluate_piece(self._waiting[0])
                    self._count -= len(self._waiting.popleft().times)
        finally:
            ticking.cancel()
            await asyncio.gather(ticking, return_exceptions=True)

    async def close(self) -> None:
        """Write down what is left; `run` has ended."""
        # What cannot be kept now stays as it was saved last: the end of the hub does not wait.
        with suppress(*_FAILS):
            await self._scores.write_waiting()
        with suppress(*_FAILS):
            await self._save_detectors(
                _unsaved_detectors(self._of, self._saved_at, self._clock, None)
            )

    async def _evaluate_piece(self, piece: _Piece) -> None:
        watch = self._watch_of(piece.live)
        if not watch.ready:
            await self._restore_learned(piece.live, watch)
        # By the wall: what matters is how long all else has waited.
        until = time.perf_counter() + _SLICE_S
        for address, time_us, value in zip(piece.addresses, piece.times, piece.values, strict=True):
            self._score_singles(piece.live, watch, address, time_us=time_us, value=value)
            self._score_groups(piece.live, watch, address, time_us=time_us, value=value)
            if time.perf_counter() > until:
                self._publish_scores(piece.live, watch)
                # Lets all else run that is ready; samples of this piece wait meanwhile.
                await asyncio.sleep(0)
                until = time.perf_counter() + _SLICE_S
        self._publish_scores(piece.live, watch)

    def _score_singles(
        self, live: LiveSite, watch: SiteWatch, address: str, *, time_us: int, value: float
    ) -> None:
        for place, runner in enumerate(watch.watched.get(address, ())):
            try:
                turn = _score_sample(runner, time_us, value)
            except (ArithmeticError, LookupError, ValueError):
                # One that fails must not end the others: it begins anew.
                _LOG.exception("the detector %s of %s begins anew", runner.word, address)
                watch.watched[address][place] = DetectorRunner(address, runner.unit, runner.watch)
                continue
            self._handle_news(live, watch, runner=runner, turn=turn, time_us=time_us)

    def _score_groups(
        self, live: LiveSite, watch: SiteWatch, address: str, *, time_us: int, value: float
    ) -> None:
        for runner, place in watch.members.get(address, ()):
            judged = runner.detector.heard
            try:
                turn = runner.score_sample(place, time_us, value)
            except (ArithmeticError, LookupError, ValueError, np.linalg.LinAlgError):
                _LOG.exception("the group %s begins anew", runner.address)
                others = [group for group in watch.groups if group is not runner]
                watch.take_groups([*others, GroupRunner(runner.group)])
                return
            # A score is of a step, and most samples complete none.
            if runner.detector.heard != judged:
                self._handle_news(live, watch, runner=runner, turn=turn, time_us=time_us)

    def _handle_news(
        self,
        live: LiveSite,
        watch: SiteWatch,
        *,
        runner: EpisodeRunner,
        turn: AnomalyBegan | AnomalyEnded | None,
        time_us: int,
    ) -> None:
        if turn is not None:
            self._publish_anomaly(live, runner, turn)
        elif runner.take_change():
            self._publish_standing(live, runner)
        address = score_address(runner.address, runner.word)
        place = watch.places.get(address)
        if place is not None:
            watch.fresh.append((place, time_us, runner.score))
        if runner.worth_writing(time_us):
            self._scores.add_score(live.name, address, time_us, runner.score)

    def _publish_scores(self, live: LiveSite, watch: SiteWatch) -> None:
        """Show pages the newest scores."""
        if not watch.fresh:
            return
        fresh, watch.fresh = watch.fresh, []
        if watch.description is not live.description:
            # Numbered by another list of channels.
            return
        columns = _columns_of(fresh)
        live.latest.update_values(columns, self._clock.monotonic_ns())
        self._fanout.publish(live, columns)

    def _watch_of(self, live: LiveSite) -> SiteWatch:
        """Give a site's detectors; made anew for another description, as they were if they fit."""
        watch = self._of.get(live.name)
        if watch is not None and watch.description is live.description:
            return watch
        fresh, gone = watch_site(live, watch)
        self._of[live.name] = fresh
        for runner in gone:
            if (ended := runner.end_anomaly()) is not None:
                self._publish_anomaly(live, runner, ended)
        return fresh

    async def _restore_learned(self, live: LiveSite, watch: SiteWatch) -> None:
        """Go on with what was learned before the hub was started."""
        # First: a database that fails must not be asked for each batch.
        watch.ready = True
        try:
            kept = await self._learned.states_of(live.name)
        except _FAILS as error:
            _LOG.warning("detectors of %s learn anew, the database fails: %s", live.name, error)
            return
        watch.restore(kept)
        await self.known.read_all([live.name])

    def _publish_anomaly(
        self, live: LiveSite, runner: EpisodeRunner, turn: AnomalyBegan | AnomalyEnded
    ) -> None:
        if isinstance(turn, AnomalyBegan):
            known = self.known.holding_for(live, runner)
            runner.known = "" if known is None else known.key
        # Of a known one nobody is told, neither that it began nor that it ended.
        if not runner.known:
            news = _report_of(live, runner, turn)
            for sink in self._sinks:
                sink.report_anomaly(news)
        self._publish_standing(live, runner)

    def _tell_known(self, live: LiveSite, watch: SiteWatch) -> None:
        for runner in self.known.over_for(live, watch.all_runners()):
            began = AnomalyBegan(runner.from_us, runner.episodes.top, runner.why)
            self._publish_anomaly(live, runner, began)

    def _publish_standing(self, live: LiveSite, runner: EpisodeRunner) -> None:
        for sink in self._shown_to:
            sink.report_detector(live.name, runner)

    async def _tick_loop(self) -> None:
        while True:
            await asyncio.sleep(_TICK_S)
            watches = ((live, self._watch_of(live)) for live in self._sites)
            # Of thousands of sites most may have no detector.
            watching = [(live, watch) for live, watch in watches if watch.any_runners]
            self._score_silence(watching)
            for live, watch in watching:
                self._tell_known(live, watch)
            try:
                await self._scores.write_waiting()
                due = _unsaved_detectors(self._of, self._saved_at, self._clock, _SAVES_A_TICK)
                await self._save_detectors(due)
            except _FAILS as error:
                if not self._failing:
                    _LOG.warning("anomaly scores and what is learned wait: %s", error)
                self._failing = True
            else:
                self._failing = False

    def _score_silence(self, watching: Sequence[tuple[LiveSite, SiteWatch]]) -> None:
        """Let detectors look at the clock; while a gateway is away, nothing comes anyway."""
        for live, watch in watching:
            if not live.online:
                continue
            # By the gateway's clock, by which its samples are dated.
            now_us = self._clock.wall_ns() // 1000 + round(live.presence.skew_ms * 1000)
            for runner in watch.all_runners():
                turn = runner.score_silence(now_us)
                if turn is not None:
                    self._handle_news(live, watch, runner=runner, turn=turn, time_us=now_us)
            self._publish_scores(live, watch)

    async def _save_detectors(self, due: Sequence[tuple[str, EpisodeRunner]]) -> None:
        now = self._clock.monotonic_ns() / 1e9
        rows = [(site, runner.address, runner.word, runner.dump_state()) for site, runner in due]
        try:
            await self._learned.save_states(rows)
        except _FAILS:
            # Nothing of it was kept, so it is due again.
            for _, runner in due:
                runner.changed = True
            raise
        for site, address, detector, _ in rows:
            self._saved_at[site, address, detector] = now


def _unsaved_detectors(
    watches: dict[str, SiteWatch],
    saved_at: dict[tuple[str, str, str], float],
    clock: Clock,
    most: int | None,
) -> list[tuple[str, EpisodeRunner]]:
    """List what has learned since it was saved, with its site; ``most``: only what is due."""
    now, due = clock.monotonic_ns() / 1e9, []
    for site, watch in watches.items():
        for runner in watch.all_runners() if watch.any_runners else ():
            key = (site, runner.address, runner.word)
            # What just began to learn waits its turn like all others.
            since = saved_at.setdefault(key, now - _SAVE_EVERY_S / 2)
            if runner.changed and (most is None or now - since >= _SAVE_EVERY_S):
                due.append((site, runner))
    return due if most is None else due[:most]


def _report_of(
    live: LiveSite, runner: EpisodeRunner, turn: AnomalyBegan | AnomalyEnded
) -> AnomalyReport:
    """Say what those are told who listen."""
    return AnomalyReport(
        site=live.name,
        channel=runner.address,
        detector=runner.word,
        began_us=turn.time_us if isinstance(turn, AnomalyBegan) else turn.began_us,
        ended_us=None if isinstance(turn, AnomalyBegan) else turn.ended_us,
        score=turn.score,
        why=turn.why,
        excess=excess_of(runner, turn.score),
        shares=shares_of(runner),
    )


def _columns_of(fresh: Sequence[tuple[int, int, float]]) -> Columns:
    """Make columns of scores: number of the channel, time (µs), score."""
    return Columns(
        np.array([place for place, _, _ in fresh], np.uint16),
        np.array([time_us for _, time_us, _ in fresh], np.int64),
        np.array([score for _, _, score in fresh], np.float64),
        {},
    )


def _score_sample(
    runner: DetectorRunner, time_us: int, value: float
) -> AnomalyBegan | AnomalyEnded | None:
    """Let a detector see a sample; of an extension's it is judged how long it takes."""
    if not isinstance(runner.detector, GuardedDetector):
        # Our own detectors are bounded; only those of others are timed.
        return runner.score_sample(time_us, value)
    began = time.perf_counter()
    turn = runner.score_sample(time_us, value)
    runner.detector.record_duration(time.perf_counter() - began)
    return turn
