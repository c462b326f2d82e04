"""The entities of a node that stands for one of rclpy's: each is in the bridge, under a number.

Long, because rclpy's classes stand here for each other: each is made with the context and its node.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from contextlib import suppress
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.gateway.adapters.ros2.rclpy_bridge.pipe_frames import (
    CALL,
    NUMBERED_HEAD,
    PUBLISH,
    frame_of,
)
from talaia.gateway.adapters.ros2.system_ros.process import BridgeLost

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.ros2.system_ros.process import BridgeProcess
    from talaia.gateway.adapters.ros2.system_ros.stand_in_rclpy import QoSProfile
    from talaia.gateway.adapters.ros2.system_ros.types import RemoteMessage, RemoteService

__all__ = [
    "Entity",
    "Future",
    "Guard",
    "JoinedContext",
    "PackagelessMessage",
    "Publisher",
    "ServiceClient",
    "Subscription",
]

# Answers that nobody fetches are not kept without end.
_MAX_ANSWERS = 10_000


class PackagelessMessage(NamedTuple):
    """What stands for the class of a message that the system has no package of.

    Attributes:
        name: ``package/msg/Name``.
        type_hash: what its publisher says, ``RIHS01_…``; empty where nobody says it.

    """

    name: str
    type_hash: str

    @staticmethod
    def encode(message: bytes) -> bytes:
        """Take what is written already: nothing else is published of such a type."""
        return message


class JoinedContext:
    """One domain that is joined."""

    def __init__(self) -> None:
        """Join nothing yet."""
        self.process: BridgeProcess | None = None
        # Under which the bridge knows it; 0 before it has begun.
        self.number = 0
        self.domain: int | None = None
        # Told whenever something comes for one of its entities.
        self.changed = threading.Condition()

    @property
    def handle(self) -> JoinedContext:
        """Itself: there is nothing below it."""
        return self

    def get_domain_id(self) -> int:
        """Give the domain's number."""
        return self.domain or 0

    def joined(self) -> BridgeProcess:
        """Give the process.

        Raises:
            BridgeLost: it has not been joined, or was left.

        """
        if self.process is None:
            raise BridgeLost("ROS 2 is not joined")
        return self.process

    def shorten_turns(self, pace_s: float) -> None:
        """Have the bridge take what came so often (s), too; see `WaitThread.shorten_turns`."""
        self.joined().ask("pace", node=self.number, pace_s=pace_s)

    def on_message(self, *_: object) -> None:
        """Stand here for what an entity takes."""

    on_answer = on_message

    def on_lost(self) -> None:
        """Wake whoever waits."""
        with self.changed:
            self.changed.notify_all()


class Entity:
    """What takes messages or answers: at once its own handle."""

    def __init__(self, context: JoinedContext, kind: Any, depth: int) -> None:  # noqa: ANN401
        """Keep at most so many of what comes; nothing is made in the bridge yet."""
        self.context, self.kind = context, kind
        self.process = context.joined()
        self.pointer = self.process.next_number()
        # Oldest first; what is over is lost, as with a full queue of the middleware.
        self.queue: deque[Any] = deque(maxlen=depth)

    @property
    def handle(self) -> Any:  # noqa: ANN401 - of its own class
        """Itself: there is nothing below it."""
        return self

    def on_message(self, raw: bytes, received_ns: int, sent_ns: int, number: int) -> None:
        """Take a message; see `Receiver`."""
        info = {
            "received_timestamp": received_ns,
            "source_timestamp": sent_ns,
            "publication_sequence_number": number,
        }
        self._queue((raw, info))

    def on_answer(self, raw: bytes, number: int) -> None:
        """Take an answer; see `Receiver`."""
        self._queue((number, raw))

    def on_lost(self) -> None:
        """Its context is told, too."""

    def _queue(self, what: object) -> None:
        with self.context.changed:
            self.queue.append(what)
            self.context.changed.notify_all()

    def make(self, what: str, **more: object) -> None:
        """Make it in the bridge."""
        # Before it is made: a latched message comes at once.
        self.process.register(self.pointer, self)
        words = {"node": self.context.number, "entity": self.pointer, "what": what}
        self.process.ask("make", type=self.kind.name, **words, **more)

    def destroy(self) -> None:
        """End it in the bridge, too."""
        self.process.forget(self.pointer)
        with suppress(BridgeLost):
            self.process.ask("destroy", entity=self.pointer)


class Subscription(Entity):
    """Takes raw messages."""

    def __init__(self, context: JoinedContext, kind: Any, topic: str, quality: QoSProfile) -> None:  # noqa: ANN401
        """Subscribe."""
        super().__init__(context, kind, quality.depth)
        self.callback: Callable[[bytes], None] = lambda _: None
        self.make("subscription", topic=topic, quality=quality._asdict(), **_hash_of(kind))

    def take_message(self, _kind: object, _raw: object) -> tuple[bytes, dict[str, int]] | None:
        """Take the oldest that waits."""
        return self.queue.popleft() if self.queue else None


class ServiceClient(Entity):
    """Calls a service."""

    def __init__(self, context: JoinedContext, kind: RemoteService, service: str) -> None:
        """Make a client."""
        super().__init__(context, kind, _MAX_ANSWERS)
        # Of an executor: what is called with an answer, by the call's number.
        self.futures: dict[int, Future] = {}
        self.make("client", service=service)

    def service_is_ready(self) -> bool:
        """Tell whether anybody offers it."""
        return bool(self.process.ask("ready", entity=self.pointer))

    def send_request(self, request: object) -> int:
        """Send a request and give its number."""
        # The gateway counts its calls itself, so that nobody waits for rclpy's number.
        number = self.process.next_number()
        head = NUMBERED_HEAD.pack(self.pointer, number)
        self.process.send(frame_of(CALL, head, self.kind.Request.encode(request)))
        return number

    def take_response(self, _kind: object) -> tuple[Any, Any]:
        """Take the oldest answer that waits, with a header that has the request's number."""
        if not self.queue:
            return None, None
        number, raw = self.queue.popleft()
        header = SimpleNamespace(request_id=SimpleNamespace(sequence_number=number))
        return header, self.kind.Response.decode(raw)

    def call_async(self, request: object) -> Future:
        """Call, and have the answer by `SingleThreadedExecutor`."""
        future = self.futures[self.send_request(request)] = Future()
        return future


class Future:
    """An answer that comes."""

    def __init__(self) -> None:
        """Wait for it."""
        self._answer: Any = None
        self._callback: Callable[[Future], None] = lambda _: None

    def add_done_callback(self, callback: Callable[[Future], None]) -> None:
        """Call this when it has come."""
        self._callback = callback

    def result(self) -> Any:  # noqa: ANN401
        """Give it."""
        return self._answer

    def finish(self, answer: object) -> None:
        """Take it."""
        self._answer = answer
        self._callback(self)


class Publisher:
    """Publishes; any thread, and never waits."""

    def __init__(
        self,
        context: JoinedContext,
        kind: RemoteMessage | PackagelessMessage,
        topic: str,
        quality: Any,  # noqa: ANN401
    ) -> None:
        """Advertise; of a type without its package nothing is published but bytes."""
        self._process, self._kind = context.joined(), kind
        self.number = self._process.next_number()
        if not isinstance(kind, PackagelessMessage):
            # The defaults are asked for now, not at the first velocity.
            kind.encode(kind())
        told = quality if isinstance(quality, int) else quality._asdict()
        words = {"node": context.number, "entity": self.number, "type": kind.name}
        words |= _hash_of(kind)
        self._process.ask("make", what="publisher", topic=topic, quality=told, **words)

    def publish(self, message: Any) -> None:  # noqa: ANN401
        """Publish a message.

        Raises:
            RuntimeError: ROS is gone.

        """
        if self._process.lost:
            raise BridgeLost(self._process.lost)
        # When it was made: the bridge leaves velocities of the past.
        head = NUMBERED_HEAD.pack(self.number, time.monotonic_ns())
        self._process.send(frame_of(PUBLISH, head, self._kind.encode(message)))

    def get_subscription_count(self) -> int:
        """Count who listens."""
        return int(self._process.ask("listeners", entity=self.number))

    def guard(self, zero: bytes, kept: tuple[int, int]) -> None:
        """Have the bridge publish this where no velocity comes any more."""
        begin, end = kept
        self._process.ask("guard", entity=self.number, zero=zero.hex(), begin=begin, end=end)

    def encode(self, message: Any) -> bytes:  # noqa: ANN401, D102 - see `RemoteMessage.encode`
        return bytes(self._kind.encode(message))

    def destroy(self) -> None:
        """End it."""
        with suppress(BridgeLost):
            self._process.ask("destroy", entity=self.number)


class Guard:
    """Wakes a wait set."""

    def __init__(self, context: JoinedContext) -> None:
        """Wake those that wait for this context."""
        self._context = context
        self.triggered = False

    @property
    def handle(self) -> Guard:
        """Itself: there is nothing below it."""
        return self

    def trigger_guard_condition(self) -> None:
        """Wake it."""
        with self._context.changed:
            self.triggered = True
            self._context.changed.notify_all()


def _hash_of(kind: object) -> dict[str, str]:
    """Say which class the bridge has to make; of types that it has it takes the installed one."""
    return {"hash": kind.type_hash} if isinstance(kind, PackagelessMessage) else {}
