"""A command that publishes a message whose type is not installed. On the wait-set thread.

The message is written by the definition of its listeners' hash, and goes out as bytes: so no
serializer of Python's is called from within the middleware. The publisher is made when it is needed
first, for only listeners tell which version of the type it has to be of.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from talaia.gateway.adapters.ros2.made_types.made_message_class import forget_error, problem_here
from talaia.gateway.adapters.ros2.requests import fill
from talaia.gateway.adapters.ros2.type_definitions.message_definition import BadDefinition
from talaia.gateway.adapters.ros2.type_definitions.message_encoder import MessageEncoder
from talaia.gateway.adapters.ros2.type_definitions.robot_questions import hash_of, node_of
from talaia.gateway.errors import FieldError, TypeMissing
from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.adapters.ros2.topic_types import TopicType, TopicTypes
    from talaia.model.site import Command
    from talaia.wire.frames import Scalar

__all__ = ["PackagelessPublisher"]

# A new publisher is discovered by its listeners one after the other; looked at so often (s).
_LOOK_S = 0.05
_LOOKS = 40


class PackagelessPublisher:
    """The publisher of one command."""

    def __init__(
        self,
        command: Command,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        thread: WaitThread,
        types: TopicTypes,
    ) -> None:
        """Make nothing yet."""
        self._command, self._node, self._thread, self._types = command, node, thread, types
        # None until the first message; then of the version in `_spoken`.
        self._publisher: Any = None
        self._spoken = ""
        self._closed = False

    def close(self) -> None:
        """End the publisher; what is under way is refused."""
        self._closed = True
        self._end_publisher()

    def publish_fields(
        self, fields: dict[str, Scalar], done: Callable[[CommandOutcome], None]
    ) -> None:
        """Publish one message; see `CommandTarget.act` for ``done``."""
        target, type_name = self._command.target, self._command.type
        if problem := problem_here():
            _refuse(done, str(TypeMissing(type_name, target, problem)))
            return
        own = self._node.get_fully_qualified_name()
        # What this gateway reads itself is no listener on the robot.
        listeners = [
            info
            for info in self._node.get_subscriptions_info_by_topic(target)
            if node_of(info) != own
        ]
        if not listeners:
            _refuse(done, f"nobody on the robot listens to {target}")
            return
        others = sorted({info.topic_type for info in listeners} - {type_name})
        if others:
            _refuse(done, f"{target} is listened to as {' and '.join(others)}, not as {type_name}")
            return
        hashes = sorted({hash_of(info) for info in listeners})
        # By another version's definition a message would be taken for something else.
        if len(hashes) > 1 or not hashes[0]:
            which = " and ".join(filter(None, hashes))
            why = f"in two versions, {which}" if which else "and nobody says in which version"
            _refuse(done, f"{target} is listened to {why}; install the package of {type_name}")
            return

        def on_found(found: TopicType | None) -> None:
            if found is None or found.definition is None:
                _refuse(done, f"the definition of {type_name} is not known here; see the log")
                return
            try:
                encoder = MessageEncoder(found.definition)
                message = encoder.new_message()
                fill(message, fields)
                raw = encoder.encode_message(message)
            except (BadDefinition, FieldError) as error:
                _refuse(done, str(error))
                return
            self._types.when_tried(lambda: self._begin(hashes[0], raw, done))

        self._types.find(target, type_name, hashes[0], on_found)

    def _begin(self, spoken: str, raw: bytes, done: Callable[[CommandOutcome], None]) -> None:
        if not self._closed and (self._publisher is None or self._spoken != spoken):
            self._end_publisher()
            kind = self._types.class_for(self._command.type, self._command.target, spoken)
            if kind is not None:
                try:
                    self._publisher = self._node.create_publisher(kind, self._command.target, 10)
                # What a bridge cannot make ends no other command.
                except RuntimeError as error:
                    _refuse(done, f"{self._command.type} cannot be published: {error}")
                    return
                forget_error()
                self._spoken = spoken
        self._send(raw, done, _LOOKS)

    def _send(self, raw: bytes, done: Callable[[CommandOutcome], None], looks: int) -> None:
        publisher = self._publisher
        if publisher is None:
            _refuse(done, f"{self._command.type} cannot be published without its package here")
            return
        wanted = self._node.count_subscribers(self._command.target)
        found = publisher.get_subscription_count()
        if found < wanted and looks:
            # Never latched: whoever is not discovered yet would not hear it.
            again = threading.Timer(
                _LOOK_S,
                lambda: self._thread.run_soon(lambda: self._send(raw, done, looks - 1)),
            )
            again.daemon = True
            again.start()
        elif not found:
            _refuse(done, f"nobody who listens to {self._command.target} was reached")
        else:
            publisher.publish(raw)
            done(CommandOutcome(CommandPhase.SUCCEEDED, "published"))

    def _end_publisher(self) -> None:
        publisher, self._publisher = self._publisher, None
        if publisher is not None:
            self._node.destroy_publisher(publisher)


def _refuse(done: Callable[[CommandOutcome], None], why: str) -> None:
    done(CommandOutcome(CommandPhase.REFUSED, why))
