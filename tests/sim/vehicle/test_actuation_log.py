"""The record of what moved the vehicle."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from talaia.clock import SECOND, HandClock
from talaia.sim.vehicle.actuation_log import ActuationLog
from talaia.sim.vehicle.base import Change, MotionSource

if TYPE_CHECKING:
    from pathlib import Path


def test_a_change_is_in_the_file_at_once_with_both_clocks(tmp_path: Path) -> None:
    clock = HandClock(wall_ns=5 * SECOND, monotonic_ns=7)
    log = ActuationLog(tmp_path / "log.jsonl", clock)
    log.write_change(Change(MotionSource.TWIST, 0.2, -0.5))
    log.write_change(None)
    clock.advance(3)
    log.write_change(Change(MotionSource.TIME_OUT, 0.0, 0.0))
    lines = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    log.close()
    assert lines == [
        {"wall_ns": 5 * SECOND, "monotonic_ns": 7, "source": "cmd_vel", "v": 0.2, "w": -0.5},
        {"wall_ns": 5 * SECOND + 3, "monotonic_ns": 10, "source": "timeout", "v": 0.0, "w": 0.0},
    ]


def test_without_a_file_nothing_is_written() -> None:
    log = ActuationLog(None, HandClock())
    log.write_change(Change(MotionSource.STOP, 0.0, 0.0))
    log.close()
