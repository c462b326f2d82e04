"""Recorded messages as bytes: what is given as MessagePack."""

from __future__ import annotations

import msgspec

__all__ = ["BytesAnswer", "RecordedBytes"]


class RecordedBytes(msgspec.Struct, frozen=True, kw_only=True):
    """A message as the robot serialized it.

    Attributes:
        topic: its absolute name.
        time_us: when it came to the recorder (UTC).
        publish_us: when it was published (UTC).
        encoding: ``cdr`` (with its encapsulation's header) or ``ros1``.
        every: of a thinned point cloud each so-manieth point is left; else 1.
        data: the bytes.

    """

    topic: str
    time_us: int
    publish_us: int
    encoding: str
    every: int
    data: bytes


class BytesAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """As `StretchShape`, as MessagePack."""

    topics: list[dict[str, object]]
    messages: list[RecordedBytes]
    until_us: int
