"""Which devices are there, by the ROS master's graph and a question to their nodes.

A node that was killed stays registered at the master for good, so nodes of a silent device are
asked themselves (``getPid``, which any node answers).
"""

from __future__ import annotations

import asyncio
import contextlib
from functools import partial
from typing import TYPE_CHECKING

from talaia.gateway.adapters.presence import LOOK_S, DeviceEndpoints, DevicePresence
from talaia.gateway.errors import AdapterLost
from talaia.model.connection import topic_of
from talaia.model.site import CommandKind

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.ros1.master import GraphState, RosMaster

__all__ = ["Ros1Presence"]

_GRAPH_EVERY = 4


class Ros1Presence:
    """All devices of a scope. On the event loop, but for ``heard_ns``.

    Attributes:
        heard_ns: by topic: when a message came last, monotonic. Written by any thread.

    """

    def __init__(
        self,
        scope: ConnectionScope,
        master: RosMaster,
        clock: Clock,
        tell: Callable[[str, str, bool], None],
    ) -> None:
        """Take who is asked; ``tell`` as in `DevicePresence`."""
        self._master, self._clock = master, clock
        self.heard_ns: dict[str, int] = {}
        self._topics = {
            name: {
                topic for signal in device.signals.values() if (topic := topic_of(signal.source))
            }
            for name, device in scope.devices.items()
        }
        self._services = {
            name: {
                command.target
                for command in device.commands.values()
                if command.kind is CommandKind.SERVICE
            }
            for name, device in scope.devices.items()
        }
        self._offers: dict[str, DeviceEndpoints] = {}
        self._presence = DevicePresence(scope.devices, tell)
        self._asking: dict[str, asyncio.Future[bool]] = {}

    async def run(self) -> None:
        """Look and ask until cancelled."""
        loop = asyncio.get_running_loop()
        turn = 0
        while True:
            if turn % _GRAPH_EVERY == 0:
                # A master that is gone is told by who watches over it.
                with contextlib.suppress(AdapterLost):
                    graph = await loop.run_in_executor(None, self._master.read_graph)
                    self._offers = {name: self._endpoints_of(name, graph) for name in self._topics}
            turn += 1
            heard = {
                name: max((self.heard_ns.get(topic, 0) for topic in topics), default=0)
                for name, topics in self._topics.items()
            }
            for node in self._presence.judge_devices(
                self._clock.monotonic_ns(), self._offers, heard
            ):
                if node not in self._asking:
                    asked = loop.run_in_executor(None, self._master.ping_node, node)
                    self._asking[node] = asked
                    asked.add_done_callback(partial(self._on_answer, node))
            await asyncio.sleep(LOOK_S)

    def _on_answer(self, node: str, asked: asyncio.Future[bool]) -> None:
        self._asking.pop(node, None)
        if asked.cancelled() or asked.exception() is not None:
            # The master is gone, see above.
            return
        if asked.result():
            self._presence.mark_alive(node, self._clock.monotonic_ns())
        else:
            self._presence.mark_dead(node)

    def _endpoints_of(self, device: str, graph: GraphState) -> DeviceEndpoints:
        places, names = (
            (graph.published, self._topics[device])
            if self._topics[device]
            else (graph.services, self._services[device])
        )
        nodes = frozenset(node for name in names for node in places.get(name, ()))
        return DeviceEndpoints(bool(nodes), nodes, nodes)
