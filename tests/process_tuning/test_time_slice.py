"""A thread that asks for a shorter time slice gets it, alone, and keeps its priority."""

from __future__ import annotations

import os
import platform
import threading
from pathlib import Path

import pytest

from talaia.process_tuning.time_slice import shorten_time_slice

pytestmark = pytest.mark.skipif(
    platform.machine() not in {"x86_64", "aarch64"} or platform.system() != "Linux",
    reason="needs Linux on x86_64 or aarch64",
)


def slice_ns(thread: int) -> int:
    """Give a thread's time slice as the kernel shows it (ns); 0 where it does not."""
    for line in Path(f"/proc/self/task/{thread}/sched").read_text().splitlines():
        if line.startswith("se.slice"):
            return int(line.split(":")[1])
    return 0


def in_thread(does) -> object:
    """Do something in a thread of its own; give what it gives."""
    found: list[object] = []
    thread = threading.Thread(target=lambda: found.append(does()))
    thread.start()
    thread.join()
    return found[0]


def test_thread_that_asks_has_a_shorter_slice_and_its_priority_and_those_it_starts_have_not() -> (
    None
):
    def ask() -> tuple[bool, int, int, object]:
        priority = os.getpriority(os.PRIO_PROCESS, 0)
        taken = shorten_time_slice()
        changed = os.getpriority(os.PRIO_PROCESS, 0) - priority
        started = in_thread(lambda: slice_ns(threading.get_native_id()))
        return taken, slice_ns(threading.get_native_id()), changed, started

    usual = in_thread(lambda: slice_ns(threading.get_native_id()))
    taken, own, changed, started = in_thread(ask)  # type: ignore[misc]
    assert taken
    assert changed == 0
    assert started == usual
    release = tuple(int(part) for part in platform.release().split(".")[:2])
    # Older kernels show no slice, or take no own one.
    if usual and release >= (6, 12):
        assert own == 200_000 < usual
