"""What one who takes raw topics gets: values that are shared and never changed."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from talaia.hub.live.taps.taker import TopicTap
    from talaia.model.topics import TopicRule
    from talaia.wire.frames import TapSchema

__all__ = [
    "GraphChanged",
    "TapBegun",
    "TapDelivery",
    "TapEnded",
    "TapEvent",
    "TapTopic",
    "TapTrouble",
    "TappedMessage",
    "TopicsChanged",
]


class TapTopic(NamedTuple):
    """A topic that may be tapped.

    Attributes:
        topic: its absolute name.
        type: as its protocol names it: ``package/msg/Name``.
        latched: who comes later gets its last messages, too.
        max_rate: at most so many messages a second are handed on (Hz); 0: all.
        why: why it cannot be tapped now; empty: it can.
        rule: what the description says of it; None: no rule names it.
        rate: how often it comes (Hz), as far as it is known because somebody takes it; else 0.

    """

    topic: str
    type: str
    latched: bool = False
    max_rate: float = 0.0
    why: str = ""
    rule: TopicRule | None = None
    rate: float = 0.0


class TappedMessage(NamedTuple):
    """One message as the robot serialized it; one object for all who take it.

    Attributes:
        topic: its absolute name.
        seq: counts the topic's messages at the gateway, with those that were left out.
        log_us: when it came to the gateway (UTC).
        publish_us: when it was published, by its publisher (UTC); 0 where nobody says.
        kept: it is of a topic that is latched or comes seldom: it is thinned out nowhere.
        data: see `TapSchema.message_encoding`.
        heard_ms: when it came to the hub (monotonic); 0 where nobody said.

    """

    topic: str
    seq: int
    log_us: int
    publish_us: int
    kept: bool
    data: bytes
    heard_ms: int = 0


class TapBegun(NamedTuple):
    """How the next messages of a tap are read: before the first of them, and if it changes."""

    tap: TopicTap
    schema: TapSchema


class TapDelivery(NamedTuple):
    """A message of a tap."""

    tap: TopicTap
    message: TappedMessage


class TapTrouble(NamedTuple):
    """Why messages of a tap are missing; the tap stands."""

    tap: TopicTap
    why: str


class TapEnded(NamedTuple):
    """A tap is over, by no wish of its taker: a right was lost."""

    tap: TopicTap
    why: str


class TopicsChanged(NamedTuple):
    """What `TapFanout.topics` gives of a site may be another list now."""

    site: str


class GraphChanged(NamedTuple):
    """What `GraphWatch.visible_graph` gives of a site may be something else now."""

    site: str


TapEvent = TapBegun | TapDelivery | TapTrouble | TapEnded | TopicsChanged | GraphChanged
