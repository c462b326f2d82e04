"""The promises between adapters and those who hand raw topics on."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

__all__ = [
    "GraphNode",
    "GraphSource",
    "ListedTopic",
    "TapSink",
    "TopicDefinition",
    "TopicSource",
]


class ListedTopic(NamedTuple):
    """A topic that somebody publishes; latched: who comes later gets its last messages, too."""

    topic: str
    type_name: str
    latched: bool = False


class TopicDefinition(NamedTuple):
    """How messages of a type are read; see `talaia.wire.frames.TapSchema`."""

    encoding: str
    definition: str
    message_encoding: str


class GraphNode(NamedTuple):
    """A node of the robot, and the absolute names of its topics and services, in order."""

    name: str
    publishes: tuple[str, ...] = ()
    subscribes: tuple[str, ...] = ()
    serves: tuple[str, ...] = ()


class TapSink(Protocol):
    """Takes the raw topics of one connection for the hub; any thread; never blocks."""

    def list_topics(self, topics: Sequence[ListedTopic]) -> None:
        """Take all that is published now; before messages of what is new in it."""
        ...

    def offer_message(
        self, topic: ListedTopic, data: bytes, *, log_us: int, publish_us: int = 0
    ) -> None:
        """Take a message as it came.

        Args:
            topic: as it was listed.
            data: never changed from here on.
            log_us: when it came (UTC).
            publish_us: when it was published, by its publisher (UTC); 0 where nobody says.

        """
        ...

    def report_problem(self, topic: str, why: str) -> None:
        """Take why a topic cannot be heard; said again while it lasts."""
        ...

    def list_nodes(self, nodes: Sequence[GraphNode], distro: str = "") -> None:
        """Take all nodes there are now, and the distribution of ROS; see `GraphSource`."""
        ...


@runtime_checkable
class TopicSource(Protocol):
    """An adapter that has topics: it lists them to its `TapSink`, and hears them while asked."""

    def tap_topics(self, topics: frozenset[str]) -> None:
        """Hear these and no others for the `TapSink`; what is not there yet is waited for."""
        ...

    def define_type(self, type_name: str, done: Callable[[TopicDefinition | str], None]) -> None:
        """Tell how a type is read, or why that is not known; ``done`` is called on any thread."""
        ...


@runtime_checkable
class GraphSource(Protocol):
    """An adapter that has nodes: it lists them to its `TapSink` while it is asked to."""

    def watch_graph(self, *, wanted: bool) -> None:
        """List all nodes soon and on every change, or ask the robot for them no more."""
        ...
