"""Signs of life of the ROS 1 node: has it joined, does it work, does the master know it.

A node that works is never ended, however slow its master; one that hangs is ended within some
seconds, and so is one that the master no longer knows: rospy does not register anew when the
master has begun anew.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.gateway.errors import AdapterLost

if TYPE_CHECKING:
    from talaia.gateway.adapters.ros1.master import RosMaster
    from talaia.gateway.adapters.ros1.node import NodeProcess

__all__ = ["NodeSigns"]

_LOOK_S = 0.5
# Importing rospy takes seconds where the machine has other work, too.
_START_S = 30.0
# A node that has not shown a sign of life in so many looks hangs; until it has done what it is
# told first, each of which is a question to the master, it is given more.
_MISSES = 4
_MISSES_FIRST = 20


class NodeSigns:
    """One life of the node. On the event loop."""

    def __init__(self, master: RosMaster) -> None:
        """Begin with a node that has not said anything."""
        self._master = master
        # Its name in ROS, once it has joined.
        self._name: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        # What the node has said that only its main thread says.
        self._signs = 0
        # Whether it is through with what it was told first.
        self._settled = False

    def mark_ready(self, name: str) -> None:
        """Take in that it has joined ROS."""
        if not self._name.done():
            self._name.set_result(name)

    def mark_working(self) -> None:
        """Take in that it works through what it was told."""
        self._signs += 1

    def mark_answered(self) -> None:
        """Take in its answer to a ping: all that was sent before is done."""
        self._signs += 1
        self._settled = True

    async def wait_joined(self, failed: asyncio.Future[str]) -> str:
        """Wait until it has joined; give its name.

        Args:
            failed: done when its process ends, with the reason.

        Raises:
            AdapterLost: it ended, or did not join in time.

        """
        done, _ = await asyncio.wait(
            [failed, self._name], timeout=_START_S, return_when=asyncio.FIRST_COMPLETED
        )
        if self._name in done:
            return self._name.result()
        if failed in done:
            raise AdapterLost(f"ROS 1 cannot be joined: {failed.result()}")
        raise AdapterLost(f"ROS 1 cannot be joined: its node is not there after {_START_S:g} s")

    async def watch_node(self, node: NodeProcess, name: str, failed: asyncio.Future[str]) -> None:
        """Stay until the node ends or hangs, or the master knows it no more.

        Raises:
            AdapterLost: one of that has come.

        """
        loop = asyncio.get_running_loop()
        asked = seen = missed = 0
        while True:
            asked += 1
            node.send_frame(op="ping", n=asked)
            await asyncio.wait([failed], timeout=_LOOK_S)
            if failed.done():
                raise AdapterLost(failed.result())
            # Looks are counted, not time: if this process stood still, the node is not to blame.
            missed = missed + 1 if self._signs == seen else 0
            seen = self._signs
            if missed >= (_MISSES if self._settled else _MISSES_FIRST):
                node.kill_process()
                raise AdapterLost("ROS 1's node hangs")
            # On another thread: the master may take its time-out to answer.
            if not await loop.run_in_executor(None, self._master.knows_node, name):
                raise AdapterLost(f"the ROS master at {self._master.uri} began anew")
