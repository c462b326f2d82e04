"""What a detector would have said of stored history, tried before it is switched on.

Long, because what is tried, how far a test is, and what it may take of the machine is one matter.
"""

from __future__ import annotations

import asyncio
import logging
import secrets
import time
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from talaia.errors import TalaiaError
from talaia.hub.anomaly.episode_runner import AnomalyEnded
from talaia.hub.live.detection.past_rows import read_past_rows

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from talaia.hub.anomaly.episode_runner import AnomalyBegan, EpisodeRunner
    from talaia.hub.anomaly.groups.group_runner import GroupRunner
    from talaia.hub.anomaly.groups.whitening import SignalShare
    from talaia.hub.anomaly.runner import DetectorRunner
    from talaia.hub.live.detection.past_rows import PastRows
    from talaia.hub.ports import History

__all__ = [
    "MOST_RUNNING",
    "BackTest",
    "BackTests",
    "GroupTrial",
    "PastAnomaly",
    "SignalTrial",
    "TestState",
    "TooManyTests",
]

_LOG = logging.getLogger(__name__)
# At most so many compute at once, and so many are remembered.
MOST_RUNNING, _MOST_KEPT = 2, 20
# Of a test so many anomalies are kept, and the greatest score of so many parts of its window.
_MOST_ANOMALIES, _PARTS = 200, 300
# It computes so long and lets all else have as long: half of a core at the most. In a thread of its
# own nobody waits for it meanwhile, and few long stretches take less than many short ones.
_SLICE_S, _THREAD_SLICE_S = 0.001, 0.05


class TestState(StrEnum):
    """How a test stands."""

    RUNNING = "running"
    DONE = "done"
    CANCELLED = "cancelled"
    FAILED = "failed"


class TooManyTests(Exception):
    """Others compute; it can be tried again later."""


class PastTrial(Protocol):
    """A detector that is shown the past, row by row.

    Attributes:
        addresses: of the channels that make a row.
        step_us: a row is so long.
        learns_us: so long before the window it begins, so that it has learned.
        rows_at_once: so many are looked at between two glances at the clock.
        in_thread: they are mostly work of NumPy, during which others may have the interpreter.

    """

    addresses: Sequence[str]
    step_us: int
    learns_us: int
    rows_at_once: int
    in_thread: bool

    @property
    def runner(self) -> EpisodeRunner:
        """The detector, as it is at work live."""
        ...

    def see_rows(
        self, times: NDArray[np.int64], rows: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], list[_Ended]]:
        """Look at the next rows (n,), (n, addresses), NaN where nothing came.

        Returns:
            The score after each (n,), and what ended.

        """
        ...


class _Ended(NamedTuple):
    """An anomaly that is over, and who had what to do with it, of a group."""

    turn: AnomalyEnded
    shares: list[SignalShare]


class SignalTrial:
    """A detector of one signal, shown one sample a second."""

    step_us = 1_000_000

    def __init__(self, runner: DetectorRunner) -> None:
        """Try ``runner``, which has seen nothing yet."""
        self.runner = runner
        self.addresses: Sequence[str] = (runner.address,)
        # Twice its learning, for a signal may come seldom.
        self.learns_us = 2 * runner.learning * self.step_us
        # One by one nothing else is answered meanwhile: a few milliseconds, then.
        self.in_thread = runner.detector.faster_many
        self.rows_at_once = 512 if self.in_thread else 64

    def see_rows(
        self, times: NDArray[np.int64], rows: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], list[_Ended]]:
        """See `PastTrial.see_rows`; of silence no detector that can be tried has an opinion."""
        there = np.isfinite(rows[:, 0])
        scores = np.full(len(times), self.runner.score)
        scores[there], turns = self.runner.score_many(times[there], rows[there, 0])
        return scores, [_Ended(turn, []) for turn in turns if isinstance(turn, AnomalyEnded)]


class GroupTrial:
    """A group of signals."""

    rows_at_once = 8
    in_thread = False

    def __init__(self, runner: GroupRunner) -> None:
        """Try ``runner``, which has seen nothing yet."""
        self.runner = runner
        group = runner.group
        self._has_state = bool(group.group.state)
        self.addresses: Sequence[str] = (
            *group.signals,
            *([group.group.state] if self._has_state else []),
        )
        self.step_us = round(group.group.step * 1e6)
        self.learns_us = group.group.learn * self.step_us
        self._state = -1

    def see_rows(
        self, times: NDArray[np.int64], rows: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], list[_Ended]]:
        """See `PastTrial.see_rows`."""
        scores = np.empty(len(times))
        ended: list[_Ended] = []
        for at, (time_us, row) in enumerate(zip(times.tolist(), rows.tolist(), strict=True)):
            turn = self._see_row(time_us, row)
            if isinstance(turn, AnomalyEnded):
                # Taken now: the next anomaly has shares of its own.
                ended.append(_Ended(turn, list(self.runner.shares)))
            scores[at] = self.runner.score
        return scores, ended

    def _see_row(self, time_us: int, row: Sequence[float]) -> AnomalyBegan | AnomalyEnded | None:
        values = row
        if self._has_state:
            values, state = row[:-1], row[-1]
            # A state holds until another comes; NaN is not equal to itself.
            self._state = int(state) if state == state and state >= 0 else self._state
        return self.runner.score_row(time_us, values, self._state)


@dataclass(slots=True)
class PastAnomaly:
    """An anomaly that would have been told; the shares are those of a group."""

    from_us: int
    to_us: int
    score: float
    why: str
    shares: list[SignalShare] = field(default_factory=list)


@dataclass(slots=True, kw_only=True)
class BackTest:
    """A test, how far it is, and what it found.

    Attributes:
        key: by which it is asked for.
        site: whose history it is.
        trial: what is tried.
        from_us: where its window begins (µs, UTC); to_us: where it ends.
        state: how it stands; `problem` says why it failed.
        done_us: it has got so far.
        rows: it has looked at so many; none of them are those it learned from before the window.
        cpu_s: it has computed for so long.
        count: so many anomalies there were; the first ones are in `anomalies`.
        scores: the greatest score of each part of the window, -1 where there was none.
        learning: so many samples it had still to learn at the window's beginning.

    """

    key: str
    site: str
    trial: PastTrial
    from_us: int
    to_us: int
    state: TestState = TestState.RUNNING
    problem: str = ""
    done_us: int = 0
    rows: int = 0
    cpu_s: float = 0.0
    count: int = 0
    anomalies: list[PastAnomaly] = field(default_factory=list)
    scores: list[float] = field(default_factory=lambda: [-1.0] * _PARTS)
    learning: int = 0

    @property
    def progress(self) -> float:
        """How much of it is done, 0 to 1."""
        begin = self.from_us - self.trial.learns_us
        return min(1.0, max(0.0, (self.done_us - begin) / max(1, self.to_us - begin)))

    def see_slice(self, part: PastRows, at: int, most_s: float) -> tuple[int, float]:
        """Look at the rows of ``part`` from ``at`` on, for about ``most_s``.

        Returns:
            Up to which row it came, and how long it computed (s).

        """
        began, spent = time.perf_counter(), time.thread_time()
        while at < len(part.time_us) and time.perf_counter() - began < most_s:
            upto = at + self.trial.rows_at_once
            self.see_rows(part.time_us[at:upto], part.values[at:upto])
            at = upto
        computed = time.thread_time() - spent
        self.cpu_s += computed
        self.done_us = int(part.time_us[min(at, len(part.time_us)) - 1])
        return at, computed

    def see_rows(self, times: NDArray[np.int64], rows: NDArray[np.float64]) -> None:
        """Look at the next rows: times (µs) (n,), values (n, addresses)."""
        # Of anomalies that nobody will see, nobody asks why.
        self.trial.runner.says_why = len(self.anomalies) < _MOST_ANOMALIES
        first = int(np.searchsorted(times, self.from_us))
        if first:
            self._take_all(self.trial.see_rows(times[:first], rows[:first])[1])
        if first == len(times):
            return
        if not self.rows:
            self.learning = self.trial.runner.learning
        scores, ended = self.trial.see_rows(times[first:], rows[first:])
        self.rows += len(scores)
        parts = (times[first:] - self.from_us) * _PARTS // (self.to_us - self.from_us)
        for part in np.unique(parts).tolist():
            at = min(_PARTS - 1, part)
            self.scores[at] = max(self.scores[at], float(scores[parts == part].max()))
        self._take_all(ended)

    def _take_all(self, ended: Sequence[_Ended]) -> None:
        for one in ended:
            self.take_ended(one.turn, one.shares)

    def take_ended(self, ended: AnomalyEnded, shares: list[SignalShare]) -> None:
        """Note an anomaly; one that was over before the window is none of it."""
        if ended.ended_us < self.from_us:
            return
        self.count += 1
        if len(self.anomalies) < _MOST_ANOMALIES:
            self.anomalies.append(
                PastAnomaly(ended.began_us, ended.ended_us, ended.score, ended.why, shares)
            )


class BackTests:
    """The tests of a hub; they are forgotten with it."""

    def __init__(self, history: History) -> None:
        """Read from ``history``."""
        self._history = history
        # In the order in which they were begun, by key; with what computes each that goes on.
        self._tests: dict[str, BackTest] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}

    def begin_test(self, site: str, trial: PastTrial, from_us: int, to_us: int) -> BackTest:
        """Begin a test.

        Raises:
            TooManyTests: as many compute as may at once.

        """
        if len(self._tasks) >= MOST_RUNNING:
            raise TooManyTests
        test = BackTest(
            key=secrets.token_hex(8), site=site, trial=trial, from_us=from_us, to_us=to_us
        )
        self._tests[test.key] = test
        task = self._tasks[test.key] = asyncio.create_task(self._run_test(test))
        task.add_done_callback(lambda _done: self._tasks.pop(test.key, None))
        for key in [key for key in self._tests if key not in self._tasks][:-_MOST_KEPT]:
            del self._tests[key]
        return test

    def find_test(self, site: str, key: str) -> BackTest | None:
        """Find a test of a site."""
        test = self._tests.get(key)
        return test if test is not None and test.site == site else None

    def cancel_test(self, test: BackTest) -> None:
        """End a test; one that is over stays as it is."""
        task = self._tasks.get(test.key)
        if task is not None:
            task.cancel()
            test.state = TestState.CANCELLED

    async def close(self) -> None:
        """End all tests."""
        tasks = list(self._tasks.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _run_test(self, test: BackTest) -> None:
        try:
            await self._show_past(test)
        except (TalaiaError, OSError) as error:
            test.state, test.problem = TestState.FAILED, str(error)
        except (ArithmeticError, LookupError, ValueError) as error:
            _LOG.exception("a test of %s failed", test.trial.runner.address)
            test.state, test.problem = TestState.FAILED, f"the detector fails: {error}"
        else:
            if (ended := test.trial.runner.end_anomaly()) is not None:
                test.take_ended(ended, list(test.trial.runner.shares))
            test.state, test.done_us = TestState.DONE, test.to_us

    async def _show_past(self, test: BackTest) -> None:
        trial = test.trial
        parts = read_past_rows(
            self._history,
            test.site,
            trial.addresses,
            from_us=test.from_us - trial.learns_us,
            to_us=test.to_us,
            step_us=trial.step_us,
        )
        async for part in parts:
            at = 0
            while at < len(part.time_us):
                if trial.in_thread:
                    at, computed = await asyncio.to_thread(
                        test.see_slice, part, at, _THREAD_SLICE_S
                    )
                else:
                    at, computed = test.see_slice(part, at, _SLICE_S)
                await asyncio.sleep(computed)
            test.done_us = part.past_us
