"""A gateway whose ROS 2 is another Python's, as a process, and that Python."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import sys
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from patience import PATIENCE_S

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

HERE = Path(__file__).parent
OTHER_PYTHON = os.environ.get("TALAIA_TEST_ROS_PYTHON", sys.executable)


def bridged_environment(python: str = OTHER_PYTHON) -> dict[str, str]:
    paths = [str(each) for each in (HERE.parents[1], HERE.parents[2], HERE.parents[3] / "src")]
    changed = {"TALAIA_ROS_PYTHON": python, "PYTHONPATH": os.pathsep.join(paths)}
    return {**os.environ, **changed}


@asynccontextmanager
async def bridged(
    url: str, data: Path, *more: str, python: str = OTHER_PYTHON
) -> AsyncIterator[asyncio.subprocess.Process]:
    gateway = await asyncio.create_subprocess_exec(
        sys.executable, str(HERE / "bridged_gateway.py"), url, str(data), *more,
        stdin=asyncio.subprocess.PIPE, env=bridged_environment(python),
    )  # fmt: skip
    try:
        yield gateway
    finally:
        assert gateway.stdin is not None
        gateway.stdin.close()
        with contextlib.suppress(ProcessLookupError):
            gateway.send_signal(signal.SIGCONT)
        await asyncio.wait_for(gateway.wait(), PATIENCE_S)


def children_of(pid: int) -> list[int]:
    found = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    # Threads have children of their own.
    for task in Path(f"/proc/{pid}/task").iterdir():
        found += (task / "children").read_text().split()
    return sorted({int(each) for each in found})


def bridge_of(pid: int) -> int:
    (found,) = (
        each for each in children_of(pid)
        if b"ros2/bridge.py" in Path(f"/proc/{each}/cmdline").read_bytes()
    )  # fmt: skip
    return found
