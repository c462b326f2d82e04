"""Which devices are there, by ROS 2's graph and a question to their nodes. On the wait-set thread.

The question is ``get_parameters`` of no parameter at all, which every node offers that was not
told to leave its parameter services away; of others only the graph tells.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rcl_interfaces.srv import GetParameters

from talaia.gateway.adapters.presence import Deafness, DeviceEndpoints, DevicePresence
from talaia.model.connection import RosSource, source_as, topic_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.clock import Clock
    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.adapters.ros2.services import Ros2Commands
    from talaia.model.connection import Source

__all__ = ["Ros2Presence"]

# The graph is read at every fourth look: that costs some milliseconds.
_GRAPH_EVERY = 4
_UNKNOWN = "_NODE_NAME_UNKNOWN_"


class Ros2Presence:
    """All devices of a scope."""

    def __init__(
        self,
        *,
        scope: ConnectionScope,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        thread: WaitThread,
        clock: Clock,
        commands: Ros2Commands,
        heard_ns: Mapping[str, int],
        tell: Callable[[str, str, bool], None],
        deafness: Deafness,
        rejoin: Callable[[str], None],
    ) -> None:
        """Take who is asked; ``tell`` as in `DevicePresence`.

        ``heard_ns`` tells when a message came last, monotonic, by topic;
        ``rejoin`` is called with a reason when nobody is heard, see ``deafness``.
        """
        self._node, self._thread, self._clock, self._commands = node, thread, clock, commands
        self._heard_ns = heard_ns
        self._topics = {
            name: {
                topic for signal in device.signals.values() if (topic := topic_of(signal.source))
            }
            for name, device in scope.devices.items()
        }
        # The nodes that say what devices without a topic are like.
        self._owners = {
            name: frozenset(filter(None, (_owner_of(s.source) for s in device.signals.values())))
            for name, device in scope.devices.items()
        }
        self._clients: dict[str, Any] = {}
        self._offers: dict[str, DeviceEndpoints] = {}
        self._tell = tell
        self._deafness, self._rejoin = deafness, rejoin
        self._presence = DevicePresence(scope.devices, self._on_change)
        self._turn = 0

    def judge_devices(self) -> None:
        """Read the graph now and then, judge, and ask."""
        if self._turn % _GRAPH_EVERY == 0:
            self._offers = {name: self._offer(name) for name in self._topics}
        self._turn += 1
        heard = {
            name: max((self._heard_ns.get(topic, 0) for topic in topics), default=0)
            for name, topics in self._topics.items()
        }
        for name in self._presence.judge_devices(self._clock.monotonic_ns(), self._offers, heard):
            self._clients[name].handle.send_request(GetParameters.Request(names=[]))
        if self._deafness.should_rejoin(deaf=self._presence.deaf):
            self._rejoin("nobody of all who are there is heard or answers; joining anew")

    def _on_change(self, device: str, why: str, sure: bool) -> None:  # noqa: FBT001 - as `DevicePresence`
        # A node that does not answer may be busy with just that call; one that has left is not.
        if why and sure:
            self._commands.cut(device)
        self._tell(device, why, sure)

    def _offer(self, device: str) -> DeviceEndpoints:
        topics = self._topics[device]
        if topics:
            nodes = frozenset(
                f"{info.node_namespace.rstrip('/')}/{info.node_name}"
                for topic in topics
                for info in self._node.get_publishers_info_by_topic(topic)
            )
        elif owners := self._owners[device]:
            found = self._node.get_node_names_and_namespaces()
            nodes = owners & {f"{space.rstrip('/')}/{name}" for name, space in found}
        else:
            return DeviceEndpoints(self._commands.offered(device))
        return DeviceEndpoints(
            there=bool(nodes),
            nodes=nodes,
            askable=frozenset(node for node in nodes if self._askable(node)),
            nameless=any(node.endswith(_UNKNOWN) for node in nodes),
        )

    def _askable(self, node: str) -> bool:
        if node.endswith(_UNKNOWN):
            return False
        client = self._clients.get(node)
        if client is None:
            # Made before it is needed: nobody finds the services of a process that is gone.
            client = self._node.create_client(GetParameters, f"{node}/get_parameters")
            self._clients[node] = client

            def on_answer(_number: int, _response: object) -> None:
                self._presence.mark_alive(node, self._clock.monotonic_ns())

            self._thread.add_client(client.handle, GetParameters.Response, on_answer)
        return bool(client.service_is_ready())


def _owner_of(source: Source) -> str:
    """Name the node that a parameter or a life cycle is of; empty for other sources."""
    ros = source_as(source, RosSource)
    return ros.lifecycle or ros.parameter.rpartition("/")[0]
