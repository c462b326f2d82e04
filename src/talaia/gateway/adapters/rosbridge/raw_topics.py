"""Raw topics of a robot behind a rosbridge server, on a connection of their own.

The server takes messages apart, and they are put together here (`message_values`). It could send
the robot's own bytes (``cbor-raw``), but would take the topic from all who read it as JSON then:
see docs/decisions. Of their own, since a message that is too large ends its connection, and since
a server thins a topic for a whole connection: cameras and driving must not suffer from either.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple

from websockets.exceptions import ConnectionClosed, WebSocketException

from talaia.gateway.adapters.rosbridge.protocol import (
    ServerMessage,
    read_message,
    type_for,
    write_frame,
)
from talaia.gateway.adapters.rosbridge.server_graph import TOPICS_SERVICE, read_nodes, read_topics
from talaia.gateway.adapters.rosbridge.server_questions import ServerQuestions
from talaia.gateway.adapters.rosbridge.server_types import ServerTypes
from talaia.gateway.errors import FieldError

if TYPE_CHECKING:
    from collections.abc import Callable

    from websockets.asyncio.client import ClientConnection, connect

    from talaia.clock import Clock
    from talaia.gateway.adapters.rosbridge.robot_definitions import ServerType
    from talaia.gateway.tap_ports import GraphNode, ListedTopic, TapSink, TopicDefinition
    from talaia.model.connection import RosbridgeConnection

__all__ = ["MAX_RAW_FRAME", "RosbridgeTopics"]

log = logging.getLogger(__name__)
# As base64 in JSON a message is a third larger than it is; see `MAX_TAPPED`.
MAX_RAW_FRAME = 48 * 1024 * 1024
# Larger frames are read and serialized on another thread.
_LARGE = 4 * 1024
# The server is asked so often what is published, and for its nodes while they are wanted (s).
_LOOK_S, _NODES_S = 3.0, 10.0
# After a connection was lost; after it had a message that was too large (s).
_AGAIN_S, _LONG_AGAIN_S = 1.0, 30.0
_TOO_LARGE = 1009
_UNREACHED = "the robot cannot be reached"
_NOTHING = ServerMessage("")


class _Heard(NamedTuple):
    """A topic that is subscribed, and how its messages are serialized."""

    listed: ListedTopic
    kind: ServerType


class _Server(NamedTuple):
    """One connection, and what goes on it."""

    socket: ClientConnection
    questions: ServerQuestions
    types: ServerTypes
    sink: TapSink

    async def send(self, op: str, **fields: object) -> None:
        """Say something to the server."""
        await self.socket.send(write_frame(op, **fields))


class RosbridgeTopics:
    """A `TopicSource`: what is published at a server, whether or not it is there just now.

    On the event loop.
    """

    def __init__(
        self,
        *,
        sink: TapSink | None,
        settings: RosbridgeConnection,
        dial: Callable[[], connect],
        clock: Clock,
    ) -> None:
        """Take who is told; with none nothing is listed and nothing heard."""
        self._sink = sink
        self._settings = settings
        self._dial = dial
        self._clock = clock
        self._wanted: frozenset[str] = frozenset()
        self._questions: list[tuple[str, Callable[[TopicDefinition | str], None]]] = []
        # Something is to be done before the next look.
        self._changed = asyncio.Event()
        self._connected = False
        self._graph_wanted = False
        # Why nothing can be listed, as it was told.
        self._problem = ""
        self._forget()

    def _forget(self) -> None:
        self._listed: dict[str, ListedTopic] = {}
        # By topic that is subscribed, and those of them of which a message has come.
        self._heard: dict[str, _Heard] = {}
        self._came: set[str] = set()
        # As they were listed last; None when they are to be listed anew.
        self._nodes: list[GraphNode] | None = None
        self._nodes_at = 0.0

    # ── TopicSource ──

    def tap_topics(self, topics: frozenset[str]) -> None:
        """See `TopicSource.tap_topics`."""
        self._wanted = topics
        self._changed.set()

    def watch_graph(self, *, wanted: bool) -> None:
        """See `GraphSource.watch_graph`."""
        self._graph_wanted = wanted
        self._nodes = None
        self._nodes_at = 0.0
        self._changed.set()

    def define_type(self, type_name: str, done: Callable[[TopicDefinition | str], None]) -> None:
        """See `TopicSource.define_type`."""
        if not self._connected:
            done(_UNREACHED)
            return
        self._questions.append((type_name, done))
        self._changed.set()

    # ── the connection ──

    async def run(self) -> None:
        """List and hear topics until cancelled, whatever becomes of the connection."""
        sink = self._sink
        if sink is None:
            await asyncio.Event().wait()
            return
        while True:
            again = _AGAIN_S
            try:
                async with self._dial() as socket:
                    await self._serve_connection(socket, sink)
            except ConnectionClosed as error:
                if error.sent is not None and error.sent.code == _TOO_LARGE:
                    again = _LONG_AGAIN_S
                    for topic in self._heard:
                        why = f"a message of more than {MAX_RAW_FRAME} bytes came, of it or another"
                        sink.report_problem(topic, why)
            except (OSError, TimeoutError, WebSocketException) as error:
                # That the server is gone is told by who reads signals.
                log.debug("no connection for raw topics: %s", error)
            finally:
                self._connected = False
                self._forget()
                sink.list_topics(())
                for _, done in self._questions:
                    done(_UNREACHED)
                self._questions.clear()
            await asyncio.sleep(again)

    async def _serve_connection(self, socket: ClientConnection, sink: TapSink) -> None:
        questions = ServerQuestions(socket)
        server = _Server(socket, questions, ServerTypes(questions, self._settings.ros), sink)
        self._connected = True
        parts = [
            asyncio.ensure_future(part)
            for part in (self._read_frames(server), self._keep_topics(server))
        ]
        try:
            done, _ = await asyncio.wait(parts, return_when=asyncio.FIRST_COMPLETED)
            for part in done:
                part.result()
        finally:
            for part in parts:
                part.cancel()
            await asyncio.gather(*parts, return_exceptions=True)

    async def _read_frames(self, server: _Server) -> None:
        loop, sink = asyncio.get_running_loop(), server.sink
        async for data in server.socket:
            at_us = self._clock.wall_ns() // 1000
            # One after the other all the same: a topic's messages keep their order.
            if len(data) > _LARGE:
                read = await loop.run_in_executor(None, self._read_frame, data)
            else:
                read = self._read_frame(data)
            said, message = read
            if isinstance(message, bytes):
                heard = self._heard.get(said.topic)
                if heard is not None:
                    self._came.add(said.topic)
                    sink.offer_message(heard.listed, message, log_us=at_us)
            elif message:
                sink.report_problem(said.topic, message)
            else:
                server.questions.take_answer(said)

    def _read_frame(self, data: str | bytes) -> tuple[ServerMessage, bytes | str]:
        """Read a frame, and serialize the message in it; or say why that is not possible."""
        try:
            said = read_message(data)
        except FieldError as error:
            return _NOTHING, str(error)
        heard = self._heard.get(said.topic) if said.op == "publish" else None
        if heard is None:
            return said, ""
        try:
            return said, heard.kind.serializer.serialize_message(said.body)
        except FieldError as error:
            return said, f"what the rosbridge server sent cannot be serialized: {error}"

    # ── what there is, and what is wanted of it ──

    async def _keep_topics(self, server: _Server) -> None:
        loop = asyncio.get_running_loop()
        look_at = 0.0
        while True:
            self._changed.clear()
            if loop.time() >= look_at:
                look_at = loop.time() + _LOOK_S
                await self._list_topics(server)
                await self._ask_silent_topics(server)
            await self._answer_questions(server.types)
            await self._update_taps(server)
            if self._graph_wanted and loop.time() >= self._nodes_at:
                self._nodes_at = loop.time() + _NODES_S
                await self._list_nodes(server)
            try:
                async with asyncio.timeout_at(look_at):
                    await self._changed.wait()
            except TimeoutError:
                continue

    async def _list_topics(self, server: _Server) -> None:
        found = await read_topics(server.questions)
        if isinstance(found, str):
            if self._problem != found:
                self._problem = found
                log.warning(
                    "%s: no raw topics can be handed on: %s (%s). Start rosapi beside the server",
                    self._settings.url,
                    TOPICS_SERVICE,
                    found,
                )
            return
        self._problem = ""
        if found != self._listed:
            self._listed = found
            server.sink.list_topics(list(found.values()))

    async def _list_nodes(self, server: _Server) -> None:
        nodes = await read_nodes(server.questions)
        if nodes is not None and nodes != self._nodes:
            self._nodes = nodes
            server.sink.list_nodes(nodes)

    async def _answer_questions(self, types: ServerTypes) -> None:
        while self._questions:
            type_name, done = self._questions[0]
            found = await types.find_type(type_name)
            self._questions.pop(0)
            done(found if isinstance(found, str) else found.definition)

    async def _update_taps(self, server: _Server) -> None:
        for topic, heard in list(self._heard.items()):
            # Listed as another one it is heard anew. One that is gone may come back.
            if topic not in self._wanted or self._listed.get(topic, heard.listed) != heard.listed:
                del self._heard[topic]
                self._came.discard(topic)
                await server.send("unsubscribe", id=f"tap {topic}", topic=topic)
        for topic in sorted(self._wanted - self._heard.keys()):
            listed = self._listed.get(topic)
            if listed is None:
                continue
            kind = await server.types.find_type(listed.type_name)
            if isinstance(kind, str):
                server.sink.report_problem(topic, kind)
            else:
                self._heard[topic] = _Heard(listed, kind)
                await self._subscribe_topic(server, self._heard[topic])

    async def _ask_silent_topics(self, server: _Server) -> None:
        """Subscribe anew what has never come: see `RosbridgeAdapter`."""
        for topic in self._heard.keys() - self._came:
            await server.send("unsubscribe", id=f"tap {topic}", topic=topic)
            await self._subscribe_topic(server, self._heard[topic])

    async def _subscribe_topic(self, server: _Server, heard: _Heard) -> None:
        topic, type_name, _ = heard.listed
        await server.send(
            "subscribe",
            id=f"tap {topic}",
            topic=topic,
            type=type_for(type_name, self._settings.ros),
            compression="cbor" if self._settings.cbor and heard.kind.cbor else "none",
        )
