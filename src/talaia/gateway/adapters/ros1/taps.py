"""Raw topics of one ROS 1 robot: which there are, and their messages while somebody wants them.

Which topics there are is the master's to say; how they are read, their publishers'. Messages come
by the node (`rospy_bridge.taps`).
"""

from __future__ import annotations

import asyncio
import threading
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.gateway.adapters.ros1.decode import full_name
from talaia.gateway.adapters.ros1.publications import ask_publisher
from talaia.gateway.adapters.ros1.robot_graph import nodes_of
from talaia.gateway.errors import AdapterLost
from talaia.gateway.tap_ports import ListedTopic, TopicDefinition

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.ros1.frames import TappedPiece
    from talaia.gateway.adapters.ros1.master import RosMaster
    from talaia.gateway.adapters.ros1.node import NodeProcess
    from talaia.gateway.adapters.ros1.publications import Publication
    from talaia.gateway.tap_ports import GraphNode, TapSink

__all__ = ["Ros1TopicSource"]

# The master is asked so often what is published (s).
_LOOK_S = 1.0
# Publishers that are asked for a definition, one after the other, and questions at once.
_MOST_ASKED, _AT_ONCE = 5, 2


class _KnownKind(NamedTuple):
    """What one publisher of a tapped topic has told of its messages."""

    listed: ListedTopic
    md5: str
    fits: bool


class _NodeTap:
    """One topic that the node hears for the hub; after it has begun, of the node's thread."""

    def __init__(self, listed: ListedTopic) -> None:
        self.listed = listed
        # By the node's number.
        self.kinds: dict[int, _KnownKind] = {}
        # Of the message that is not whole yet.
        self.pieces: list[bytes] = []
        self.bytes = 0


class Ros1TopicSource:
    """A `TopicSource`: the topics of an adapter, whether or not ROS is joined just now.

    On the event loop, but for what the node's thread calls.
    """

    def __init__(self, sink: TapSink | None, master: RosMaster) -> None:
        """Take who is told; with none nothing is listed and nothing heard."""
        self._sink = sink
        self._master = master
        self._wanted: frozenset[str] = frozenset()
        self._graph_wanted = False
        self._nodes: list[GraphNode] | None = None  # As they were listed last.
        # None while there is none.
        self._node: NodeProcess | None = None
        # Never given anew, also over nodes.
        self._number = 0
        # By number; the node's thread reads it.
        self._taps: dict[int, _NodeTap] = {}
        # By topic that is heard.
        self._heard: dict[str, int] = {}
        # At once, so that many types do not take all of the loop's workers.
        self._asking = asyncio.Semaphore(_AT_ONCE)
        self._questions: set[asyncio.Task[None]] = set()
        # Guards what follows: both threads change it.
        self._lock = threading.Lock()
        # By topic, as the master said last: its type, and the nodes that publish it.
        self._published: dict[str, tuple[str, frozenset[str]]] = {}
        # Topics with their types of which a publisher has said that it latches.
        self._latched: set[tuple[str, str]] = set()
        self._listed: dict[str, ListedTopic] = {}
        # By type: the MD5 of the definition that the hub has been told, and who tells it.
        self._md5: dict[str, str] = {}
        self._tellers: dict[str, Callable[[TopicDefinition | str], None]] = {}

    # ── on the event loop ──

    async def run(self, node: NodeProcess) -> None:
        """List what is published until cancelled, and hear by this node what is wanted."""
        if self._sink is None:
            return
        loop = asyncio.get_running_loop()
        self._node = node
        try:
            while True:
                try:
                    published = await loop.run_in_executor(None, self._read_published)
                except AdapterLost:
                    # A master that is gone is told by who watches over it.
                    published = None
                if published is not None:
                    with self._lock:
                        self._published = published
                        # Who publishes it next may not latch it.
                        self._latched = {key for key in self._latched if key[0] in published}
                    self._list_topics(self._sink)
                    self._update_taps()
                    if self._graph_wanted:
                        await self._list_nodes(self._sink)
                await asyncio.sleep(_LOOK_S)
        finally:
            self._node = None
            for question in self._questions:
                question.cancel()
            self._taps.clear()
            self._heard.clear()
            with self._lock:
                self._published = {}
                self._latched.clear()
                self._md5.clear()
            self._list_topics(self._sink)

    def tap_topics(self, topics: frozenset[str]) -> None:
        """See `TopicSource.tap_topics`."""
        self._wanted = topics
        self._update_taps()

    def watch_graph(self, *, wanted: bool) -> None:
        """See `GraphSource.watch_graph`."""
        self._graph_wanted = wanted
        self._nodes = None

    def define_type(self, type_name: str, done: Callable[[TopicDefinition | str], None]) -> None:
        """See `TopicSource.define_type`; ``done`` is called again when publishers change it."""
        if self._node is None:
            done("the robot cannot be reached")
            return
        question = asyncio.ensure_future(self._ask_definition(type_name, done))
        self._questions.add(question)
        question.add_done_callback(self._questions.discard)

    async def _ask_definition(
        self, type_name: str, done: Callable[[TopicDefinition | str], None]
    ) -> None:
        nodes = [
            (topic, node)
            for topic, (name, publishers) in self._published.items()
            if name == type_name
            for node in sorted(publishers)
        ]
        loop = asyncio.get_running_loop()
        async with self._asking:
            for topic, node in nodes[:_MOST_ASKED]:
                ask = partial(ask_publisher, self._master, node, topic)
                try:
                    found = await loop.run_in_executor(None, ask)
                except AdapterLost:
                    break
                except asyncio.CancelledError:
                    done("the robot cannot be reached")
                    raise
                if found is not None and full_name(found.type) == type_name:
                    self._learn_definition(type_name, topic, found, done)
                    return
        done("none of its publishers answers" if nodes else "nobody publishes it any more")

    def _learn_definition(
        self,
        type_name: str,
        topic: str,
        found: Publication,
        done: Callable[[TopicDefinition | str], None],
    ) -> None:
        with self._lock:
            self._md5[type_name] = found.md5
            self._tellers[type_name] = done
            if found.latched:
                self._latched.add((topic, type_name))
        if found.latched and self._sink is not None:
            self._list_topics(self._sink)
        done(_definition_of(found.definition))

    async def _list_nodes(self, sink: TapSink) -> None:
        try:
            graph = await asyncio.get_running_loop().run_in_executor(None, self._master.read_graph)
        except AdapterLost:
            return
        nodes = nodes_of(graph)
        if nodes != self._nodes:
            self._nodes = nodes
            sink.list_nodes(nodes)

    def _read_published(self) -> dict[str, tuple[str, frozenset[str]]]:
        types = self._master.read_types()
        published = self._master.read_graph().published
        return {
            topic: (full_name(types[topic]), nodes)
            for topic, nodes in published.items()
            # Some tools register a topic before they know its type.
            if "/" in types.get(topic, "")
        }

    def _update_taps(self) -> None:
        """Bring what the node hears in line with what is wanted and published."""
        node = self._node
        if node is None:
            return
        for topic, number in list(self._heard.items()):
            listed = self._listed.get(topic)
            # As another type it is heard anew. One that is gone may come back.
            other = listed is not None and listed.type_name != self._taps[number].listed.type_name
            if topic not in self._wanted or other:
                del self._heard[topic], self._taps[number]
                node.send_frame(op="untap", tap=number)
        for topic in sorted(self._wanted - self._heard.keys()):
            listed = self._listed.get(topic)
            if listed is not None:
                self._number += 1
                self._taps[self._number] = _NodeTap(listed)
                self._heard[topic] = self._number
                node.send_frame(op="tap", tap=self._number, name=topic)

    # ── on any thread ──

    def _list_topics(self, sink: TapSink) -> None:
        with self._lock:
            listed = {
                topic: ListedTopic(topic, type_name, (topic, type_name) in self._latched)
                for topic, (type_name, _) in self._published.items()
            }
            if listed != self._listed:
                self._listed = listed
                # Under the lock, so that the newest list comes last.
                sink.list_topics(list(listed.values()))

    # ── on the node's thread ──

    def read_frame(self, frame: dict[str, Any]) -> None:
        """Take what the node says of a tap: ``tapped_kind`` or ``tap_problem``."""
        tap = self._taps.get(frame["tap"])
        if tap is None or self._sink is None:
            return
        if frame["op"] == "tapped_kind":
            tap.kinds[frame["kind"]] = self._learn_kind(tap.listed, frame, self._sink)
        else:
            self._sink.report_problem(tap.listed.topic, frame["problem"])

    def _learn_kind(self, listed: ListedTopic, frame: dict[str, Any], sink: TapSink) -> _KnownKind:
        found, md5, latched = full_name(frame["type"]), frame["md5"], frame["latched"]
        known = _KnownKind(listed._replace(latched=latched), md5, fits=found == listed.type_name)
        if not known.fits:
            why = f"a publisher's messages are of type {found}, and not {listed.type_name}"
            sink.report_problem(listed.topic, why)
            return known
        with self._lock:
            changed, self._md5[found] = self._md5.get(found) != md5, md5
            tell = self._tellers.get(found)
            if latched:
                self._latched.add((listed.topic, found))
        if latched:
            self._list_topics(sink)
        if changed and tell is not None:
            tell(_definition_of(frame["definition"]))
        return known

    def read_piece(self, piece: TappedPiece) -> None:
        """Take a piece of a message; hand the message on when it is whole."""
        tap = self._taps.get(piece.tap)
        if tap is None or self._sink is None:
            return
        if piece.at == 0:
            tap.pieces, tap.bytes = [], 0
        # Pieces of one tap come in order, one message after the other.
        tap.pieces.append(piece.data)
        tap.bytes += len(piece.data)
        if tap.bytes < piece.size:
            return
        data = piece.data if len(tap.pieces) == 1 else b"".join(tap.pieces)
        tap.pieces = []
        kind = tap.kinds.get(piece.kind)
        if kind is None or not kind.fits:
            return
        if self._md5.get(kind.listed.type_name) != kind.md5:
            self._sink.report_problem(
                kind.listed.topic,
                f"publishers have different definitions of {kind.listed.type_name}; "
                "what is not of the newest is left out",
            )
            return
        self._sink.offer_message(kind.listed, data, log_us=piece.time_us)


def _definition_of(text: str) -> TopicDefinition:
    return TopicDefinition("ros1msg" if text else "", text, "ros1")
