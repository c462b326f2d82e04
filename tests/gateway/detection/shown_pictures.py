"""What tests of a watched camera share: the robot's camera, and the processes that look."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import psutil

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from pathlib import Path

    from gateway_bench import Peer

HEIGHT, WIDTH = 48, 64


@asynccontextmanager
async def showing(peer: Peer, tmp_path: Path, name: str) -> AsyncIterator[Callable[[str], None]]:
    """Let the robot's camera show one picture after the other; what is called names the next."""
    shown = [name]

    async def show() -> None:
        while True:
            before = len(peer.heard("shown"))
            await peer.do(
                "show", file=str(tmp_path / shown[0]), height=HEIGHT, width=WIDTH,
                seconds=0.2, hz=30,
            )  # fmt: skip
            await peer.until(lambda before=before: len(peer.heard("shown")) > before)

    task = asyncio.ensure_future(show())
    try:
        yield lambda next_: shown.__setitem__(0, next_)
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def children() -> list[psutil.Process]:
    return [
        child
        for child in psutil.Process().children()
        if child.status() != psutil.STATUS_ZOMBIE and "talaia.objects.child" in child.cmdline()
    ]
