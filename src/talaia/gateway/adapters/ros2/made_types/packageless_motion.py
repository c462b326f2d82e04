"""Driving by a message whose type is not installed here, such as Ackermann's or a joint jog.

Written by the definition of its listeners' hash and published as bytes, as `PackagelessPublisher`
does for commands. Its publisher is made before it is needed, as soon as somebody listens, and made
anew when the listeners come back with another version of the type.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any, NamedTuple

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from talaia.gateway.adapters.ros2.made_types.made_message_class import forget_error, problem_here
from talaia.gateway.adapters.ros2.requests import fill
from talaia.gateway.adapters.ros2.system_ros.start import guard_velocity
from talaia.gateway.adapters.ros2.type_definitions.message_definition import BadDefinition
from talaia.gateway.adapters.ros2.type_definitions.message_encoder import MessageEncoder
from talaia.gateway.adapters.ros2.type_definitions.robot_questions import hash_of, node_of
from talaia.gateway.adapters.velocity import guard_mark, stamp_fields, velocity_fields, zero_of
from talaia.gateway.errors import FieldError, TypeMissing

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.adapters.ros2.topic_types import TopicType, TopicTypes
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.model.site import Drive
    from talaia.wire.frames import Scalar

__all__ = ["PackagelessMotion"]

# Who listens is looked at so often (s).
_LOOK_S = 1.0


class _Ready(NamedTuple):
    """A publisher, and what writes its messages."""

    publisher: Any
    encoder: MessageEncoder
    spoken: str


class PackagelessMotion:
    """The publisher of one driven device; `publish` from any thread, the rest on the wait set's."""

    def __init__(
        self,
        rule: Drive,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        thread: WaitThread,
        *,
        types: TopicTypes,
        missing: Callable[[TypeMissing], None],
    ) -> None:
        """Begin to look for who listens."""
        self._rule, self._node, self._thread = rule, node, thread
        self._types, self._missing = types, missing
        # None until somebody listens whose version of the type is known.
        self._ready: _Ready | None = None
        # A version that was told as unusable is not told again.
        self._refused = ""
        self._finding = False
        self._closed = False
        # Looks again in a while.
        self._again: threading.Timer | None = None
        thread.run_soon(self._look_for_listeners)

    def close(self) -> None:
        """End it; also before the node goes."""
        self._closed = True
        if self._again is not None:
            self._again.cancel()
        self._end_publisher()

    def publish(self, demand: VelocityDemand) -> None:
        """Publish a demand; nobody is told anything while nobody listens.

        Raises:
            RuntimeError: ROS is gone.

        """
        ready = self._ready
        if ready is not None:
            ready.publisher.publish(self._write(ready.encoder, velocity_fields(self._rule, demand)))

    def _write(self, encoder: MessageEncoder, fields: Mapping[str, Scalar]) -> bytes:
        message = encoder.new_message()
        stamp = stamp_fields(self._rule, lambda: int(self._node.get_clock().now().nanoseconds))
        fill(message, {**stamp, **fields})
        return encoder.encode_message(message)

    def _look_for_listeners(self) -> None:
        if self._closed:
            return
        if not self._finding and self._node.context.ok():
            self._find()
        # Not by the wait set: it has no timers of its own.
        self._again = threading.Timer(_LOOK_S, self._look_soon)
        self._again.daemon = True
        self._again.start()

    def _look_soon(self) -> None:
        if not self._closed:
            self._thread.run_soon(self._look_for_listeners)

    def _find(self) -> None:
        topic, type_name = self._rule.topic, self._rule.message.value
        own = self._node.get_fully_qualified_name()
        hashes = {
            hash_of(info)
            for info in self._node.get_subscriptions_info_by_topic(topic)
            # What this gateway reads itself is no listener on the robot.
            if node_of(info) != own and info.topic_type == type_name
        }
        spoken = min(hashes, default="")
        if not hashes or (self._ready is not None and hashes == {self._ready.spoken}):
            return
        problem = problem_here()
        # By another version's definition a message would be taken for something else.
        if not problem and (len(hashes) > 1 or not spoken):
            problem = "its listeners do not agree on a version, or name none"
        if problem:
            self._refuse(spoken, problem)
            return
        self._finding = True

        def on_found(found: TopicType | None) -> None:
            if found is None or found.definition is None:
                self._finding = False
                self._refuse(spoken, "its definition is not known here")
                return
            definition = found.definition
            self._types.when_tried(lambda: self._begin(spoken, MessageEncoder(definition)))

        self._types.find(topic, type_name, spoken, on_found)

    def _begin(self, spoken: str, encoder: MessageEncoder) -> None:
        self._finding = False
        if self._closed:
            return
        topic, type_name = self._rule.topic, self._rule.message.value
        # None yet where making classes is still being tried: looked at again in a second.
        kind = self._types.class_for(type_name, topic, spoken)
        if kind is None:
            return
        zero = velocity_fields(self._rule, zero_of(self._rule))
        try:
            plain = self._write(encoder, zero)
            marked = self._write(encoder, zero | guard_mark(self._rule))
            publisher = self._node.create_publisher(kind, topic, _NEWEST)
        # What a bridge cannot make, or a message that has other fields than the type we know.
        except (RuntimeError, BadDefinition, FieldError) as error:
            self._refuse(spoken, str(error))
            return
        forget_error()
        guard_velocity(publisher, plain, marked)
        # The one before goes only now: nothing is between the two but this call.
        self._end_publisher()
        self._ready = _Ready(publisher, encoder, spoken)

    def _refuse(self, spoken: str, problem: str) -> None:
        if self._refused != f"{spoken} {problem}":
            self._refused = f"{spoken} {problem}"
            self._missing(TypeMissing(self._rule.message.value, self._rule.topic, problem))

    def _end_publisher(self) -> None:
        ready, self._ready = self._ready, None
        if ready is not None:
            self._node.destroy_publisher(ready.publisher)


# Never latched: a velocity must not reach a robot that comes later.
_NEWEST = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
)
