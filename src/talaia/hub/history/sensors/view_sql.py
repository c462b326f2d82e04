"""For each sensor a view named after it: time and values, for people with an SQL client. Pure.

A view shows the finest rollup rows of its channels (``width_s`` is how many seconds each stands
for) and, after the last of them, single readings (``width_s`` 0) as `recent` writes them. Every
sample is in the compressed blocks, which SQL cannot look into; `talaia`'s export gives those.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import (
    Select,
    case,
    cast,
    func,
    literal,
    literal_column,
    null,
    select,
    types,
    union_all,
)
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.schema import ExecutableDDLElement
from sqlalchemy.sql.expression import ColumnElement

from talaia.hub.store import history_tables as tables
from talaia.hub.store.dialects.choice import find_dialect
from talaia.model.site import SignalType, parts_of

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from sqlalchemy import CompoundSelect
    from sqlalchemy.engine import Dialect
    from sqlalchemy.sql.compiler import SQLCompiler

    from talaia.model.site import Signal, Site

__all__ = ["DropView", "SensorView", "sensors_of", "view_name", "view_statement"]

# The shortest limit of the three databases is 63 bytes; the rest is for a number.
_LONGEST = 48
_recent, _rollup = tables.recent, tables.rollup
# What stands in the query of a kind of sensors for what each has of its own: numbers that no other
# part of a query has, and texts that no person's can be taken for, since only these are looked for.
_CHANNELS = tuple(str(7_000_000_000_000_000_001 + at) for at in range(16))
_SHOWN, _UNIT = "the sensor's own name\x1f", "the sensor's own unit\x1f"


class SensorView(NamedTuple):
    """A signal of a site, as its view shows it.

    Attributes:
        parts: the names of its value columns.
        channels: the id of each part's channel.

    """

    address: str
    shown: str
    unit: str
    type: SignalType
    states: tuple[str, ...]
    decimals: int
    parts: tuple[str, ...]
    channels: tuple[int, ...]


def sensors_of(site: Site, channels: Mapping[tuple[str, str], int]) -> list[SensorView]:
    """List a site's signals with the ids of their channels."""
    return [
        _sensor_view(site.site, f"{device_id}/{signal_id}", signal, channels)
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
    ]


def _sensor_view(
    site: str, address: str, signal: Signal, channels: Mapping[tuple[str, str], int]
) -> SensorView:
    parts = parts_of(signal)
    ids = tuple(channels[site, address + (f".{part}" if part else "")] for part in parts)
    names = tuple(part or "value" for part in parts)
    return SensorView(
        address, signal.name, signal.unit, signal.type, signal.states, signal.decimals, names, ids
    )


def view_name(site: str, address: str, channel: int, taken: Collection[str]) -> str:
    """Give a view's name: readable without quotes, of no table's beginning, not ``taken``."""
    word = re.sub(r"[^a-z0-9]+", "_", f"{site}_{address}".lower()).strip("_")
    name = f"sensor_{word[:_LONGEST].strip('_')}"
    if name in taken or len(word) > _LONGEST or not word:
        return f"{name.rstrip('_')}_{channel}"
    return name


def view_statement(dialect: Dialect, name: str, sensor: SensorView) -> str:
    """Give ``CREATE VIEW`` of a sensor, with the database's own quotes; for `exec_driver_sql`.

    Sensors of one kind have one query but for their channels and texts. Putting a query together
    takes longer than the database takes for the view, so each kind's is made once.
    """
    template = _compile_template(dialect, _template_of(sensor))
    # It knows backslashes and signs of percent, where they have a meaning to database or driver.
    compiler = dialect.statement_compiler(dialect, None)

    def quoted(text: str) -> str:
        return compiler.render_literal_value(text, types.String(200))

    fillings = dict(zip(_CHANNELS, map(str, sensor.channels), strict=False))
    fillings[quoted(_SHOWN)] = quoted(sensor.shown)
    fillings[quoted(_UNIT)] = quoted(sensor.unit)
    # In one pass: what is filled in is not looked at again, whatever a person has called it.
    parts = re.split(f"({'|'.join(map(re.escape, fillings))})", template)
    body = "".join(fillings.get(part, part) for part in parts)
    return f"CREATE VIEW {dialect.identifier_preparer.quote(name)} AS {body}"


def _template_of(sensor: SensorView) -> SensorView:
    channels = tuple(int(number) for number in _CHANNELS[: len(sensor.channels)])
    return sensor._replace(
        address="",
        shown=_SHOWN if sensor.shown else "",
        unit=_UNIT if sensor.unit else "",
        decimals=-1,
        channels=channels,
    )


@lru_cache(maxsize=256)
def _compile_template(dialect: Dialect, sensor: SensorView) -> str:
    query = _view_query(sensor)
    return str(query.compile(dialect=dialect, compile_kwargs={"literal_binds": True}))


class DropView(ExecutableDDLElement):
    """``DROP VIEW`` of those that are there; SQLite takes one at a time."""

    inherit_cache = False

    def __init__(self, *names: str) -> None:
        """Drop ``names``."""
        self.names = names


class _Time(ColumnElement[Any]):
    """A column of microseconds since the epoch as people read it."""

    inherit_cache = False
    type = types.NullType()

    def __init__(self, time_us: ColumnElement[int]) -> None:
        self.time_us = time_us


@compiles(DropView)
def _compile_drop(element: DropView, compiler: Any, **_: object) -> str:  # noqa: ANN401
    return f"DROP VIEW IF EXISTS {', '.join(map(compiler.preparer.quote, element.names))}"


@compiles(_Time)
def _compile_time(element: _Time, compiler: SQLCompiler, **kw: Any) -> str:  # noqa: ANN401
    dialect = find_dialect(compiler.dialect.name)
    if dialect is None:
        raise ValueError(f"no words for {compiler.dialect.name}")
    return dialect.time_of(compiler.process(element.time_us, **kw))


def _view_query(sensor: SensorView) -> Select[Any] | CompoundSelect[Any]:
    if sensor.type is SignalType.TEXT:
        return _select_readings(sensor)
    return union_all(_select_rollups(sensor), _select_readings(sensor))


def _select_readings(sensor: SensorView) -> Select[Any]:
    """Single readings that are newer than the rollups."""
    one = len(sensor.parts) == 1
    text = sensor.type is SignalType.TEXT
    value = _recent.c.text if text else _recent.c.value
    # The channels of a position have their samples at the same times.
    values = [
        value if one else func.max(case((_recent.c.channel_id == channel, value)))
        for channel in sensor.channels
    ]
    query = select(
        _Time(_recent.c.time_us).label("time"),
        *_name_columns(sensor, values),
        *([] if text else _spread_columns(sensor, values[0], values[0], literal_column("1"))),
        literal_column("0").label("width_s"),
    ).where(_recent.c.channel_id.in_(sensor.channels))
    if not text:
        first = sensor.channels[0]
        finest = _finest_width(first)
        newest = (
            select(func.max(_rollup.c.bucket_us) + finest)
            .where(_rollup.c.channel_id == first, _rollup.c.width_us == finest)
            .scalar_subquery()
        )
        query = query.where(_recent.c.time_us >= func.coalesce(newest, -(2**62)))
    return query if one else query.group_by(_recent.c.time_us)


def _select_rollups(sensor: SensorView) -> Select[Any]:
    """The finest rollup rows there are."""
    one = len(sensor.parts) == 1
    row = _rollup.c
    # What a position or a state was on average says nothing.
    if sensor.type is SignalType.NUMBER:
        value: ColumnElement[Any] = row.total / func.nullif(row.numbers, 0)
    else:
        value = row.last
    values = [
        value if one else func.max(case((row.channel_id == channel, value)))
        for channel in sensor.channels
    ]
    samples = row.samples if one else func.max(row.samples)
    query = select(
        _Time(row.bucket_us).label("time"),
        *_name_columns(sensor, values),
        *_spread_columns(sensor, row.low, row.high, samples),
        (row.width_us / literal_column("1000000")).label("width_s"),
    ).where(row.channel_id.in_(sensor.channels), row.width_us == _finest_width(sensor.channels[0]))
    return query if one else query.group_by(row.bucket_us, row.width_us)


def _finest_width(channel: int) -> ColumnElement[Any]:
    finer = _rollup.alias()
    return (
        select(func.min(finer.c.width_us))
        .where(finer.c.channel_id == channel)
        .correlate(None)
        .scalar_subquery()
    )


def _name_columns(
    sensor: SensorView, values: Sequence[ColumnElement[Any]]
) -> list[ColumnElement[Any]]:
    columns: list[ColumnElement[Any]] = [_text_literal(sensor.shown).label("sensor")]
    columns += [value.label(part) for part, value in zip(sensor.parts, values, strict=True)]
    if sensor.type is SignalType.STATE:
        words = [(values[0] == at, _text_literal(word)) for at, word in enumerate(sensor.states)]
        columns.append((case(*words) if words else null()).label("state"))
    if sensor.unit:
        columns.append(_text_literal(sensor.unit).label("unit"))
    return columns


def _spread_columns(
    sensor: SensorView,
    low: ColumnElement[Any],
    high: ColumnElement[Any],
    samples: ColumnElement[Any],
) -> list[ColumnElement[Any]]:
    if sensor.type is not SignalType.NUMBER:
        return [samples.label("samples")]
    return [low.label("minimum"), high.label("maximum"), samples.label("samples")]


def _text_literal(text: str) -> ColumnElement[Any]:
    # PostgreSQL calls a bare literal "unknown", and warns of it.
    return cast(literal(text), types.String(200)) if text else literal_column("''")
