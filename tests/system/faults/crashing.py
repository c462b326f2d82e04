"""Run one word of ``talaia`` with a trouble: death at a named point, or a wall clock gone wrong.

    TALAIA_CRASH_AT=POINT python crashing.py WORD …
    TALAIA_CLOCK_OFFSET_S=3600 python crashing.py WORD …

The product knows nothing of this: no hook, no variable, nothing to be switched on by mistake or
by malice. This starter replaces a function by one that kills the process before it or after it
(as if by ``kill -9``), or shifts what the wall clock says after a moment, and then calls the
command line as always. A point that is no longer there fails loudly.
"""

from __future__ import annotations

import importlib
import os
import signal
import sys
import time
from collections.abc import Callable
from typing import Any, NamedTuple


class Point(NamedTuple):
    """A place in the code: module, dotted name, before or after, and at which call."""

    module: str
    name: str
    after: bool = False
    call: int = 1


_INDEX = "talaia.hub.history.writing.block_index"
_SPOOL = "talaia.gateway.spool.journal"
_REGISTRY = "talaia.hub.store.sites.site_registry"
POINTS = {
    "hub-before-commit": Point(_INDEX, "BlockIndex._write_draft", call=10),
    "hub-in-commit": Point(_INDEX, "BlockIndex._write_draft", after=True, call=10),
    "hub-after-commit": Point(_INDEX, "BlockIndex.commit_jobs", after=True, call=10),
    "hub-mid-migration": Point(
        "alembic.runtime.migration", "HeadMaintainer.update_to_step", call=2
    ),
    "hub-before-description": Point(_REGISTRY, "SiteRegistry.said_hello"),
    "hub-after-description": Point("talaia.hub.live.gateways.ingest", "Ingest.first_missing"),
    "spool-before-rotation": Point(_SPOOL, "Spool._begin_segment", call=2),
    "spool-mid-rotation": Point(_SPOOL, "Spool._begin_segment", after=True, call=2),
    "spool-before-removal": Point(_SPOOL, "Spool._remove_segment"),
    "spool-after-removal": Point(_SPOOL, "Spool._remove_segment", after=True),
}  # fmt: skip


def arm(point: Point) -> None:
    """Replace the function.

    Raises:
        AttributeError: the code has no such place any more.

    """
    holder: Any = importlib.import_module(point.module)
    *path, last = point.name.split(".")
    for each in path:
        holder = getattr(holder, each)
    original: Callable[..., Any] = getattr(holder, last)
    calls = 0

    def dying(*args: Any, **kwargs: Any) -> Any:
        nonlocal calls
        calls += 1
        if calls == point.call and not point.after:
            os.kill(os.getpid(), signal.SIGKILL)
        result = original(*args, **kwargs)
        if calls == point.call:
            os.kill(os.getpid(), signal.SIGKILL)
        return result

    setattr(holder, last, dying)


def shift(offset_s: float, after_s: float = 2.0) -> None:
    """Let the wall clock jump a little after the start, as when the machine finds the time."""
    from talaia.clock import SystemClock

    began = time.monotonic()
    original = SystemClock.wall_ns

    def wall_ns(self: SystemClock) -> int:
        jumped = time.monotonic() - began > after_s
        return max(0, original(self) + (round(offset_s * 1e9) if jumped else 0))

    SystemClock.wall_ns = wall_ns  # type: ignore[method-assign]


def main() -> int:
    """Arm and run."""
    if point := os.environ.get("TALAIA_CRASH_AT"):
        arm(POINTS[point])
    if offset := os.environ.get("TALAIA_CLOCK_OFFSET_S"):
        shift(float(offset))
    from talaia.cli.main import main as talaia

    sys.argv[0] = "talaia"
    return int(talaia() or 0)


if __name__ == "__main__":
    raise SystemExit(main())
