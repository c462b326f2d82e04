"""Prometheus's remote read: what is asked, and series of samples as the answer.

By ``prompb/remote.proto`` and ``types.proto`` of Prometheus: messages of Protocol Buffers, which
travel as one block of Snappy. Answers are of the kind ``SAMPLES``, which every version reads.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.wire.errors import PeerError
from talaia.wire.protobuf import (
    bytes_field,
    encode_varint,
    read_bytes,
    read_fields,
    read_text,
    read_whole,
    signed_64,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import NDArray

__all__ = [
    "LabelMatcher",
    "MatchKind",
    "PastQuery",
    "PastSeries",
    "decode_read_request",
    "encode_read_response",
]

# Numbers of fields, by message.
_QUERIES, _RESULTS = 1, 1
_START_MS, _END_MS, _MATCHERS = 1, 2, 3
_KIND, _NAME, _VALUE = 1, 2, 3
_SERIES, _LABELS, _SAMPLES = 1, 1, 2
_MOST_QUERIES, _MOST_MATCHERS = 16, 100
# Times of which the varint has six bytes (ms): 1971 to 2109.
_FIRST_MS, _END_OF_SIX_MS = 2**35, 2**42
# A sample with such a time is as long as any other: a double, and the time.
_SAMPLE = np.dtype(
    [
        ("field", "u1"),
        ("size", "u1"),
        ("value_key", "u1"),
        ("value", "<f8"),
        ("time_key", "u1"),
        ("time", "u1", (6,)),
    ]
)


class MatchKind(IntEnum):
    """How a label is compared."""

    EQUAL = 0
    NOT_EQUAL = 1
    REGEX = 2
    NOT_REGEX = 3


class LabelMatcher(NamedTuple):
    """What a label has to be; one that a series lacks is the empty text."""

    kind: MatchKind
    name: str
    value: str


class PastQuery(NamedTuple):
    """Which series are asked for, and of which time (ms since the epoch, both ends included)."""

    start_ms: int
    end_ms: int
    matchers: tuple[LabelMatcher, ...]


class PastSeries(NamedTuple):
    """One series: its labels, and its samples in order of time (ms since the epoch)."""

    labels: Mapping[str, str]
    time_ms: NDArray[np.int64]
    value: NDArray[np.float64]


def decode_read_request(data: bytes) -> list[PastQuery]:
    """Read a request; hints and kinds of answers are passed over.

    Raises:
        PeerError: it is none, or asks for too much at once.

    """
    queries = [
        _read_query(read_bytes(value)) for number, value in read_fields(data) if number == _QUERIES
    ]
    if len(queries) > _MOST_QUERIES:
        raise PeerError(f"{len(queries)} queries in a request are over {_MOST_QUERIES}")
    return queries


def encode_read_response(results: Iterable[Iterable[PastSeries]]) -> bytes:
    """Write the series of each query, in the order of the queries."""
    written = (
        b"".join(bytes_field(_SERIES, _write_series(series)) for series in found)
        for found in results
    )
    return b"".join(bytes_field(_RESULTS, result) for result in written)


def _read_query(data: bytes) -> PastQuery:
    start_ms = end_ms = 0
    matchers: list[LabelMatcher] = []
    for number, value in read_fields(data):
        if number == _START_MS:
            start_ms = signed_64(read_whole(value))
        elif number == _END_MS:
            end_ms = signed_64(read_whole(value))
        elif number == _MATCHERS:
            matchers.append(_read_matcher(read_bytes(value)))
    if len(matchers) > _MOST_MATCHERS:
        raise PeerError(f"{len(matchers)} matchers in a query are over {_MOST_MATCHERS}")
    return PastQuery(start_ms, end_ms, tuple(matchers))


def _read_matcher(data: bytes) -> LabelMatcher:
    # What is not written is 0, or empty.
    kind, name, compared = 0, "", ""
    for number, value in read_fields(data):
        if number == _KIND:
            kind = read_whole(value)
        elif number == _NAME:
            name = read_text(value)
        elif number == _VALUE:
            compared = read_text(value)
    try:
        return LabelMatcher(MatchKind(kind), name, compared)
    except ValueError as error:
        raise PeerError(f"the matcher of {name[:100]!r} is of the unknown kind {kind}") from error


def _write_series(series: PastSeries) -> bytes:
    # By name: Prometheus merges series in that order.
    labels = b"".join(
        bytes_field(_LABELS, bytes_field(1, name) + bytes_field(2, value))
        for name, value in sorted(series.labels.items())
    )
    return labels + _write_samples(series)


def _write_samples(series: PastSeries) -> bytes:
    """Write all samples at once: one by one they would keep the hub busy for seconds."""
    usual = (series.time_ms >= _FIRST_MS) & (series.time_ms < _END_OF_SIX_MS)
    time_ms = series.time_ms[usual]
    written = np.empty(time_ms.size, _SAMPLE)
    written["field"] = _SAMPLES << 3 | 2
    written["size"] = _SAMPLE.itemsize - 2
    written["value_key"] = encode_varint(1 << 3 | 1)[0]
    written["value"] = series.value[usual]
    written["time_key"] = encode_varint(2 << 3)[0]
    shifted = time_ms[:, None] >> (7 * np.arange(6))
    written["time"] = shifted & 0x7F | np.array([0x80] * 5 + [0])
    return written.tobytes()
