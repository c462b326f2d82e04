"""Looks at a live ROS 2 graph: topics with their fields and rates, services, actions, nodes.

Listens only: it publishes and offers nothing, and calls nothing but what nodes are read by.

Long, because one look is one thing: who is there, what they say, and what is told of it.
"""

from __future__ import annotations

import contextlib
import time
from collections import deque
from typing import TYPE_CHECKING, Any

import talaia.gateway.adapters.ros2.system_ros.start  # noqa: F401 - before the first of rclpy

# isort: split
import rclpy
from rclpy.action import get_action_names_and_types
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from talaia.gateway.adapters.message_fields import ReadableFields, shape_of
from talaia.gateway.adapters.named_sensors import NAMED_TYPES, names_in
from talaia.gateway.adapters.ros2.graph_node import join_graph
from talaia.gateway.adapters.ros2.made_types.made_message_class import forget_error, is_made
from talaia.gateway.adapters.ros2.nodes.probed_nodes import ProbedNodes
from talaia.gateway.adapters.ros2.probed_types import (
    ProbedTypes,
    goal_of,
    heard_message_of,
    request_of,
)
from talaia.gateway.adapters.ros2.qos import QosProfile, quality_for
from talaia.gateway.adapters.ros2.type_definitions.definition_finder import DefinitionMismatch
from talaia.gateway.adapters.ros2.type_definitions.message_definition import BadDefinition
from talaia.gateway.errors import AdapterLost, FieldError, TypeMissing
from talaia.model.discovery.probe_report import FORMAT, ActionFound, Found, ServiceFound, TopicFound
from talaia.model.discovery.rules.urdf_joints import joints_in, poses_in

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable
    from pathlib import Path

__all__ = ["probe_graph"]

# What every node has, and what carries ROS itself.
PLUMBING = {"/parameter_events", "/rosout", "/clock"}
PLUMBING_TYPES = (
    "rcl_interfaces/",
    "type_description_interfaces/",
    "lifecycle_msgs/",
    "action_msgs/",
)
LOOK_AGAIN_S = 0.4
# Nodes that describe their types do so within milliseconds.
ANSWER_S = 2.0
# Messages that are kept of a topic that carries many sensors, each with some of them.
MOST_SEVERAL = 500


class _Heard:
    """A topic that is listened to: how many came, when, and the last one."""

    def __init__(self, topic: str, type_name: str, publishers: Collection[Any]) -> None:
        self.topic, self.type_name, self.publishers = topic, type_name, publishers
        self.latched = all(
            info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for info in publishers
        )
        self.count = 0
        self.first = self.last = 0.0
        self.raw = b""
        # Of topics that carry many sensors: some messages of each other's, without end.
        self._several: deque[bytes] = deque(maxlen=MOST_SEVERAL)
        # What they are about; filled when all have come.
        self.names: tuple[str, ...] = ()

    def count_message(self, raw: bytes) -> None:
        now = time.monotonic()
        self.first = self.first or now
        self.last = now
        self.count += 1
        self.raw = raw
        if self.type_name in NAMED_TYPES:
            self._several.append(raw)

    def rate(self) -> float:
        """Give messages a second, by their spacing; 0 where that is not known."""
        if self.count > 1 and self.last > self.first:
            return (self.count - 1) / (self.last - self.first)
        return 0.0

    def find_names(self, decode: Callable[[bytes], object]) -> None:
        """Find the names of the sensors that the messages carry."""
        names: set[str] = set()
        for raw in self._several:
            with contextlib.suppress(FieldError):
                names |= set(names_in(decode(raw), self.type_name))
        self.names = tuple(sorted(names))


def probe_graph(domain: int | None, seconds: float, definitions: Path | None = None) -> Found:
    """Join the graph, listen for so many seconds (s) and tell what is there.

    ``definitions``: a folder or a recording with definitions of types that are not installed.

    Raises:
        AdapterLost: ROS 2 cannot be joined.

    """
    context = Context()
    try:
        node = join_graph("talaia_probe", context, domain)
    except Exception as error:
        rclpy.try_shutdown(context=context)
        raise AdapterLost(f"ROS 2 cannot be joined: {error}") from error
    try:
        return _Look(node, context, seconds, definitions).found()
    finally:
        node.destroy_node()
        rclpy.try_shutdown(context=context)


class _Look:
    """One look at the graph."""

    def __init__(
        self,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        context: Any,  # noqa: ANN401
        seconds: float,
        definitions: Path | None,
    ) -> None:
        self._node, self._context, self._seconds = node, context, seconds
        self._definitions = definitions
        self._heard: dict[str, _Heard] = {}
        self._problems: dict[str, str] = {}
        self._types = ProbedTypes(node, definitions)
        self._nodes = ProbedNodes(node)
        # When to stop listening (monotonic, s).
        self._until = 0.0

    def found(self) -> Found:
        executor = SingleThreadedExecutor(context=self._context)
        executor.add_node(self._node)
        self._until = time.monotonic() + self._seconds
        look_at = 0.0
        while (now := time.monotonic()) < self._until:
            if now >= look_at:
                self._listen()
                self._ask()
                self._nodes.ask()
                look_at = now + LOOK_AGAIN_S
            executor.spin_once(timeout_sec=min(0.1, self._until - now))
        answered_by = time.monotonic() + ANSWER_S
        while (self._types.waiting or self._nodes.waiting) and time.monotonic() < answered_by:
            executor.spin_once(timeout_sec=0.1)
        executor.shutdown(timeout_sec=1)
        domain = self._context.get_domain_id()
        actions = self._actions()
        return Found(
            talaia_probe=FORMAT,
            protocol="ros2",
            where=f"ROS 2, domain {domain}",
            seconds=self._seconds,
            domain=domain,
            definitions=str(self._definitions or ""),
            sim_time=bool(self._node.get_publishers_info_by_topic("/clock")),
            topics=tuple(self._topics()),
            services=tuple(self._services()),
            actions=tuple(actions),
            nodes=tuple(self._nodes.found()),
            joints=tuple(
                joint for text in self._models("robot_description") for joint in joints_in(text)
            ),
            poses=tuple(
                pose
                for text in self._models("robot_description_semantic")
                for pose in poses_in(text)
            ),
        )

    def _models(self, last: str) -> Iterable[str]:
        """Give the models that were published: texts of topics with this name."""
        for topic, heard in sorted(self._heard.items()):
            if topic.rpartition("/")[2] != last or heard.type_name != "std_msgs/msg/String":
                continue
            if not heard.raw:
                continue
            # One that cannot be read is told with its topic.
            with contextlib.suppress(Exception):
                found = self._types.find(heard.type_name, topic, heard.publishers)
                yield str(getattr(found.decode(heard.raw), "data", ""))

    # ── listening ──

    def _listen(self) -> None:
        for topic, types in self._node.get_topic_names_and_types():
            if topic in self._heard or topic in self._problems or _is_plumbing(topic, types):
                continue
            publishers = self._node.get_publishers_info_by_topic(topic)
            if not publishers:
                continue
            if len(types) > 1:
                self._problems[topic] = f"it is published with several types: {', '.join(types)}"
                continue
            began = time.monotonic()
            try:
                kind = self._types.class_for(types[0], topic, publishers)
            except TypeMissing as error:
                self._problems[topic] = str(error)
                continue
            # The first type that is not installed takes a second of trying, in which nobody hears.
            self._until += time.monotonic() - began
            heard = self._heard[topic] = _Heard(topic, types[0], publishers)
            self._node.create_subscription(
                kind, topic, heard.count_message, _profile(publishers), raw=True
            )
            if is_made(kind):
                forget_error()

    def _ask(self) -> None:
        for heard in self._heard.values():
            self._types.ask(heard.type_name, heard.publishers)

    # ── telling ──

    def _topics(self) -> Iterable[TopicFound]:
        for topic, types in sorted(self._node.get_topic_names_and_types()):
            if _is_plumbing(topic, types):
                continue
            heard = self._heard.get(topic)
            publishers = len(self._node.get_publishers_info_by_topic(topic))
            own = 1 if heard is not None else 0
            subscribers = len(self._node.get_subscriptions_info_by_topic(topic)) - own
            if not publishers and not subscribers:
                continue
            shape, problem = ReadableFields((), ()), self._problems.get(topic, "")
            if heard is not None:
                shape, problem = self._read(heard)
            elif not publishers:
                infos = self._node.get_subscriptions_info_by_topic(topic)
                shape, problem = heard_message_of(types[0], topic, infos, self._types)
            yield TopicFound(
                topic=topic,
                type=types[0],
                publishers=publishers,
                subscribers=subscribers,
                rate=round(heard.rate(), 2) if heard is not None else 0.0,
                latched=heard is not None and heard.latched,
                fields=shape.fields,
                names=tuple(heard.names) if heard is not None else (),
                left_out=shape.left_out,
                stamped=shape.stamped,
                problem=problem,
            )

    def _read(self, heard: _Heard) -> tuple[ReadableFields, str]:
        try:
            found = self._types.find(heard.type_name, heard.topic, heard.publishers)
        except (TypeMissing, DefinitionMismatch, BadDefinition) as error:
            return ReadableFields((), ()), str(error)
        heard.find_names(found.decode)
        message, problem = None, ""
        if heard.raw:
            try:
                message = found.decode(heard.raw)
            except Exception as error:  # noqa: BLE001 - rclpy raises bare kinds for foreign bytes
                problem = f"a message that came is not a {heard.type_name}: {error}"
        package, _, name = heard.type_name.split("/")
        kind = found.find(f"{package}/{name}")
        if kind is None:
            return ReadableFields((), ()), problem
        return shape_of(
            kind=kind,
            type_name=f"{package}/{name}",
            find=found.find,
            message=message,
            comment_of=found.comment_of,
        ), problem

    def _services(self) -> Iterable[ServiceFound]:
        for service, types in sorted(self._node.get_service_names_and_types()):
            if types[0].startswith(PLUMBING_TYPES) or "/_action/" in service:
                continue
            shape, problem = request_of(types[0], service, self._types)
            yield ServiceFound(service, types[0], shape.fields, problem)

    def _actions(self) -> Iterable[ActionFound]:
        for action, types in sorted(get_action_names_and_types(self._node)):
            shape, problem = goal_of(types[0], action, self._types)
            yield ActionFound(action, types[0], shape.fields, problem)


def _is_plumbing(topic: str, types: list[str]) -> bool:
    return topic in PLUMBING or "/_action/" in topic or types[0].startswith(PLUMBING_TYPES)


def _profile(publishers: Iterable[Any]) -> QoSProfile:
    quality = quality_for(
        [
            QosProfile(
                info.qos_profile.reliability != ReliabilityPolicy.BEST_EFFORT,
                info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL,
            )
            for info in publishers
        ]
    )
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=50,
        reliability=ReliabilityPolicy.RELIABLE
        if quality.reliable
        else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL
        if quality.latched
        else DurabilityPolicy.VOLATILE,
    )
