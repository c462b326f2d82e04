"""The limit for pictures, told to and asked by several threads."""

from __future__ import annotations

import os
import threading

from talaia.gateway.cores.core_budget import CoreBudget

__all__ = ["SharedBudget"]


class SharedBudget:
    """The `CoreBudget` of all encoding threads of a gateway. Any thread; times are monotonic."""

    def __init__(self, cores: float = 0) -> None:
        """Begin with what this process may use, or with so many ``cores``."""
        # Not all of the machine: a container may have been given some of its cores.
        self._budget = CoreBudget(cores or len(os.sched_getaffinity(0)))
        self._lock = threading.Lock()  # Guards the budget.

    def note_lateness(self, late_us: int, now_us: int) -> None:
        """Take by how much the event loop was late just now (µs)."""
        with self._lock:
            self._budget.note_lateness(late_us, now_us)

    def spend(self, began_us: int, cpu_us: int) -> float:
        """Take what a picture cost (µs) that was begun then; give what all may take now (cores)."""
        with self._lock:
            self._budget.spend(began_us, cpu_us)
            return self._budget.room

    def rest_us(self, now_us: int) -> int:
        """Give how long no picture may begin from now on (µs)."""
        with self._lock:
            return self._budget.rest_us(now_us)
