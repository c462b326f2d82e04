"""Writes down every change of the wanted velocity, with the vehicle's own clock."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.clock import Clock
    from talaia.sim.vehicle.base import Change

__all__ = ["ActuationLog"]


class ActuationLog:
    """One JSON object a line: ``wall_ns``, ``monotonic_ns``, ``source``, ``v`` m/s, ``w`` rad/s.

    ``lateral`` (m/s) and ``steering`` (rad) stand there where they are not zero.

    A line is in the file when `write_change` returns, so that another program may follow it.

    Args:
        path: the file, begun anew; None writes nothing.
        clock: the vehicle's clock.

    Raises:
        OSError: the file cannot be written.

    """

    def __init__(self, path: Path | None, clock: Clock) -> None:
        """Open the file."""
        self._file = path.open("w", buffering=1, encoding="utf-8") if path else None
        self._clock = clock

    def write_change(self, change: Change | None) -> None:
        """Write a change down; None is none."""
        if self._file is None or change is None:
            return
        line = {
            "wall_ns": self._clock.wall_ns(),
            "monotonic_ns": self._clock.monotonic_ns(),
            "source": change.source.value,
            "v": change.speed,
            "w": change.turn,
        }
        more = {"lateral": change.lateral, "steering": change.steering}
        line |= {name: value for name, value in more.items() if value != 0}
        self._file.write(json.dumps(line) + "\n")

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None
