"""One node of a gateway in one domain: its entities, and the questions to its graph."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import rclpy
from rclpy.action import get_action_names_and_types
from rclpy.context import Context
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.signals import SignalHandlerOptions

from .descriptions import class_named
from .made_message_class import forget_error, is_made, made_class
from .pipe_frames import ANSWER, MESSAGE, MESSAGE_HEAD, NUMBERED_HEAD, frame_of
from .velocities import SILENCE_S, VelocityPublisher
from .waitset import WaitThread

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from .pipe_frames import PipeWriter

_PATIENCE_S = 5.0


class JoinedNode:
    """A node, told what to do by the gateway. Not of the wait-set thread but where it says so."""

    def __init__(
        self,
        name: str,
        domain: int | None,
        out: PipeWriter,
        failed: Callable[[BaseException], None],
    ) -> None:
        """Join; no domain is the environment's. ``failed`` is told when it hears no more."""
        self._out = out
        self._context = Context()
        rclpy.init(
            args=["--ros-args", "--disable-rosout-logs", "--disable-external-lib-logs"],
            context=self._context,
            domain_id=domain,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        self.domain = self._context.get_domain_id()
        self._node = Node(
            name,
            context=self._context,
            use_global_arguments=False,
            enable_rosout=False,
            start_parameter_services=False,
            # Of Iron and later; Humble does not ask for it.
            parameter_overrides=[Parameter("start_type_description_service", value=False)],
        )
        # By the gateway's number of the entity, as all that follows: the classes of types.
        self._kinds: dict[int, Any] = {}
        self._subscriptions: dict[int, Any] = {}
        self._publishers: dict[int, Any] = {}
        # Those of the publishers that end with a zero.
        self._guarded: dict[int, VelocityPublisher] = {}
        self._clients: dict[int, Any] = {}
        # The gateway's numbers of calls, by the client and rclpy's own number.
        self._calls: dict[tuple[int, int], int] = {}
        # Frames of one turn of the wait set; its thread's.
        self._waiting: list[bytes] = []
        guard = self._node.create_guard_condition(lambda: None)
        self._thread = WaitThread(
            make_wait_set=lambda subscriptions, clients: _rclpy.WaitSet(
                subscriptions, 1, 0, clients, 0, 0, self._context.handle
            ),
            guard=guard.handle,
            after=self._flush,
            idle=lambda: None,
            failed=failed,
        )
        self._thread.start()

    def close(self) -> None:
        """End all of it."""
        self._thread.end()
        self._node.destroy_node()
        rclpy.try_shutdown(context=self._context)

    def shorten_turns(self, pace_s: float) -> None:
        """Let turns of the wait set be so short (s)."""
        self._thread.run_soon(lambda: self._thread.shorten_turns("gateway", pace_s))

    # ── entities ──

    def make(self, what: str, entity: int, **more: Any) -> None:  # noqa: ANN401
        """Make an entity under the gateway's number of it."""
        type_name, type_hash = more.pop("type"), more.pop("hash", None)
        kind = class_named(type_name)
        if kind is None and type_hash is not None:
            # Clients come with none: such a class takes and publishes nothing but bytes.
            kind = made_class(type_name, type_hash)
        if kind is None:
            raise LookupError("its type is not installed")
        self._kinds[entity] = kind
        if what == "publisher":
            # Needs no wait set, and so not its thread.
            self._make_publisher(entity, kind, **more)
            return
        make = self._make_subscription if what == "subscription" else self._make_client
        self._on_thread(lambda: make(entity, kind, **more))

    def _make_publisher(self, entity: int, kind: Any, topic: str, quality: Any) -> None:  # noqa: ANN401
        try:
            made = self._node.create_publisher(kind, topic, _profile(quality))
        finally:
            if is_made(kind):
                forget_error()
        self._publishers[entity] = made

    def _make_subscription(self, entity: int, kind: Any, topic: str, quality: Any) -> None:  # noqa: ANN401
        try:
            made = self._node.create_subscription(kind, topic, _never, _profile(quality), raw=True)
        finally:
            # On this thread, for the middleware keeps its errors by threads.
            if is_made(kind):
                forget_error()
        self._subscriptions[entity] = made

        def on_message(raw: bytes, info: Any) -> None:  # noqa: ANN401
            head = MESSAGE_HEAD.pack(
                entity,
                info["received_timestamp"],
                info["source_timestamp"],
                _sequence_number(info),
            )
            self._waiting.append(frame_of(MESSAGE, head, raw))

        self._thread.add_subscription(made.handle, kind, on_message)

    def _make_client(self, entity: int, kind: Any, service: str) -> None:  # noqa: ANN401
        made = self._clients[entity] = self._node.create_client(kind, service)

        def on_answer(number: int, response: Any) -> None:  # noqa: ANN401
            ours = self._calls.pop((entity, number), None)
            if ours is not None:
                head = NUMBERED_HEAD.pack(entity, ours)
                self._waiting.append(frame_of(ANSWER, head, serialize_message(response)))

        self._thread.add_client(made.handle, kind.Response, on_answer)

    def destroy(self, entity: int) -> None:
        """End one of them."""
        # First nobody says zeros by it any more, then it goes.
        self._guarded.pop(entity, None)
        publisher = self._publishers.pop(entity, None)
        if publisher is not None:
            self._node.destroy_publisher(publisher)
        else:
            self._on_thread(lambda: self._destroy(entity))

    def _destroy(self, entity: int) -> None:
        subscription = self._subscriptions.pop(entity, None)
        if subscription is not None:
            self._thread.remove_subscription(subscription.handle)
            self._node.destroy_subscription(subscription)
        client = self._clients.pop(entity, None)
        if client is not None:
            self._thread.remove_client(client.handle)
            self._node.destroy_client(client)

    def guard(self, entity: int, zero: bytes, kept: tuple[int, int]) -> None:
        """End with this what is published there; see `VelocityPublisher` for ``kept``."""
        self._guarded[entity] = VelocityPublisher(self._publishers[entity], zero, kept)

    def publish(self, entity: int, message: bytes, made_ns: int) -> None:
        """Publish a message; a velocity only if it is not of the past."""
        guarded = self._guarded.get(entity)
        if guarded is not None:
            guarded.publish(message, made_ns)
        elif entity in self._publishers:
            self._publishers[entity].publish(message)

    def call(self, entity: int, request: bytes, number: int) -> None:
        """Send a request; its answer has the same number."""
        client = self._clients.get(entity)
        if client is None:
            return
        message = deserialize_message(request, self._kinds[entity].Request)
        # On the thread that takes the answers, so that none comes before its number is known.
        self._thread.run_soon(lambda: self._send(entity, client, message, number))

    def _send(self, entity: int, client: Any, message: Any, number: int) -> None:  # noqa: ANN401
        # It may have been destroyed meanwhile.
        if entity in self._clients:
            self._calls[entity, client.handle.send_request(message)] = number

    def is_ready(self, entity: int) -> bool:
        """Tell whether a client's service is offered."""
        client = self._clients.get(entity)
        return client is not None and bool(client.service_is_ready())

    def count_listeners(self, entity: int) -> int:
        """Count who listens to a publisher."""
        publisher = self._publishers.get(entity)
        return 0 if publisher is None else int(publisher.get_subscription_count())

    def end_silence(self, silence_s: float = SILENCE_S) -> None:
        """See `VelocityPublisher.end_silence`; any thread."""
        for guarded in list(self._guarded.values()):
            guarded.end_silence(silence_s)

    # ── the graph ──

    def ask_graph(self, question: str, words: list[Any]) -> Any:  # noqa: ANN401
        """Ask as rclpy's node is asked; endpoints come as objects of JSON."""
        if question == "get_action_names_and_types":
            return get_action_names_and_types(self._node)
        found = getattr(self._node, question)(*words)
        # Of all that is asked these alone are no JSON.
        if question.endswith("_info_by_topic"):
            return [_endpoint(info) for info in found]
        return found

    # ── the thread ──

    def _on_thread(self, job: Callable[[], None]) -> None:
        """Run a job on the wait-set thread and wait for it; its exception is raised here."""
        done, failed = threading.Event(), []

        def work() -> None:
            try:
                job()
            except Exception as error:  # noqa: BLE001 - raised where it was asked for
                failed.append(error)
            done.set()

        self._thread.run_soon(work)
        if not done.wait(_PATIENCE_S):
            raise TimeoutError("ROS 2 does not answer")
        if failed:
            raise failed[0]

    def _flush(self) -> bool:
        waiting, self._waiting = self._waiting, []
        self._out.write(b"".join(waiting))
        return False


def _profile(quality: Any) -> Any:  # noqa: ANN401
    if isinstance(quality, int):
        return quality
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=quality["depth"],
        reliability=ReliabilityPolicy(quality["reliability"]),
        durability=DurabilityPolicy(quality["durability"]),
    )


def _sequence_number(info: Any) -> int:  # noqa: ANN401
    number = info.get("publication_sequence_number") or 0
    # Some middlewares say "not known" by the greatest number.
    return number if 0 <= number < 1 << 64 else 0


def _endpoint(info: Any) -> dict[str, Any]:  # noqa: ANN401
    return {
        "node": info.node_name,
        "namespace": info.node_namespace,
        "type": info.topic_type,
        # Humble tells none.
        "hash": str(getattr(info, "topic_type_hash", "")),
        "reliability": int(info.qos_profile.reliability),
        "durability": int(info.qos_profile.durability),
    }


def _never(_: object) -> None:
    """Stand where rclpy wants a callback; the wait-set thread takes messages itself."""
