"""What a group of signals learns from a stretch of the history that a person calls usual."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.hub.anomaly.groups.group import FEWEST_LEARNED, most_learned
from talaia.hub.anomaly.groups.group_runner import new_modal_group
from talaia.hub.live.detection.past_rows import read_past_rows

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from talaia.hub.anomaly.groups.modal_group import ModalGroup
    from talaia.hub.ports import History
    from talaia.model.alarms.signal_groups import GroupSignals

__all__ = ["LearnedStretch", "StretchRefused", "learn_stretch", "longest_stretch_s"]

# Live samples, driving among them, wait no longer than this (s).
_SLICE_S = 0.001
# Found modes take rows in such pieces.
_PIECE = 50


class StretchRefused(Exception):
    """It cannot be learned from; the text says why, and what to do."""


class LearnedStretch(NamedTuple):
    """What was learned: the detector, from how many rows, and what of."""

    detector: ModalGroup
    rows: int
    modes: list[str]
    # States of which there was too little; they are learned as they come.
    still: list[str]


def longest_stretch_s(group: GroupSignals) -> float:
    """Give how long a stretch may be, at the most (s)."""
    return most_learned(len(group.signals)) * group.group.step


async def learn_stretch(
    history: History, site: str, group: GroupSignals, *, from_us: int, to_us: int
) -> LearnedStretch:
    """Learn what is usual from a window of the history.

    Raises:
        StretchRefused: it is too long, or there is too little in it.
        HistoryError: the database cannot be read.

    """
    if group.is_single:
        raise StretchRefused(
            f"{group.name} has one number, which is judged against others under a budget alone:"
            " there is nothing to learn from a stretch"
        )
    step_us, longest = round(group.group.step * 1e6), longest_stretch_s(group)
    if to_us - from_us > longest * 1e6:
        raise StretchRefused(
            f"expected at most {longest / 3600:.1f} h to learn from, found"
            f" {(to_us - from_us) / 3.6e9:.1f} h: choose a shorter stretch"
        )
    state = group.group.state
    addresses = [*group.signals, *([state] if state else [])]
    parts = [
        part
        async for part in read_past_rows(
            history, site, addresses, from_us=from_us, to_us=to_us, step_us=step_us
        )
    ]
    times = np.concatenate([part.time_us for part in parts]) if parts else np.empty(0, np.int64)
    if len(times) < FEWEST_LEARNED:
        raise StretchRefused(
            f"expected at least {FEWEST_LEARNED} steps of {group.group.step:g} s with samples,"
            f" found {len(times)}: choose a longer stretch, or another one"
        )
    values = np.concatenate([part.values for part in parts])
    states = _held_states(values[:, -1]) if state else np.full(len(times), -1, np.int64)
    detector = new_modal_group(group, len(times))
    if state:
        detector.expect_states(states.tolist())
    await _run_in_slices(_show_rows(detector, times, values[:, : len(group.signals)], states))
    learned = [mode for mode, member in detector.members.items() if not member.learning]
    if not learned:
        raise StretchRefused(
            f"in none of its states are there {FEWEST_LEARNED} steps to learn from: choose a"
            " longer stretch"
        )
    # From here on: what the stretch did not hold is learned as live.
    detector.learn_rows = group.group.learn
    names = group.states
    still = [name for at, name in enumerate(names) if at not in learned] if state else []
    modes = [names[at] for at in learned if at < len(names)] if state else _numbered(learned)
    return LearnedStretch(detector, len(times), modes, still)


def _numbered(modes: list[int]) -> list[str]:
    return [f"{at + 1} of {len(modes)}" for at in range(len(modes))] if len(modes) > 1 else []


def _held_states(column: NDArray[np.float64]) -> NDArray[np.int64]:
    """Give the state of each row: it holds until another comes; -1 before the first."""
    there = np.isfinite(column)
    last = np.maximum.accumulate(np.where(there, np.arange(len(column)), -1))
    return np.where(last >= 0, np.nan_to_num(column)[last], -1.0).astype(np.int64)


def _show_rows(
    detector: ModalGroup,
    times: NDArray[np.int64],
    values: NDArray[np.float64],
    states: NDArray[np.int64],
) -> Iterator[None]:
    for time_us, row, state in zip(times.tolist(), values, states.tolist(), strict=True):
        detector.see_row(time_us, row, state)
        yield
    while detector.pass_rows_on(_PIECE):
        yield


async def _run_in_slices(work: Iterator[None]) -> None:
    """Work a millisecond at a time: all else of the hub has its turn in between."""
    until = time.perf_counter() + _SLICE_S
    for _ in work:
        if time.perf_counter() > until:
            await asyncio.sleep(0)
            until = time.perf_counter() + _SLICE_S
