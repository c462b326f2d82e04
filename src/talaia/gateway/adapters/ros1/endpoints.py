"""Whether a device's topics, services and actions are there, by the ROS master's graph."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.gateway.adapters.reconnection import WAIT_S, reconnection_outcome
from talaia.gateway.errors import AdapterLost
from talaia.gateway.ports import CommandOutcome
from talaia.model.site import CommandKind
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.gateway.adapters.ros1.master import GraphState, RosMaster
    from talaia.model.site import Command

__all__ = ["await_endpoints"]

_LOOK_S = 0.5


async def await_endpoints(
    master: RosMaster,
    topics: Collection[str],
    commands: Collection[Command],
    done: Callable[[CommandOutcome], None],
) -> None:
    """Wait until all is there or time is up, and tell ``done`` once how it went."""
    loop = asyncio.get_running_loop()
    until = loop.time() + WAIT_S
    while True:
        try:
            graph = await loop.run_in_executor(None, master.read_graph)
        except AdapterLost as error:
            done(CommandOutcome(CommandPhase.FAILED, str(error)))
            return
        absent = absent_endpoints(graph, topics, commands)
        if not absent or loop.time() >= until:
            done(reconnection_outcome(len(topics) + len(commands), absent))
            return
        await asyncio.sleep(_LOOK_S)


def absent_endpoints(
    graph: GraphState, topics: Collection[str], commands: Collection[Command]
) -> list[str]:
    """Name what is not there, with what is missing of it."""
    absent = [
        f"{topic} (nobody publishes it)" for topic in sorted(topics) if topic not in graph.published
    ]
    for command in commands:
        target = command.target
        if command.kind is CommandKind.SERVICE and target not in graph.services:
            absent.append(f"{target} (no such service now)")
        # An action is five topics; whoever listens to its goals is its server.
        elif command.kind is CommandKind.ACTION and f"{target}/goal" not in graph.heard:
            absent.append(f"{target} (no such action now)")
    return absent
