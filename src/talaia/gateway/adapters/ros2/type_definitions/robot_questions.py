"""Asks robots' nodes for the definitions of what they publish. On the wait-set thread.

Nodes from Iron on offer ``~/get_type_description`` unless they were told not to. It wants the
type's hash, which the graph tells for topics.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.clock import SECOND
from talaia.gateway.adapters.ros2.type_definitions.message_definition import BadDefinition
from talaia.gateway.adapters.ros2.type_definitions.robot_description import (
    definition_of_description,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.adapters.ros2.type_definitions.message_definition import TypeDefinition

try:
    from type_description_interfaces.srv import GetTypeDescription
except ImportError:
    # Humble has no such service.
    GetTypeDescription = None

__all__ = ["GetTypeDescription", "RobotDescriptions", "description_in", "hash_of", "node_of"]

log = logging.getLogger(__name__)
# Its node's name may be known a moment later than the publisher, and its service, too.
_PATIENCE_NS = 3 * SECOND
_UNKNOWN = "_NODE_NAME_UNKNOWN_"
_HASH = "RIHS01_"


class _Question(NamedTuple):
    """What is asked of whoever publishes a topic, and until when (monotonic ns)."""

    topic: str
    type_name: str
    type_hash: str
    done: Callable[[TypeDefinition | None], None]
    until_ns: int


class RobotDescriptions:
    """The questions that are under way."""

    def __init__(self, node: Any, thread: WaitThread, clock: Clock) -> None:  # noqa: ANN401 - rclpy ships no types
        """Take the node that asks."""
        self._node, self._thread, self._clock = node, thread, clock
        # Not sent yet, for nobody is known who could answer.
        self._waiting: list[_Question] = []
        # Sent, by the node that is asked: its client, and questions by the number of the request.
        self._clients: dict[str, Any] = {}
        self._asked: dict[str, dict[int, _Question]] = {}

    def ask(
        self,
        topic: str,
        type_name: str,
        type_hash: str,
        done: Callable[[TypeDefinition | None], None],
    ) -> None:
        """Ask who publishes a topic with this hash; ``done`` is called once, within 3 s.

        It gets nothing when nobody answers, or what is said defines no type.
        """
        if GetTypeDescription is None or not type_hash:
            done(None)
            return
        until_ns = self._clock.monotonic_ns() + _PATIENCE_NS
        question = _Question(topic, type_name, type_hash, done, until_ns)
        if not self._send(question):
            self._waiting.append(question)

    def ask_again(self) -> None:
        """Send what could not be sent yet, and give up what has waited too long."""
        now_ns = self._clock.monotonic_ns()
        waiting, self._waiting = self._waiting, []
        for question in waiting:
            if question.until_ns < now_ns:
                question.done(None)
            # Its node's name or service may be discovered a moment after its publisher.
            elif not self._send(question):
                self._waiting.append(question)
        for name, asked in list(self._asked.items()):
            for number, question in list(asked.items()):
                if question.until_ns < now_ns:
                    del asked[number]
                    question.done(None)
            if not asked and not any(self._owner(other) == name for other in self._waiting):
                self._close(name)

    def _owner(self, question: _Question) -> str:
        # Who listens knows the type as well: a command may be published to it.
        infos = [
            *self._node.get_publishers_info_by_topic(question.topic),
            *self._node.get_subscriptions_info_by_topic(question.topic),
        ]
        return next((node_of(info) for info in infos if hash_of(info) == question.type_hash), "")

    def _send(self, question: _Question) -> bool:
        name = self._owner(question)
        if not name:
            return False
        client = self._clients.get(name)
        if client is None:
            client = self._node.create_client(GetTypeDescription, f"{name}/get_type_description")
            self._clients[name] = client
            self._asked[name] = {}

            def on_answer(number: int, answer: object) -> None:
                asked = self._asked.get(name, {}).pop(number, None)
                if asked is not None:
                    asked.done(description_in(answer, f"the node {name}"))

            self._thread.add_client(client.handle, GetTypeDescription.Response, on_answer)
        if not client.service_is_ready():
            return False
        request = GetTypeDescription.Request(
            type_name=question.type_name, type_hash=question.type_hash, include_type_sources=True
        )
        self._asked[name][client.handle.send_request(request)] = question
        return True

    def _close(self, name: str) -> None:
        client = self._clients.pop(name)
        del self._asked[name]
        self._thread.remove_client(client.handle)
        self._node.destroy_client(client)


def description_in(answer: Any, source: str) -> TypeDefinition | None:  # noqa: ANN401
    """Read a node's answer; none where it does not know the type, or says nothing sensible."""
    if not answer.successful:
        log.info("%s describes no type: %s", source, answer.failure_reason[:200])
        return None
    try:
        return definition_of_description(answer.type_description, answer.type_sources, source)
    except BadDefinition as error:
        log.warning("%s: %s", source, error)
        return None


def hash_of(info: Any) -> str:  # noqa: ANN401
    """Give the hash in what the graph tells of an endpoint; empty where it tells none."""
    found = str(getattr(info, "topic_type_hash", ""))
    return found if found.startswith(_HASH) else ""


def node_of(info: Any) -> str:  # noqa: ANN401
    """Give the full name of an endpoint's node; empty while the graph does not know it."""
    if info.node_name == _UNKNOWN:
        return ""
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"
