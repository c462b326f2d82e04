"""One page that follows one raw topic: a socket, and what is read for it.

Long, because trees and bytes share one socket, its bounds and its end.
"""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING

from starlette.websockets import WebSocketDisconnect

from talaia.first_completed import until_first
from talaia.hub.errors import TapRefused
from talaia.hub.live.pages.page_connections import SESSION_OVER
from talaia.hub.live.taps.cloud_thinning import CLOUD_TYPE, thin_cloud
from talaia.hub.live.taps.message_tree import tree_reader
from talaia.hub.live.taps.tapped import (
    GraphChanged,
    TapBegun,
    TapDelivery,
    TapEnded,
    TapTrouble,
    TopicsChanged,
)
from talaia.hub.live.taps.type_texts import MessageUnreadable
from talaia.wire.browser import (
    MAX_RAW,
    TOPIC_FROM_BROWSER,
    TOPIC_TO_BROWSER,
    RequestError,
    SessionEnded,
    TopicBytes,
    TopicMessage,
    TopicUpdate,
)
from talaia.wire.errors import PeerError, UnknownKind

if TYPE_CHECKING:
    from collections.abc import Callable

    from starlette.websockets import WebSocket

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.taps.tap_fanout import TapFanout
    from talaia.hub.live.taps.tapped import TapEvent, TappedMessage
    from talaia.hub.live.taps.tree_lane import TreeLane
    from talaia.wire.browser import TopicToBrowser
    from talaia.wire.frames import TapSchema

__all__ = ["DEFAULT_RATE", "MOST_RATE", "MOST_RAW_RATE", "TopicViewer"]

# Messages a second, of a topic that comes oftener: what a person can follow; what a page may ask.
DEFAULT_RATE, MOST_RATE = 4.0, 20.0
# Of one that reads the bytes itself: transforms of many parts come on one topic.
MOST_RAW_RATE = 100.0
# Messages under way to the page that it has not confirmed: one that reads slowly gets fewer, and
# none is old when it comes.
_MOST_UNDER_WAY, _MOST_RAW_UNDER_WAY = 4, 16
# Bytes of them, beside the first: of clouds one is under way, or what waits on the line would be
# seconds old.
_MOST_BYTES_UNDER_WAY = 1024 * 1024
# Bytes of a message that is handed on as it is, although a newer one waits: transforms and joints
# that come behind one another are often of different parts.
_LIGHT = 4096
# A page that confirms nothing for so long is not there (s); it may come back.
_SILENT_S = 20.0
# Bytes of messages that wait, beside the newest; and messages that are looked at together.
_MOST_WAITING, _MOST_TOGETHER = 1024 * 1024, 64
_MOST_DEFINITION = 64 * 1024
# A page that does not read must not hold up the end (s).
_FAREWELL_S = 0.3
# What a socket raises when the other side has gone or does not take anything.
_GONE = (WebSocketDisconnect, RuntimeError, OSError, TimeoutError)


class _Over(Exception):
    """There is no more to come; what the page is told has been sent."""


class TopicViewer:
    """One page that follows one topic. A `SessionSocket`."""

    def __init__(
        self,
        socket: WebSocket,
        *,
        who: Who,
        site: str,
        topic: str,
        taps: TapFanout,
        lane: TreeLane,
        clock: Clock,
        text: bool,
        points: int = 0,
    ) -> None:
        """Follow ``topic`` of ``site``; JSON with ``text``.

        Args:
            socket: accepted already.
            who: looks.
            site: see above.
            topic: its absolute name.
            taps: hands the messages over, and knows who may have what.
            lane: reads the messages.
            clock: monotonic.
            text: see above.
            points: hand the bytes on, of a cloud at most so many points; 0: trees.

        """
        self.who = who
        self._socket = socket
        self._site = site
        self._topic = topic
        self._taps = taps
        self._lane = lane
        self._clock = clock
        self._text = text
        self._points = points
        self._taker = taps.taker(who.grants, most_bytes=_MOST_WAITING)
        self._schema: TapSchema | None = None
        # Reads messages of the schema; None when there is none that could.
        self._read: Callable[[bytes], dict[str, object]] | None = None
        # As the page was told it last.
        self._told: TopicUpdate | None = None
        self._problem = ""
        # Numbers of the message that was sent last and of the one that was confirmed last.
        self._sent = self._shown = 0
        self._confirmed = asyncio.Event()
        # Number and bytes of what was sent and is not confirmed, the oldest first.
        self._under_way: deque[tuple[int, int]] = deque()
        # The session is over, and why.
        self._over = asyncio.Event()
        self._reason = ""

    # ── for the session ──

    def end(self, reason: str) -> None:
        """Close, since the session is over."""
        self._reason = reason
        self._over.set()

    def tell_end(self, ends_us: int, *, idle: bool) -> None:
        """Say nothing: the page's other socket tells the person."""

    def take_use(self) -> bool:
        """To look is no use of a session: a page that is left open does not keep it alive."""
        return False

    # ── the socket ──

    async def serve(self, max_rate: float = DEFAULT_RATE) -> None:
        """Send messages until either side ends it.

        Args:
            max_rate: messages a second of a topic that comes oftener (Hz).

        """
        try:
            # Whichever ends first ends all: the page, the topic, or the session.
            results = await until_first(
                self._receive(), self._send_events(max_rate), self._over.wait()
            )
        finally:
            # Before any farewell: the robot is not heard for a page that goes.
            self._taps.remove_taker(self._taker)
        code = SESSION_OVER if self._over.is_set() else 1000
        for result in results:
            if isinstance(result, PeerError):
                code = result.code
            elif isinstance(result, Exception) and not isinstance(result, (*_GONE, _Over)):
                raise result
        await self._farewell(code)

    async def _receive(self) -> None:
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            data = event.get("bytes")
            try:
                said = TOPIC_FROM_BROWSER.decode(event.get("text", "") if data is None else data)
            except UnknownKind:
                # A page that is newer than we are.
                continue
            # Never beyond what was sent: a page cannot make room for more than it has got.
            self._shown = max(self._shown, min(said.number, self._sent))
            while self._under_way and self._under_way[0][0] <= self._shown:
                self._under_way.popleft()
            self._confirmed.set()

    async def _send_events(self, max_rate: float) -> None:
        self._taps.follow_topics(self._site, self._taker)
        try:
            self._taps.subscribe(self._site, self._topic, self._taker, max_rate=max_rate)
        except TapRefused as error:
            # The description has changed since the socket was let in.
            await self._send_problem("forbidden", str(error))
            raise _Over from error
        await self._send_update()
        while True:
            for event in await self._next_events():
                match event:
                    case TapBegun():
                        await self._begin(event.schema)
                    case TapDelivery():
                        await self._send_message(event.message)
                    case TapTrouble():
                        # The tap stands, and messages may come again.
                        await self._send_problem("topic", event.why)
                    case TapEnded():
                        await self._send_problem("forbidden", event.why)
                        raise _Over
                    case TopicsChanged():
                        await self._send_update()
                    case GraphChanged():
                        pass  # Nobody here follows the robot's nodes.

    async def _next_events(self) -> list[TapEvent]:
        """Wait for what is to be told next; of a topic that comes often only the newest is left."""
        events = [await self._taker.next_event()]
        while len(events) < _MOST_TOGETHER and (event := self._taker.pop_event()) is not None:
            events.append(event)
        newest = max(
            (at for at, event in enumerate(events) if isinstance(event, TapDelivery)), default=-1
        )
        return [
            event
            for at, event in enumerate(events)
            if at == newest
            or not isinstance(event, TapDelivery)
            or event.message.kept
            or (self._points and len(event.message.data) <= _LIGHT)
        ]

    async def _begin(self, schema: TapSchema) -> None:
        self._schema, self._problem = schema, ""
        await self._send_update()
        if self._points:
            return
        try:
            self._read = tree_reader(schema)
        except MessageUnreadable as error:
            self._read = None
            await self._send_problem("unreadable", schema.problem or str(error))

    async def _send_update(self) -> None:
        topics = self._taps.topics(self._site, self.who.grants)
        found = next((one for one in topics if one.topic == self._topic), None)
        # A topic that nobody publishes any more has the type that it had.
        kind = found.type if found else self._told.type if self._told else ""
        schema = self._schema
        definition = schema.definition if schema is not None and schema.type == kind else ""
        update = TopicUpdate(
            listed=found is not None,
            type=kind,
            latched=found is not None and found.latched,
            max_rate=found.max_rate if found else 0.0,
            definition=definition[:_MOST_DEFINITION],
            problem=found.why if found else "",
        )
        # Lists of topics change often, and seldom what they say of this one.
        if update != self._told:
            self._told = update
            await self._send(update)

    async def _send_message(self, message: TappedMessage) -> None:
        if self._points:
            await self._send_bytes(message)
            return
        # Why it cannot be read has been told.
        read = self._read
        if read is None:
            return
        # Before it is read: what the page has no room for costs nothing.
        await self._wait_for_room()
        try:
            tree = await self._lane.encode_tree(read, message.data)
        except MessageUnreadable as error:
            await self._send_problem("unreadable", str(error))
            return
        now_ms = self._clock.monotonic_ns() // 1_000_000
        self._problem = ""
        self._sent += 1
        await self._send(
            TopicMessage(
                number=self._sent,
                seq=message.seq,
                time_us=message.log_us,
                publish_us=message.publish_us,
                age_ms=max(0, now_ms - message.heard_ms) if message.heard_ms else 0,
                size=len(message.data),
                tree=tree,
            )
        )

    async def _send_bytes(self, message: TappedMessage) -> None:
        schema = self._schema
        if schema is None:
            return
        waited = await self._wait_for_room(len(message.data))
        if waited and not message.kept and len(message.data) > _LIGHT and self._taker.waiting_bytes:
            # A newer one has come meanwhile.
            return
        data, every = message.data, 1
        ros1 = schema.message_encoding == "ros1"
        if schema.type == CLOUD_TYPE:
            data, every = await asyncio.to_thread(thin_cloud, data, self._points, ros1=ros1)
        if len(data) > MAX_RAW:
            await self._send_problem("topic", f"a message of {len(data)} bytes is too large")
            return
        now_ms = self._clock.monotonic_ns() // 1_000_000
        self._problem = ""
        self._sent += 1
        self._under_way.append((self._sent, len(data)))
        await self._send(
            TopicBytes(
                number=self._sent,
                seq=message.seq,
                time_us=message.log_us,
                publish_us=message.publish_us,
                age_ms=max(0, now_ms - message.heard_ms) if message.heard_ms else 0,
                encoding="ros1" if ros1 else "cdr",
                every=every,
                data=data,
            )
        )

    async def _wait_for_room(self, size: int = 0) -> bool:
        """Wait until the page has confirmed enough of what was sent.

        Args:
            size: bytes of what is to be sent.

        Returns:
            Whether there was none at first.

        Raises:
            TimeoutError: it does not.

        """
        waited = False
        async with asyncio.timeout(_SILENT_S):
            while not self._has_room(size):
                waited = True
                self._confirmed.clear()
                await self._confirmed.wait()
        return waited

    def _has_room(self, size: int) -> bool:
        most = _MOST_RAW_UNDER_WAY if self._points else _MOST_UNDER_WAY
        waiting = sum(taken for _, taken in self._under_way)
        full = bool(waiting) and waiting + size > _MOST_BYTES_UNDER_WAY
        return self._sent - self._shown < most and not full

    async def _send_problem(self, code: str, why: str) -> None:
        # Each once, however many messages it is about.
        if why != self._problem:
            self._problem = why
            await self._send(RequestError(code=code, message=why[:2000]))

    async def _send(self, message: TopicToBrowser) -> None:
        if self._text:
            await self._socket.send_text(TOPIC_TO_BROWSER.encode_text(message))
        else:
            await self._socket.send_bytes(TOPIC_TO_BROWSER.encode(message))

    async def _farewell(self, code: int) -> None:
        try:
            async with asyncio.timeout(_FAREWELL_S):
                if code == SESSION_OVER:
                    await self._send(SessionEnded(reason=self._reason))
                await self._socket.close(code)
        except _GONE:
            return
