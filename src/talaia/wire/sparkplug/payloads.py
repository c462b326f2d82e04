"""Payloads of Sparkplug B: metrics with a type, a time and an alias.

By ``sparkplug_b.proto`` of the Eclipse Sparkplug specification 3.0, in Protocol Buffers.
"""

from __future__ import annotations

import math
import struct
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

from talaia.wire.protobuf import (
    bytes_field,
    double_field,
    read_bytes,
    read_fields,
    read_text,
    read_whole,
    varint_field,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

__all__ = [
    "ReadMetric",
    "SparkplugMetric",
    "SparkplugPayload",
    "SparkplugType",
    "decode_sparkplug",
    "encode_sparkplug",
]

# Numbers of fields: of a payload, of a metric, of its properties, of one of these.
_TIME, _METRICS, _SEQ = 1, 2, 3
_NAME, _ALIAS, _METRIC_TIME, _TYPE, _NULL, _PROPERTIES = 1, 2, 3, 4, 7, 9
_INT, _LONG, _FLOAT, _DOUBLE, _BOOLEAN, _STRING = 10, 11, 12, 13, 14, 15
_KEYS, _VALUES = 1, 2
_PROPERTY_TYPE, _PROPERTY_INT, _PROPERTY_STRING = 1, 3, 8
_INT_32 = 3


class SparkplugType(IntEnum):
    """What a metric's value is."""

    INT_64 = 4
    DOUBLE = 10
    BOOLEAN = 11
    STRING = 12


class SparkplugMetric(NamedTuple):
    """A metric to send.

    Attributes:
        value: None, or a number that is none: the metric is null.
        kind: of the value.
        time_ms: of the value (ms since the epoch).
        name: in births; later the alias stands for it.
        alias: unique in the whole edge node; None: it has none.
        unit: the property ``engUnit``; empty: none.
        quality: the property ``Quality``: 192 good, 500 stale, 0 bad; None: none.

    """

    value: float | str | None
    kind: SparkplugType
    time_ms: int
    name: str = ""
    alias: int | None = None
    unit: str = ""
    quality: int | None = None


class ReadMetric(NamedTuple):
    """A metric that came; what it does not say is empty, or None."""

    name: str
    alias: int | None
    time_ms: int | None
    value: float | str | None


class SparkplugPayload(NamedTuple):
    """A payload that came."""

    time_ms: int | None
    metrics: list[ReadMetric]


def encode_sparkplug(
    metrics: Iterable[SparkplugMetric], *, time_ms: int | None, seq: int | None
) -> bytes:
    """Write a payload; of deaths that are a last will, neither time nor number is known."""
    head = b"" if time_ms is None else varint_field(_TIME, time_ms)
    body = b"".join(bytes_field(_METRICS, _write_metric(metric)) for metric in metrics)
    return head + body + (b"" if seq is None else varint_field(_SEQ, seq))


def decode_sparkplug(data: bytes) -> SparkplugPayload:
    """Read a payload.

    Raises:
        PeerError: it is none.

    """
    time_ms, metrics = None, []
    for number, value in read_fields(data):
        if number == _TIME:
            time_ms = read_whole(value)
        elif number == _METRICS:
            metrics.append(_read_metric(read_bytes(value)))
    return SparkplugPayload(time_ms, metrics)


def _write_metric(metric: SparkplugMetric) -> bytes:
    return b"".join(_metric_fields(metric))


def _metric_fields(metric: SparkplugMetric) -> Iterator[bytes]:
    if metric.name:
        yield bytes_field(_NAME, metric.name)
    if metric.alias is not None:
        yield varint_field(_ALIAS, metric.alias)
    yield varint_field(_METRIC_TIME, metric.time_ms)
    yield varint_field(_TYPE, metric.kind)
    value = metric.value
    if isinstance(value, str):
        yield from (_write_properties(metric), bytes_field(_STRING, value))
    elif value is None or not math.isfinite(value):
        yield from (varint_field(_NULL, 1), _write_properties(metric))
    elif metric.kind is SparkplugType.DOUBLE:
        yield from (_write_properties(metric), double_field(_DOUBLE, value))
    else:
        field = _BOOLEAN if metric.kind is SparkplugType.BOOLEAN else _LONG
        yield from (_write_properties(metric), varint_field(field, int(value)))


def _write_properties(metric: SparkplugMetric) -> bytes:
    keys, values = b"", b""
    if metric.unit:
        keys += bytes_field(_KEYS, "engUnit")
        said = varint_field(_PROPERTY_TYPE, SparkplugType.STRING)
        values += bytes_field(_VALUES, said + bytes_field(_PROPERTY_STRING, metric.unit))
    if metric.quality is not None:
        keys += bytes_field(_KEYS, "Quality")
        said = varint_field(_PROPERTY_TYPE, _INT_32)
        values += bytes_field(_VALUES, said + varint_field(_PROPERTY_INT, metric.quality))
    return bytes_field(_PROPERTIES, keys + values) if keys else b""


def _read_metric(data: bytes) -> ReadMetric:
    name, alias, time_ms = "", None, None
    value: float | str | None = None
    for number, said in read_fields(data):
        match number:
            case 1:
                name = read_text(said)
            case 2:
                alias = read_whole(said)
            case 3:
                time_ms = read_whole(said)
            case _ if number in {_INT, _LONG, _BOOLEAN}:
                value = read_whole(said)
            case _ if number == _FLOAT:
                value = float(struct.unpack("<f", read_bytes(said).ljust(4, b"\0")[:4])[0])
            case _ if number == _DOUBLE:
                value = float(struct.unpack("<d", read_bytes(said).ljust(8, b"\0")[:8])[0])
            case _ if number == _STRING:
                value = read_text(said)
            case _:
                pass
    return ReadMetric(name, alias, time_ms, value)
