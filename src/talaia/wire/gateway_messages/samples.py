"""Samples on their way to the hub: batches, the newest of each, gaps, acknowledgements, wishes."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.columns import MAX_SAMPLES
from talaia.wire.gateway_messages.field_types import (
    ChannelColumn,
    Count,
    Micros,
    Millis,
    Name,
    OffsetColumn,
    Sentence,
    Texts,
    ValueColumn,
)
from talaia.wire.message import Message

__all__ = ["Ack", "NewestBatch", "ResendRequest", "SampleBatch", "SampleGap", "SignalSubscription"]


class SampleBatch(Message, frozen=True, kw_only=True, tag="samples"):
    """A batch of samples; see `wire.columns`. Sample i has the sequence number ``first + i``.

    ``addresses`` is set when the batch was indexed by another channel list than the hello's
    (kept on disk since before the description changed).
    """

    boot: Name
    first: Count
    catalogue: Name
    base_us: Micros
    channel: ChannelColumn
    offset: OffsetColumn
    value: ValueColumn
    texts: Texts = {}
    addresses: Annotated[list[Name], Meta(max_length=MAX_SAMPLES)] = []
    # False for what was kept on disk and is sent later: it is stored, and is no news.
    live: bool = True


class NewestBatch(Message, frozen=True, kw_only=True, tag="newest"):
    """The newest sample of channels, whatever its age; see `wire.newest`.

    Told when a link comes up, before anything old, and when live samples were dropped: what was
    said while nobody heard it, with silence after it, is what counts now. Each is one of the run's
    samples, with its own number, and comes with the old ones once more.
    Only to hubs that take ``newest`` (see `Welcome`).

    Attributes:
        sequence: numbers in the run, rising (i64).
        time_us: times (i64).
        age_ms: how long ago each was heard (f64), by the gateway's clock.
        addresses: as in `SampleBatch`.

    """

    boot: Name
    catalogue: Name
    channel: ChannelColumn
    sequence: ValueColumn
    time_us: ValueColumn
    value: ValueColumn
    age_ms: ValueColumn
    texts: Texts = {}
    addresses: Annotated[list[Name], Meta(max_length=MAX_SAMPLES)] = []


class SampleGap(Message, frozen=True, kw_only=True, tag="gap"):
    """Samples ``first`` to ``last`` of a boot are lost, with the reason and the time they span."""

    boot: Name
    first: Count
    last: Count
    from_us: Micros
    to_us: Micros
    reason: Sentence


class Ack(Message, frozen=True, kw_only=True, tag="ack"):
    """Every sample of ``boot`` below sequence ``below`` is stored for good."""

    boot: Name
    below: Count


class ResendRequest(Message, frozen=True, kw_only=True, tag="again"):
    """Send samples ``first`` up to, not including, ``below`` of ``boot`` once more.

    The hub had no room for them (its database was away), so they are not stored; live samples go
    on meanwhile, and so do STOP and driving.
    """

    boot: Name
    first: Count
    below: Count


class SignalSubscription(Message, frozen=True, kw_only=True, tag="signal_subscription"):
    """The channels that somebody looks at now: their samples are wanted soon. Told on each change.

    All others are sent as ever, and so are these by a gateway that does not know this message. It
    holds for one link.

    Attributes:
        catalogue: names the channel list that they are places in (see `Hello`).
        channels: the places (u16, little-endian); none: nobody looks at anything.
        every_ms: who wants them most often wants them so often; 0: each as it comes.

    """

    catalogue: Name
    channels: ChannelColumn = b""
    every_ms: Millis = 0
