"""Raw topics of the robot on their way from a gateway to its hub, each while somebody wants it.

`TapSubscription` comes on the link; all else goes on the connection for pictures, behind them.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import PIECE, Count, Micros, Name, Sentence, Word
from talaia.wire.message import Message

__all__ = [
    "MAX_TAPPED",
    "MAX_TOPICS",
    "TapError",
    "TapMessage",
    "TapSchema",
    "TapSubscription",
    "TopicEntry",
    "TopicList",
]

# Bytes of one message of the robot; a larger one is left out, and its topic's takers are told.
MAX_TAPPED = 32 * 1024 * 1024
# Topics that a gateway lists.
MAX_TOPICS = 2000

_Rate = Annotated[float, Meta(ge=0, le=100_000)]
_Rates = Annotated[dict[Name, _Rate], Meta(max_length=MAX_TOPICS)]
_Types = Annotated[list[Name], Meta(max_length=MAX_TOPICS)]


class TapSubscription(Message, frozen=True, kw_only=True, tag="tap_subscription"):
    """The topics that anyone at the hub takes now; of all others nothing is heard or sent.

    Attributes:
        topics: absolute names, each with the most messages a second that are wanted (Hz); 0: all.
        types: message types whose `TapSchema` the hub wants, whether or not they are heard.
        graph: the hub wants to know the robot's nodes (`RobotGraph`).

    """

    topics: _Rates = {}
    types: _Types = []
    graph: bool = False


class TopicEntry(Message, frozen=True, kw_only=True, tag="topic"):
    """One topic that the robot publishes.

    Attributes:
        number: stands for topic and type in `TapMessage`, in this run of the gateway.
        topic: its absolute name.
        type: as the robot's protocol names it, ``package/msg/Name``.
        latched: who comes later gets its last messages, too (transient local).
        why: why it cannot be tapped; empty: it can.

    """

    number: Count
    topic: Name
    type: Name
    latched: bool = False
    why: Sentence = ""


class TopicList(Message, frozen=True, kw_only=True, tag="topic_list"):
    """All topics that the robot publishes now. Sent on every change, to a hub that takes it.

    Attributes:
        left_out: so many more are there that have no room in the list.

    """

    topics: Annotated[list[TopicEntry], Meta(max_length=MAX_TOPICS)] = []
    left_out: Count = 0


class TapSchema(Message, frozen=True, kw_only=True, tag="tap_schema"):
    """How the messages of a type are read.

    Attributes:
        type: see `TopicEntry.type`.
        encoding: of the definition: ``ros2msg``, ``ros2idl`` or ``ros1msg``, as MCAP names them.
        definition: the type's own text and those of the types in it; empty where it is not known.
        message_encoding: of the messages: ``cdr`` or ``ros1``.
        problem: why there is no definition.

    """

    type: Name
    encoding: Word = ""
    definition: Annotated[str, Meta(max_length=512 * 1024)] = ""
    message_encoding: Word = ""
    problem: Sentence = ""


class TapMessage(Message, frozen=True, kw_only=True, tag="tap"):
    """A message of a topic as the robot serialized it, or a piece of one.

    Pieces of one topic come in order, and none of its next message between them.

    Attributes:
        number: of its `TopicEntry`.
        seq: counts the topic's messages, with those that were left out on the way.
        log_us: when it came to the gateway (UTC).
        publish_us: when it was published, by its publisher (UTC); 0 where nobody says.
        kept: it is of a topic that is latched or comes seldom: it is left out nowhere.
        size: bytes of the whole message.
        at: where in it this piece begins.
        data: the piece.

    """

    number: Count
    seq: Count = 0
    log_us: Micros = 0
    publish_us: Micros = 0
    kept: bool = False
    size: Annotated[int, Meta(ge=0, le=MAX_TAPPED)]
    at: Annotated[int, Meta(ge=0, le=MAX_TAPPED)] = 0
    data: Annotated[bytes, Meta(max_length=PIECE)]


class TapError(Message, frozen=True, kw_only=True, tag="tap_error"):
    """Why messages of a topic are missing; told once for each reason.

    Attributes:
        topic: its absolute name.
        why: in words for people.

    """

    topic: Name
    why: Sentence
