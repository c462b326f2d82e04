"""Raw topics of one ROS 2 node: which there are, and their messages while somebody wants them.

On the wait-set thread. Its subscriptions are its own: they are there only while a topic is wanted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rclpy.qos import DurabilityPolicy

from talaia.gateway.adapters.ros2.nodes.robot_graph import GraphReader
from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import PACE_S
from talaia.gateway.adapters.ros2.subscriptions import Ros2Subscriptions
from talaia.gateway.adapters.ros2.type_definitions.definition_text import definition_text
from talaia.gateway.adapters.ros2.type_definitions.installed_package import installed_definition
from talaia.gateway.adapters.ros2.type_definitions.robot_questions import hash_of
from talaia.gateway.tap_ports import ListedTopic, TopicDefinition

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.adapters.arrival_times import Arrivals
    from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
    from talaia.gateway.adapters.ros2.topic_types import TopicType, TopicTypes
    from talaia.gateway.tap_ports import TapSink

__all__ = ["Ros2Taps", "Ros2TopicSource"]

# Messages that wait between two turns of the wait set, and those of latched publishers that come
# at one blow.
_DEPTH = 100
# What is listed already is looked at again at every so manieth look; what is new at each.
_AGAIN_EVERY = 8
# The graph is read at every so manieth turn, and publishers of what is heard at every so manieth.
_GRAPH_EVERY, _PUBLISHERS_EVERY = 2, 4
# Who publishes and subscribes what is read, while somebody wants to know it, at every so manieth.
_NODES_EVERY = 4
# Of the thread's turns while something is tapped (s): who looks on wants it soon.
_TAPPED_PACE_S = 0.002


class Ros2TopicSource:
    """A `TopicSource`: the taps of an adapter, whether or not ROS is joined just now.

    It also says how long the turns of the adapter's thread are, by who looks.
    """

    def __init__(self, sink: TapSink | None, clock: Clock, arrivals: Arrivals) -> None:
        """Take who is told; with none nothing is listed and nothing heard."""
        self._sink = sink
        self._clock = clock
        self._arrivals = arrivals
        # Replaced whole, so any thread may read it.
        self._wanted: frozenset[str] = frozenset()
        # Made and let go while the thread does not run.
        self._taps: Ros2Taps | None = None
        self._thread: WaitThread | None = None
        self._turn = 0
        # Signals that are read by the same thread are wanted so often (s).
        self._turn_s = PACE_S
        # Replaced, so any thread may read it; the reader is made and let go as `_taps` is.
        self._graph_wanted = False
        self._graph: GraphReader | None = None

    def join(self, node: Any, thread: WaitThread, types: TopicTypes) -> None:  # noqa: ANN401
        """Begin with a node; its thread does not run yet."""
        self._thread = thread
        thread.run_soon(self._hurry)
        if self._sink is not None:
            find_class, complain = types.class_for, self._sink.report_problem
            self._taps = Ros2Taps(
                node=node,
                subscriptions=Ros2Subscriptions(node, thread, find_class, complain),
                types=types,
                sink=self._sink,
                clock=self._clock,
                arrivals=self._arrivals,
            )
            self._graph = GraphReader(node, thread, self._sink)

    def leave(self) -> None:
        """Let the node go; its thread has ended."""
        taps, self._taps, self._thread = self._taps, None, None
        self._graph = None
        if taps is not None:
            taps.close()

    def shorten_turns(self, turn_s: float) -> None:
        """See `PacedAdapter.shorten_turns`; on the event loop."""
        if turn_s != self._turn_s:
            self._turn_s = turn_s
            if self._thread is not None:
                self._thread.run_soon(self._hurry)

    def tap_topics(self, topics: frozenset[str]) -> None:
        """See `TopicSource.tap_topics`; on the event loop."""
        self._wanted = topics
        thread = self._thread
        if thread is not None:
            thread.run_soon(self._update)

    def watch_graph(self, *, wanted: bool) -> None:
        """See `GraphSource.watch_graph`; on the event loop."""
        self._graph_wanted = wanted
        graph, thread = self._graph, self._thread
        if graph is not None and thread is not None and wanted:
            thread.run_soon(graph.begin_anew)

    def define_type(self, type_name: str, done: Callable[[TopicDefinition | str], None]) -> None:
        """See `TopicSource.define_type`; on the event loop."""
        taps, thread = self._taps, self._thread
        if taps is None or thread is None:
            done("the robot cannot be reached")
        else:
            thread.run_soon(lambda: taps.define_type(type_name, done))

    def look_again(self) -> None:
        """Look at the graph, and at who publishes; about twice a second, on the thread."""
        if self._taps is not None:
            if self._turn % _GRAPH_EVERY == 0:
                self._taps.look_at_graph()
            self._update(everything=self._turn % _PUBLISHERS_EVERY == 0)
            self._turn += 1
        if self._graph is not None and self._graph_wanted and self._turn % _NODES_EVERY == 0:
            self._graph.read_nodes()

    def _hurry(self) -> None:
        if self._thread is not None:
            self._thread.shorten_turns("signals", self._turn_s)

    def _update(self, *, everything: bool = True) -> None:
        if self._taps is not None and self._thread is not None:
            heard = self._taps.want_topics(self._wanted, everything=everything)
            self._thread.shorten_turns("taps", _TAPPED_PACE_S if heard else PACE_S)


class Ros2Taps:
    """All topics of a node's graph."""

    def __init__(
        self,
        *,
        node: Any,  # noqa: ANN401 - rclpy ships no types
        subscriptions: Ros2Subscriptions,
        types: TopicTypes,
        sink: TapSink,
        clock: Clock,
        arrivals: Arrivals,
    ) -> None:
        """Hear nothing yet.

        Args:
            node: of rclpy.
            subscriptions: nobody else's.
            types: tells how types are read.
            sink: takes lists and messages.
            clock: for times of arrival.
            arrivals: makes times of arrival out of the transport's.

        """
        self._node = node
        self._subscriptions = subscriptions
        self._types = types
        self._sink = sink
        self._clock = clock
        self._arrivals = arrivals
        self._listed: dict[str, ListedTopic] = {}
        # By topic that is heard: as it was listed then.
        self._heard: dict[str, ListedTopic] = {}
        self._looks = 0

    def look_at_graph(self) -> None:
        """List what is published now, if it is something else than before."""
        again = self._looks % _AGAIN_EVERY == 0
        self._looks += 1
        listed = {}
        for topic, types in self._node.get_topic_names_and_types():
            known = self._listed.get(topic)
            # A name that begins so is hidden: the parts of an action.
            if "/_" in topic:
                continue
            if known is None or again or known.type_name not in types:
                known = self._read_topic(topic)
            elif not self._node.count_publishers(topic):
                known = None
            if known is not None:
                listed[topic] = known
        if listed != self._listed:
            self._listed = listed
            self._sink.list_topics(list(listed.values()))

    def want_topics(self, topics: frozenset[str], *, everything: bool = True) -> bool:
        """Hear these of the topics that are there, and no others; give whether there are any.

        Args:
            topics: absolute names.
            everything: also look whether those that are heard have other publishers now.

        """
        for topic, heard in list(self._heard.items()):
            # Listed as another one: it is heard anew, under its new number.
            if topic not in topics or self._listed.get(topic, heard) != heard:
                del self._heard[topic]
                self._subscriptions.unwant(topic)
        for topic in topics - self._heard.keys():
            listed = self._listed.get(topic)
            if listed is not None:
                self._heard[topic] = listed
                self._subscriptions.want(
                    topic,
                    topic,
                    listed.type_name,
                    depth=_DEPTH,
                    reader=_TapReader(listed, self._hand_on),
                )
        self._subscriptions.match_publishers(everything=everything)
        return bool(self._heard)

    def define_type(self, type_name: str, done: Callable[[TopicDefinition | str], None]) -> None:
        """See `TopicSource.define_type`."""
        topics = [topic for topic, listed in self._listed.items() if listed.type_name == type_name]
        infos = [
            info
            for topic in topics[:1]
            for info in self._node.get_publishers_info_by_topic(topic)
            if info.topic_type == type_name
        ]
        if not infos:
            done("nobody publishes it any more")
            return

        def on_found(found: TopicType | None) -> None:
            if found is None:
                done("its definition is not known: see the gateway's log for what to do")
                return
            # An installed package's text is not told with it.
            text = found.schema or _installed_text(type_name)
            done(TopicDefinition("ros2msg" if text else "", text, "cdr"))

        self._types.find(topics[0], type_name, hash_of(infos[0]), on_found)

    def close(self) -> None:
        """List nothing: the node is gone."""
        self._sink.list_topics(())

    def _read_topic(self, topic: str) -> ListedTopic | None:
        infos = self._node.get_publishers_info_by_topic(topic)
        if not infos:
            return None
        # Of several types the one that is listed stays, as long as somebody publishes it.
        types = [str(info.topic_type) for info in infos]
        known = self._listed.get(topic)
        type_name = known.type_name if known and known.type_name in types else types[0]
        latched = any(
            info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for info in infos
        )
        return ListedTopic(topic, type_name, latched)

    def _hand_on(self, listed: ListedTopic, raw: bytes, info: Any) -> None:  # noqa: ANN401
        now_us, now_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
        self._sink.offer_message(
            listed,
            raw,
            log_us=self._arrivals.arrival_time(info["received_timestamp"] // 1000, now_us, now_ns),
            publish_us=max(0, info["source_timestamp"] // 1000),
        )


class _TapReader:
    """A `TopicReader`: messages go on as they are, whatever version of their type they are of."""

    def __init__(
        self, listed: ListedTopic, hand_on: Callable[[ListedTopic, bytes, Any], None]
    ) -> None:
        self._listed = listed
        self._hand_on = hand_on

    def set_publishers(self, hashes: frozenset[str]) -> None:
        """Take any."""

    def read_message(self, raw: bytes, info: Any) -> None:  # noqa: ANN401
        """Hand it on."""
        self._hand_on(self._listed, raw, info)


def _installed_text(type_name: str) -> str:
    definition = installed_definition(type_name)
    return "" if definition is None else definition_text(definition)
