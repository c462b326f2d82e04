"""Which topics the hub wants raw, which there are, and the way of their messages to it."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Protocol

from talaia.gateway.tap_ports import TopicDefinition
from talaia.gateway.taps.outbox import RawTap
from talaia.gateway.taps.site_graph import SiteGraph
from talaia.wire.frames import (
    MAX_TAPPED,
    MAX_TOPICS,
    TapError,
    TapSchema,
    TopicEntry,
    TopicList,
)
from talaia.wire.topic_queue import ArrivalMeter, RateGate

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from talaia.clock import Clock
    from talaia.gateway.tap_ports import GraphNode, ListedTopic
    from talaia.gateway.taps.outbox import TapOutbox
    from talaia.wire.frames import TapSubscription

__all__ = ["ConnectionTaps", "TapService", "TappedAdapter"]

# What a name may have on the wire (letters), and a definition (bytes).
_LONGEST, _LARGEST = 200, 512 * 1024


class TappedAdapter(Protocol):
    """All connections of the site as one, as far as they have topics; see `TopicSource`."""

    def tap_topics(self, topics: frozenset[str]) -> None:
        """Hear these and no others."""
        ...

    def watch_graph(self, *, wanted: bool) -> None:
        """List nodes; see `GraphSource`."""
        ...

    def define_type(
        self, connection: str, type_name: str, done: Callable[[TopicDefinition | str], None]
    ) -> None:
        """Tell how a type of a connection's topics is read, or why that is not known."""
        ...


class _WantedTap:
    """One topic that is wanted; used by its adapter's thread."""

    def __init__(self, topic: str, max_rate: float, seq: int) -> None:
        self.topic = topic
        self.max_rate = max_rate
        self.gate = RateGate(max_rate)
        self.meter = ArrivalMeter()
        # Messages that came since it was wanted first.
        self.seq = seq
        # Why messages are missing, as it was told.
        self.problem = ""


class TapService:
    """What adapters hear goes to the hub, as long as it wants that.

    Used on the event loop, but for what `ConnectionTaps` calls from any thread.
    """

    def __init__(self, *, clock: Clock, outbox: TapOutbox) -> None:
        """Send by ``outbox``; ``clock`` is monotonic, for rates."""
        self._clock = clock
        self._outbox = outbox
        outbox.on_linked = self._begin_media
        self._adapter: TappedAdapter | None = None
        # Called, on any thread, with each message before it goes to the hub.
        self.on_message: Callable[[ListedTopic, bytes], None] = lambda _topic, _data: None
        # The hub of this link takes lists, schemas and messages.
        self._taken = False
        # Whether the hub wants to know of nodes.
        self._graph_wanted = False
        # Types whose definitions the hub has not, as it said last.
        self._asked_types: tuple[str, ...] = ()
        # Replaced whole by the loop, read by the adapters' threads, as are the numbers of topics
        # and types that are listed now.
        self._wanted: dict[str, _WantedTap] = {}
        self._sendable: dict[tuple[str, str], int] = {}
        # Guards what follows: connections list their topics on threads of their own.
        self._lock = threading.Lock()
        # By connection: what it lists.
        self._listed: dict[str, tuple[ListedTopic, ...]] = {}
        # By topic and type; never given anew in this run.
        self._numbers: dict[tuple[str, str], int] = {}
        self._graph = SiteGraph()

    def attach_adapter(self, adapter: TappedAdapter) -> None:
        """Take who is told what to hear."""
        self._adapter = adapter

    # ── from the hub ──

    def link_up(self, *, takes: bool) -> None:
        """Begin with a hub that wants nothing yet, and that ``takes`` lists or is of old."""
        self._taken = takes
        # The connection for pictures may have outlived the former link.
        self._begin_media()

    def link_lost(self) -> None:
        """Let all topics rest: there is nobody who wants them."""
        self._taken = False
        self._asked_types = ()
        self._want({})
        self._want_graph(wanted=False)

    def _begin_media(self) -> None:
        """Tell a new connection for pictures which topics there are, and what was asked for."""
        if self._taken:
            with self._lock:
                self._outbox.enqueue_notice(self._list())
                if self._graph.known:
                    self._outbox.enqueue_notice(self._graph.message())
            self._tell_schemas(self._asked_types)

    def subscribe(self, asked: TapSubscription) -> None:
        """Hear what the hub wants now and nothing else; tell the definitions that it has not."""
        wanted = {}
        for topic, rate in asked.topics.items():
            before = self._wanted.get(topic)
            if before is None or before.max_rate != rate:
                # The hub's count goes on.
                before = _WantedTap(topic, rate, 0 if before is None else before.seq)
            wanted[topic] = before
        self._want(wanted)
        self._want_graph(wanted=asked.graph)
        new = tuple(name for name in asked.types if name not in self._asked_types)
        self._asked_types = tuple(asked.types)
        self._tell_schemas(new)

    def _want(self, wanted: dict[str, _WantedTap]) -> None:
        before, self._wanted = self._wanted, wanted
        for (topic, _), number in self._sendable.items():
            if topic in before and topic not in wanted:
                self._outbox.forget_topic(number)
        if before.keys() != wanted.keys() and self._adapter is not None:
            self._adapter.tap_topics(frozenset(wanted))

    def _want_graph(self, *, wanted: bool) -> None:
        if wanted == self._graph_wanted:
            return
        self._graph_wanted = wanted
        with self._lock:
            # What was known is soon no longer so.
            self._graph.clear()
        if self._adapter is not None:
            self._adapter.watch_graph(wanted=wanted)

    def _tell_schemas(self, types: Sequence[str]) -> None:
        for type_name in types:
            with self._lock:
                connection = next(
                    (
                        name
                        for name, topics in self._listed.items()
                        if any(topic.type_name == type_name for topic in topics)
                    ),
                    None,
                )
            if connection is None or self._adapter is None:
                self._tell_schema(type_name, "nobody publishes it any more")
            else:
                self._adapter.define_type(connection, type_name, self._teller(type_name))

    def _teller(self, type_name: str) -> Callable[[TopicDefinition | str], None]:
        return lambda found: self._tell_schema(type_name, found)

    def _tell_schema(self, type_name: str, found: TopicDefinition | str) -> None:
        if isinstance(found, TopicDefinition) and len(found.definition) > _LARGEST:
            found = f"its definition has more than {_LARGEST} letters"
        if isinstance(found, str):
            schema = TapSchema(type=type_name, problem=found[:2000])
        else:
            schema = TapSchema(
                type=type_name,
                encoding=found.encoding,
                definition=found.definition,
                message_encoding=found.message_encoding,
            )
        self._outbox.enqueue_notice(schema)

    # ── for `ConnectionTaps`, any thread ──

    def list_topics(self, connection: str, topics: Sequence[ListedTopic]) -> None:
        """Take all topics of a connection; see `TapSink.list_topics`."""
        with self._lock:
            # The wire's own limits: what has no room there is left out here.
            fitting = tuple(
                topic
                for topic in topics
                if len(topic.topic) <= _LONGEST and 0 < len(topic.type_name) <= _LONGEST
            )
            if self._listed.get(connection, ()) == fitting:
                return
            self._listed[connection] = fitting
            told = self._list()
            if self._taken:
                # Under the lock, so that the newest list comes last.
                self._outbox.enqueue_notice(told)

    def offer_message(
        self, topic: ListedTopic, data: bytes, *, log_us: int, publish_us: int
    ) -> None:
        """Take a message; see `TapSink.offer_message`."""
        wanted = self._wanted.get(topic.topic)
        number = self._sendable.get((topic.topic, topic.type_name))
        if wanted is None or number is None:
            return
        now_us = self._clock.monotonic_ns() // 1000
        wanted.seq += 1
        kept = wanted.meter.count_arrival(now_us) or topic.latched
        if not wanted.gate.passes(now_us) and not kept:
            return
        if len(data) > MAX_TAPPED:
            self.report_problem(
                topic.topic, f"a message of {len(data)} bytes is too large to be handed on"
            )
            return
        self.on_message(topic, data)
        self._outbox.enqueue_message(RawTap(number, wanted.seq, log_us, publish_us, kept, data))

    def report_problem(self, topic: str, why: str) -> None:
        """Tell why a topic cannot be heard, once; see `TapSink.report_problem`."""
        wanted = self._wanted.get(topic)
        if wanted is not None and wanted.problem != why:
            wanted.problem = why
            self._outbox.enqueue_notice(TapError(topic=topic, why=why[:2000]))

    def list_nodes(self, connection: str, nodes: Sequence[GraphNode], distro: str) -> None:
        """Take all nodes of a connection; see `TapSink.list_nodes`."""
        with self._lock:
            # What comes after it was wanted last is let go.
            changed = self._graph_wanted and self._graph.replace_nodes(connection, nodes, distro)
            if changed and self._taken:
                self._outbox.enqueue_notice(self._graph.message())

    def _list(self) -> TopicList:
        """Give the list as it is now, and let what is in it be sent. Under the lock."""
        # Of one name in two connections the first counts.
        by_name: dict[str, ListedTopic] = {}
        for topics in self._listed.values():
            for topic in topics:
                by_name.setdefault(topic.topic, topic)
        entries = []
        for _, found in sorted(by_name.items())[:MAX_TOPICS]:
            key = found.topic, found.type_name
            number = self._numbers.setdefault(key, len(self._numbers) + 1)
            entries.append(
                TopicEntry(
                    number=number,
                    topic=found.topic,
                    type=found.type_name,
                    latched=found.latched,
                )
            )
        self._sendable = {(entry.topic, entry.type): entry.number for entry in entries}
        return TopicList(topics=entries, left_out=max(0, len(by_name) - MAX_TOPICS))


class ConnectionTaps:
    """A `TapSink`: the topics of one connection."""

    def __init__(self, service: TapService, connection: str) -> None:
        """Name the connection."""
        self._service = service
        self._connection = connection

    def list_topics(self, topics: Sequence[ListedTopic]) -> None:
        """See `TapSink.list_topics`."""
        self._service.list_topics(self._connection, topics)

    def offer_message(
        self, topic: ListedTopic, data: bytes, *, log_us: int, publish_us: int = 0
    ) -> None:
        """See `TapSink.offer_message`."""
        self._service.offer_message(topic, data, log_us=log_us, publish_us=publish_us)

    def report_problem(self, topic: str, why: str) -> None:
        """See `TapSink.report_problem`."""
        self._service.report_problem(topic, why)

    def list_nodes(self, nodes: Sequence[GraphNode], distro: str = "") -> None:
        """See `TapSink.list_nodes`."""
        self._service.list_nodes(self._connection, nodes, distro)
