"""Messages of the socket on which a page follows one raw topic, both ways."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import Count, Micros, Millis, Sentence, Word
from talaia.wire.message import Message

__all__ = ["MAX_RAW", "MAX_TREE", "TopicBytes", "TopicMessage", "TopicShown", "TopicUpdate"]

# Characters of a message as a tree.
MAX_TREE = 1024 * 1024
# Bytes of a message as the robot serialized it.
MAX_RAW = 7 * MAX_TREE

_Rate = Annotated[float, Meta(ge=0, le=100_000)]


class TopicUpdate(Message, frozen=True, kw_only=True, tag="topic_update"):
    """What is known of the topic: at the beginning, and whenever it changes.

    Attributes:
        listed: the robot publishes it, or did when its gateway was there last.
        type: of its messages, ``package/msg/Name``; empty while nobody publishes it.
        latched: who comes later gets its last messages, too; they do not grow stale.
        max_rate: at most so many messages a second come, by the description (Hz); 0: all.
        definition: how its messages are read; cut after 64 KiB, empty before it is known.
        problem: why it cannot be had now.

    """

    listed: bool = False
    type: Word = ""
    latched: bool = False
    max_rate: _Rate = 0.0
    definition: Annotated[str, Meta(max_length=64 * 1024)] = ""
    problem: Sentence = ""


class TopicMessage(Message, frozen=True, kw_only=True, tag="topic_message"):
    """A message of the topic, as a tree.

    Attributes:
        number: for `TopicShown`.
        seq: counts the topic's messages at the gateway, with those that were left out: with
            ``time_us`` it tells how often the topic comes.
        time_us: when it came to the gateway (UTC).
        publish_us: when it was published, by its publisher (UTC); 0 where nobody says.
        age_ms: how long the hub has had it.
        size: bytes of it as the robot serialized it.
        tree: it as JSON, by field names. Long arrays are ``{"$first": [...], "$of": length}``, long
            texts ``{"$text": "...", "$of": bytes}``, numbers that JSON has not
            ``{"$number": "NaN"}``.

    """

    number: Count
    seq: Count = 0
    time_us: Micros = 0
    publish_us: Micros = 0
    age_ms: Millis = 0
    size: Count = 0
    tree: Annotated[str, Meta(max_length=MAX_TREE)]


class TopicBytes(Message, frozen=True, kw_only=True, tag="topic_bytes"):
    """A message of the topic as the robot serialized it: for a page that asked ``as=bytes``.

    Attributes:
        number: for `TopicShown`.
        seq: see `TopicMessage`, as are ``time_us``, ``publish_us`` and ``age_ms``.
        time_us: see above.
        publish_us: see above.
        age_ms: see above.
        encoding: ``cdr`` (with its encapsulation's header) or ``ros1``.
        every: of a point cloud with more points than the page wanted, each so-manieth is left;
            else 1.
        data: the bytes.

    """

    number: Count
    seq: Count = 0
    time_us: Micros = 0
    publish_us: Micros = 0
    age_ms: Millis = 0
    encoding: Word = ""
    every: Count = 1
    data: Annotated[bytes, Meta(max_length=MAX_RAW)]


class TopicShown(Message, frozen=True, kw_only=True, tag="topic_shown"):
    """The page has message ``number``; a few may be under way, the next waits for this."""

    number: Count
