"""How a program ends that the hub started in a group of its own: by itself, or with its group."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
from typing import NamedTuple

__all__ = ["ChildEnd", "finish_child"]


class ChildEnd(NamedTuple):
    """What a program ended with.

    Attributes:
        code: 0 is well.
        last_line: of what it said on its standard error; it may be empty.

    """

    code: int
    last_line: str


async def finish_child(
    child: asyncio.subprocess.Process, longest_s: float, given: bytes | None = None
) -> ChildEnd:
    """Wait for a program's end; whoever stops waiting ends it, and all that it started.

    Args:
        child: leads a group of its own, and its standard error is a pipe.
        longest_s: so long (s).
        given: for its standard input.

    Raises:
        TimeoutError: it took longer.

    """
    try:
        async with asyncio.timeout(longest_s):
            _, said = await child.communicate(given)
    finally:
        # Also when the wait is given up: nothing outlives the wish for it.
        if child.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)
            await child.wait()
    last = said.decode("utf-8", "replace").strip().splitlines()[-1:]
    return ChildEnd(await child.wait(), "".join(last))
