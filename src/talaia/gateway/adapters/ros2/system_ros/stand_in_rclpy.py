"""What stands for ``rclpy`` where ROS 2 is a system's of another Python: the parts that are used.

Names and behaviour are rclpy's, so that the adapter is the same for both; the work is done by the
bridge process (`entities`).
"""

from __future__ import annotations

import functools
import time
from contextlib import suppress
from enum import IntEnum
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.gateway.adapters.ros2.system_ros.entities import (
    Entity,
    Guard,
    JoinedContext,
    Publisher,
    ServiceClient,
    Subscription,
)
from talaia.gateway.adapters.ros2.system_ros.executor import SingleThreadedExecutor
from talaia.gateway.adapters.ros2.system_ros.process import BridgeLost
from talaia.gateway.adapters.ros2.system_ros.shared_process import SHARED

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.ros2.system_ros.types import RemoteMessage, RemoteService

__all__ = [
    "Context",
    "DurabilityPolicy",
    "HistoryPolicy",
    "Node",
    "Parameter",
    "QoSProfile",
    "ReliabilityPolicy",
    "SignalHandlerOptions",
    "SingleThreadedExecutor",
    "deserialize_message",
    "get_action_names_and_types",
    "get_rmw_implementation_identifier",
    "init",
    "rclpy_implementation",
    "try_shutdown",
]


# rclpy's own name for it.
Context = JoinedContext


class ReliabilityPolicy(IntEnum):
    """As rmw numbers them."""

    RELIABLE = 1
    BEST_EFFORT = 2


class DurabilityPolicy(IntEnum):
    """As rmw numbers them."""

    TRANSIENT_LOCAL = 1
    VOLATILE = 2


class HistoryPolicy(IntEnum):
    """As rmw numbers them."""

    KEEP_LAST = 1


class SignalHandlerOptions(IntEnum):
    """Whose signals are handled."""

    NO = 0


class QoSProfile(NamedTuple):
    """Quality of service."""

    depth: int
    history: HistoryPolicy = HistoryPolicy.KEEP_LAST
    reliability: int = ReliabilityPolicy.RELIABLE
    durability: int = DurabilityPolicy.VOLATILE


class Parameter(NamedTuple):
    """A parameter of a node; the bridge sets its own."""

    name: str
    value: object = None


def init(*, context: JoinedContext, domain_id: int | None = None, **_: object) -> None:
    """Begin a context; its node joins."""
    context.process = SHARED.join()
    context.number = context.process.next_number()
    context.process.register(context.number, context)
    context.domain = domain_id


def try_shutdown(*, context: JoinedContext) -> None:
    """End a context."""
    process, context.process = context.process, None
    if process is not None:
        process.forget(context.number)
        # One that has ended has left.
        with suppress(BridgeLost):
            process.ask("leave", node=context.number)
        SHARED.release(process)


def get_rmw_implementation_identifier() -> str:
    """Name the middleware."""
    return str(SHARED.now().hello["rmw"])


def deserialize_message(raw: bytes, kind: RemoteMessage) -> Any:  # noqa: ANN401
    """Read a message."""
    return kind.decode(raw)


def get_action_names_and_types(node: Node) -> Any:  # noqa: ANN401
    """Name the actions that are offered."""
    return node.ask_graph("get_action_names_and_types")


class Node:
    """A node, in the bridge."""

    def __init__(self, name: str, *, context: JoinedContext, **_: object) -> None:
        """Join the context's domain."""
        self._context, self._process = context, context.joined()
        context.domain = self._process.ask(
            "join", node=context.number, name=name, domain=context.domain
        )
        self.entities: list[Entity] = []

    def destroy_node(self) -> None:
        """Leave; the context's end does it."""
        for entity in self.entities:
            self._process.forget(entity.pointer)

    def create_guard_condition(self, _: object) -> Guard:
        """Make what wakes a wait set."""
        return Guard(self._context)

    def create_subscription(
        self,
        kind: RemoteMessage,
        topic: str,
        callback: Callable[[bytes], None],
        quality: QoSProfile,
        **_: object,
    ) -> Subscription:
        """Subscribe to raw messages."""
        made = Subscription(self._context, kind, topic, quality)
        made.callback = callback
        self.entities.append(made)
        return made

    def create_client(self, kind: RemoteService, service: str) -> ServiceClient:
        """Make a client."""
        made = ServiceClient(self._context, kind, service)
        self.entities.append(made)
        return made

    def create_publisher(self, kind: RemoteMessage, topic: str, quality: Any) -> Publisher:  # noqa: ANN401
        """Make a publisher."""
        return Publisher(self._context, kind, topic, quality)

    def destroy_subscription(self, subscription: Subscription) -> None:
        """End a subscription."""
        self.entities.remove(subscription)
        subscription.destroy()

    def destroy_client(self, client: ServiceClient) -> None:
        """End a client."""
        self.entities.remove(client)
        client.destroy()

    def destroy_publisher(self, publisher: Publisher) -> None:
        """End a publisher."""
        publisher.destroy()

    def get_clock(self) -> WallClock:
        """Give the machine's clock: the bridge's process is on the same machine."""
        return WallClock()

    # ── the graph ──

    def ask_graph(self, question: str, *words: object) -> Any:  # noqa: ANN401
        """Ask rclpy's node in the bridge; rows and endpoints come as rclpy has them."""
        told = self._process.ask(
            "graph", node=self._context.number, question=question, words=list(words)
        )
        if question.endswith("_info_by_topic"):
            return [_endpoint(one) for one in told]
        return [tuple(row) for row in told] if isinstance(told, list) else told

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Give what asks the graph: ``get_topic_names_and_types``, ``count_publishers``."""
        if not name.startswith(("get_", "count_")):
            raise AttributeError(f"a node by a bridge has no {name}")
        return functools.partial(self.ask_graph, name)


class ClockTime(NamedTuple):
    """A moment (since 1970)."""

    nanoseconds: int


class WallClock:
    """A node's clock, as rclpy has it."""

    def now(self) -> ClockTime:
        """Give the time."""
        return ClockTime(time.time_ns())


class _WaitSet:
    """Waits for entities of one context."""

    def __init__(self, *words: Any) -> None:  # noqa: ANN401 - as rclpy's: numbers, then the context
        self._context: JoinedContext = words[-1]
        self._subscriptions: list[Subscription] = []
        self._clients: list[ServiceClient] = []
        self._guards: list[Guard] = []

    def clear_entities(self) -> None:
        self._subscriptions, self._clients, self._guards = [], [], []

    def add_subscription(self, entity: Subscription) -> None:
        self._subscriptions.append(entity)

    def add_client(self, entity: ServiceClient) -> None:
        self._clients.append(entity)

    def add_guard_condition(self, guard: Guard) -> None:
        self._guards.append(guard)

    def wait(self, timeout_ns: int) -> None:
        with self._context.changed:
            self._context.changed.wait_for(self._has_something, timeout_ns / 1e9)
            # Within the lock: who triggers it from here on wakes the next turn.
            for guard in self._guards:
                guard.triggered = False
        # Whoever waits learns of the end as with rclpy: by an exception.
        if (process := self._context.process) is not None and process.lost:
            raise BridgeLost(process.lost)

    def get_ready_entities(self, kind: str) -> list[int]:
        found: list[Any] = self._subscriptions if kind == "subscription" else self._clients
        return [entity.pointer for entity in found if entity.queue]

    def destroy_when_not_in_use(self) -> None:
        """Nothing is held."""

    def _has_something(self) -> bool:
        process = self._context.process
        return (
            process is None
            or bool(process.lost)
            or any(guard.triggered for guard in self._guards)
            or any(entity.queue for entity in (*self._subscriptions, *self._clients))
        )


rclpy_implementation = SimpleNamespace(WaitSet=_WaitSet)


def _endpoint(told: dict[str, Any]) -> Any:  # noqa: ANN401
    return SimpleNamespace(
        node_name=told["node"],
        node_namespace=told["namespace"],
        topic_type=told["type"],
        topic_type_hash=told["hash"],
        qos_profile=SimpleNamespace(reliability=told["reliability"], durability=told["durability"]),
    )
