"""Keeps the detectors of each site to the number of false alarms that a person bears.

Long, because what is asked, what was seen and what follows from it are one state of a site.
"""

from __future__ import annotations

import asyncio
import logging
import time
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

import msgspec
import numpy as np
from sqlalchemy.exc import SQLAlchemyError

from talaia.errors import TalaiaError
from talaia.hub.anomaly.budget.score_tail import BLOCK_US, ScoreTail
from talaia.hub.anomaly.budget.thresholds import Basis, site_thresholds
from talaia.hub.anomaly.episode_runner import tail_word
from talaia.hub.anomaly.groups.group_runner import GroupRunner
from talaia.hub.anomaly.runner import DetectorRunner
from talaia.hub.anomaly.selection import wanted_detectors
from talaia.hub.live.detection.past_rows import read_past_rows

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.anomaly.episode_runner import EpisodeRunner
    from talaia.hub.live.detection.anomaly_service import AnomalyService
    from talaia.hub.live.detection.past_rows import PastRows
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.ports import History
    from talaia.hub.store.sites.detector_state import DetectorState

__all__ = ["AlarmBudgets", "BudgetStanding"]

_LOG = logging.getLogger(__name__)
# How often thresholds are set anew, and tails are looked after (s).
_EVERY_S = 60.0
# A tail is written down at most this often (s), so many at a time.
_SAVE_EVERY_S, _SAVES = 900.0, 50
# So much of the history is looked at for a detector that is new to the budget.
_FILLED_US = 14 * 86_400_000_000
# It computes for so long (s) and then lets all else have nine times as long: a tenth of a core.
_SLICE_S, _REST = 0.001, 9.0
_ROWS = 256
# Where a person's word is kept among what was learned.
_ASKED = ("", "~budget")
_FAILS = (SQLAlchemyError, TalaiaError, OSError)


class BudgetStanding(NamedTuple):
    """How a site's budget stands.

    Attributes:
        a_week: false alarms a week that are borne; 0: nobody asked, bars hold.
        described: what the description says.
        by_person: a person said another number than the description.
        basis: what the thresholds stand on.
        seen_s: so much of the past was looked at (s).
        needed_s: from so much on it is counted (s).
        reading: detectors whose stored history is still to be looked at.
        kept: detectors that the budget holds for; others: those whose own bars hold.

    """

    a_week: float
    described: float
    by_person: bool
    basis: Basis
    seen_s: float
    needed_s: float
    reading: int
    kept: int
    others: int


class AlarmBudgets:
    """Sets the thresholds of all sites, and goes on setting them."""

    def __init__(
        self,
        service: AnomalyService,
        *,
        sites: Sites,
        history: History,
        learned: DetectorState,
        clock: Clock,
    ) -> None:
        """Set those of ``service``; what was seen before is read from ``history``."""
        self._service = service
        self._sites = sites
        self._history = history
        self._learned = learned
        self._clock = clock
        # What people said, by site; sites that were asked for already.
        self._said: dict[str, float] = {}
        self._known: set[str] = set()
        # What the thresholds of a site stand on: the basis, blocks seen and needed.
        self._found: dict[str, tuple[Basis, int, int]] = {}
        # When each tail was saved (monotonic, s), by site, address and detector.
        self._saved_at: dict[tuple[str, str, str], float] = {}
        # A person asked for a budget: do not wait for the next minute.
        self._news = asyncio.Event()

    def standing_of(self, live: LiveSite) -> BudgetStanding:
        """Say how a site's budget stands."""
        runners = self._service.detectors_of(live.name)
        kept = [runner for runner in runners if _takes_part(runner)]
        basis, blocks, needed = self._found.get(live.name, (Basis.LEARNING, 0, 0))
        return BudgetStanding(
            a_week=self._a_week(live),
            described=_described(live),
            by_person=live.name in self._said,
            basis=basis,
            seen_s=blocks * BLOCK_US / 1e6,
            needed_s=needed * BLOCK_US / 1e6,
            reading=sum(runner.tail is None or not runner.tail.filled for runner in kept),
            kept=len(kept),
            others=len(runners) - len(kept),
        )

    async def set_budget(self, live: LiveSite, a_week: float | None) -> None:
        """Take a person's word: so many a week, 0 for none, None for what the description says.

        Raises:
            StoreDown: it could not be kept, and nothing was changed.

        """
        await self._learned.save_states([(live.name, *_ASKED, msgspec.msgpack.encode(a_week))])
        self._known.add(live.name)
        self._said.pop(live.name, None)
        if a_week is not None:
            self._said[live.name] = a_week
        await self.adjust_site(live)
        self._news.set()

    async def confirm_stretch(self, live: LiveSite, from_us: int, to_us: int) -> None:
        """Take it that what was in a stretch (µs) was real: no detector's false alarm."""
        for runner in self._service.detectors_of(live.name):
            if runner.tail is not None:
                runner.tail.forget_stretch(from_us, to_us)
                self._saved_at.pop((live.name, runner.address, runner.word), None)
        await self.adjust_site(live)

    async def run(self) -> None:
        """Set thresholds of all sites anew, and keep what was seen; until cancelled."""
        while True:
            for live in self._sites:
                try:
                    await self._look_after(live)
                except _FAILS as error:
                    _LOG.warning("the false alarms of %s are not counted: %s", live.name, error)
            await asyncio.sleep(_EVERY_S)

    async def read_past(self) -> None:
        """Let detectors that are new to a budget see the stored history; until cancelled."""
        while True:
            for live in self._sites:
                try:
                    if self._a_week(live) > 0.0:
                        await self._fill_tails(live)
                except _FAILS as error:
                    _LOG.warning("the past of %s is not looked at: %s", live.name, error)
            with suppress(TimeoutError):
                async with asyncio.timeout(_EVERY_S):
                    await self._news.wait()
            self._news.clear()

    async def close(self) -> None:
        """Write down what was seen; `run` has ended."""
        with suppress(*_FAILS):
            for live in self._sites:
                await self._save_tails(live, most=None)

    async def adjust_site(self, live: LiveSite) -> None:
        """Set the thresholds of a site by what was seen up to now."""
        a_week = self._a_week(live)
        runners = self._service.detectors_of(live.name)
        if a_week <= 0.0:
            self._found.pop(live.name, None)
            for runner in runners:
                runner.set_needs(())
                runner.tail = None
            return
        for runner in runners:
            if runner.tail is None and _takes_part(runner):
                runner.tail = ScoreTail()
        tails = {
            (runner.address, runner.word): runner.tail
            for runner in runners
            if runner.tail is not None
        }
        # Of a thousand signals it takes half a second; what grows meanwhile is only read.
        found = await asyncio.to_thread(site_thresholds, tails, a_week)
        for runner in runners:
            runner.set_needs(found.of.get((runner.address, runner.word), ()))
        self._found[live.name] = (found.basis, found.blocks, found.needed)

    def _a_week(self, live: LiveSite) -> float:
        return self._said.get(live.name, _described(live))

    async def _look_after(self, live: LiveSite) -> None:
        if live.name not in self._known:
            kept = (await self._learned.states_of(live.name)).get(_ASKED)
            said = None if kept is None else msgspec.msgpack.decode(kept, type=float | None)
            self._known.add(live.name)
            if said is not None:
                self._said[live.name] = said
        await self.adjust_site(live)
        if self._a_week(live) > 0.0:
            await self._save_tails(live, most=_SAVES)

    async def _fill_tails(self, live: LiveSite) -> None:
        """Let new detectors look at the stored history, one after the other."""
        thin = {wish.address for wish in wanted_detectors(live.description)[0] if wish.thin}
        description = live.description
        for runner in self._service.detectors_of(live.name):
            tail = runner.tail
            if tail is None or tail.filled:
                continue
            # One that is named at a signal sees every sample; rows of a second show it others.
            if isinstance(runner, GroupRunner) or runner.address in thin:
                trial = _trial_of(runner)
                past = await self._see_past(live, trial)
                # It may have been described anew meanwhile, or asked for no more.
                if live.description is not description or runner.tail is not tail:
                    return
                tail.add_past(past)
                if isinstance(runner, GroupRunner) and isinstance(trial, _GroupPast):
                    runner.take_residuals(trial.runner)
                await self.adjust_site(live)
            tail.filled = True

    async def _see_past(self, live: LiveSite, trial: _SignalPast | _GroupPast) -> ScoreTail:
        """Show the stored history to a new detector; give what it said of it."""
        tail = ScoreTail()
        now_us = self._clock.wall_ns() // 1000
        parts = read_past_rows(
            self._history,
            live.name,
            trial.addresses,
            from_us=max(0, now_us - _FILLED_US),
            to_us=now_us,
            step_us=trial.step_us,
        )
        async for part in parts:
            for first in range(0, len(part.time_us), trial.rows_at_once):
                began = time.perf_counter()
                trial.see_rows(part, slice(first, first + trial.rows_at_once), tail)
                await asyncio.sleep(max(_SLICE_S, time.perf_counter() - began) * _REST)
        return tail

    async def _save_tails(self, live: LiveSite, *, most: int | None) -> None:
        now = self._clock.monotonic_ns() / 1e9
        due = [
            runner
            for runner in self._service.detectors_of(live.name)
            if runner.tail is not None
            and (
                most is None
                or now - self._saved_at.get((live.name, runner.address, runner.word), -1e9)
                >= _SAVE_EVERY_S
            )
        ][:most]
        await self._learned.save_states(
            [
                (live.name, runner.address, tail_word(runner.word), runner.dump_tail())
                for runner in due
            ]
        )
        for runner in due:
            self._saved_at[live.name, runner.address, runner.word] = now


class _SignalPast:
    """A detector of one signal on rows of the past."""

    step_us = 1_000_000
    rows_at_once = _ROWS

    def __init__(self, runner: DetectorRunner) -> None:
        self._runner = DetectorRunner(runner.address, runner.unit, runner.watch)
        self.addresses = [runner.address]

    def see_rows(self, part: PastRows, rows: slice, tail: ScoreTail) -> None:
        values = part.values[rows, 0]
        there = np.isfinite(values)
        self._runner.rate_past(part.time_us[rows][there], values[there], tail)


class _GroupPast:
    """A group on rows of the past."""

    rows_at_once = 32

    def __init__(self, runner: GroupRunner) -> None:
        self.runner = GroupRunner(runner.group)
        described = runner.group.group
        self._has_state = bool(described.state)
        self.addresses = [*runner.watched, *([described.state] if self._has_state else [])]
        self.step_us = round(described.step * 1e6)
        self._state = -1

    def see_rows(self, part: PastRows, rows: slice, tail: ScoreTail) -> None:
        values, states = part.values[rows], [-1] * len(part.values[rows])
        if self._has_state:
            values, told = values[:, :-1], values[:, -1].tolist()
            states = [self._hold_state(state) for state in told]
        self.runner.rate_past(part.time_us[rows], values, states, tail=tail)

    def _hold_state(self, told: float) -> int:
        # A state holds until another comes; NaN is not equal to itself.
        self._state = int(told) if told == told and told >= 0 else self._state
        return self._state


def _trial_of(runner: EpisodeRunner) -> _SignalPast | _GroupPast:
    if isinstance(runner, GroupRunner):
        return _GroupPast(runner)
    if isinstance(runner, DetectorRunner):
        return _SignalPast(runner)
    raise TypeError(f"a {type(runner).__name__} is not tried on the past")


def _takes_part(runner: EpisodeRunner) -> bool:
    return bool(runner.magnitudes())


def _described(live: LiveSite) -> float:
    services = live.description.services
    return 0.0 if services is None else services.false_alarms_a_week
