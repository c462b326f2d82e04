"""Keeps what each sensor is, and its view, in step with the site descriptions."""

from __future__ import annotations

import hashlib
import json
import logging
import time
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import case, delete, func, insert, inspect, select, update

from talaia.hub.history.sensors.view_sql import DropView, view_name, view_statement
from talaia.hub.store import history_tables as tables
from talaia.hub.store.dialects.choice import dialect_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from sqlalchemy import Connection, Engine, Row

    from talaia.hub.history.sensors.view_sql import SensorView

__all__ = [
    "StoredSensorKind",
    "adopt_sensors",
    "drop_sensors",
    "kinds_of",
    "read_kinds",
    "read_sensors",
    "read_table_names",
    "remember_sensors",
    "rename_sensors",
    "show_sensors",
]

_LOG = logging.getLogger(__name__)
# A view that is made otherwise than before is made anew.
_VERSION = "1"
_sensor = tables.sensor
# A site's. Every view makes the database's own list of what it holds longer.
MOST_VIEWS = 1000
# Of all sites, in a file: each of its connections reads the list whole after each change of it, and
# keeps it. With 100 sites of 50 sensors a site took a second to join, and 5 MiB for ever.
MOST_IN_FILE = 250
# So many views are made, and so many sensors written down, in one transaction: others write in
# between.
_AT_ONCE = 50
_ROWS_AT_ONCE = 500
_BETWEEN_S = 0.02
_LONGEST_NAME = 200


class StoredSensorKind(NamedTuple):
    """What a signal was when it was last described.

    Attributes:
        type: a word of `SignalType`; empty if it was described by a version that kept none.
        decimals: as in the description.

    """

    name: str
    unit: str
    type: str
    states: tuple[str, ...]
    decimals: int


def kinds_of(sensors: list[SensorView]) -> dict[str, StoredSensorKind]:
    """Give what signals are, by their addresses."""
    return {
        sensor.address: StoredSensorKind(
            sensor.shown[:_LONGEST_NAME],
            sensor.unit,
            sensor.type.value,
            sensor.states,
            sensor.decimals,
        )
        for sensor in sensors
    }


def read_kinds(engine: Engine) -> dict[tuple[str, str], StoredSensorKind]:
    """Give what all signals of all times were, by site and address."""
    with engine.begin() as connection:
        rows = connection.execute(select(_sensor)).all()
    return {(row.site, row.address): _sensor_kind(row) for row in rows}


def read_table_names(engine: Engine) -> frozenset[str]:
    """Give the names that no view can have."""
    with engine.connect() as connection:
        return frozenset(inspect(connection).get_table_names())


def remember_sensors(
    engine: Engine, site: str, sensors: list[SensorView], table_names: frozenset[str]
) -> list[SensorView]:
    """Write down what each sensor is; one that is no longer described stays as it was.

    Args:
        engine: of the database.
        site: whose sensors they are.
        sensors: all that the site has.
        table_names: see `read_table_names`.

    Returns:
        Those that need a view made, or made anew.

    """
    with engine.begin() as connection:
        rows = connection.execute(select(_sensor).where(_sensor.c.site == site)).all()
    known = {row.address: row for row in rows}
    kinds = kinds_of(sensors)
    other = [
        sensor
        for sensor in sensors
        if sensor.address not in known
        or _sensor_kind(known[sensor.address]) != kinds[sensor.address]
    ]
    for first in range(0, len(other), _ROWS_AT_ONCE):
        with engine.begin() as connection:
            some = other[first : first + _ROWS_AT_ONCE]
            taken = _taken_names(connection, site, some) | table_names
            names = {}
            for sensor in some:
                name = known[sensor.address].view_name if sensor.address in known else ""
                if not name:
                    name = view_name(site, sensor.address, sensor.channels[0], taken)
                    taken |= {name}
                names[sensor.address] = name
            _remember(connection, site, some, names)
    return [
        sensor
        for sensor in sensors
        if sensor.address not in known or known[sensor.address].made_of != _made_of(sensor)
    ]


def rename_sensors(engine: Engine, site: str, moves: Mapping[str, str]) -> None:
    """Let sensors go on under other addresses; their views keep their names, for who asks them."""
    with engine.begin() as connection:
        known = set(connection.scalars(select(_sensor.c.address).where(_sensor.c.site == site)))
        for old, new in moves.items():
            if old in known and new not in known:
                connection.execute(
                    update(_sensor)
                    .where(_sensor.c.site == site, _sensor.c.address == old)
                    .values(address=new)
                )


def show_sensors(
    engine: Engine, site: str, sensors: list[SensorView], ended: Callable[[], bool] = lambda: False
) -> int:
    """Make the views of sensors that are remembered and need one.

    A sensor that is no longer described keeps its view, as it keeps its history. A site has at
    most `MOST_VIEWS` of them, and a file `MOST_IN_FILE`; ``ended`` is asked now and then.

    Returns:
        How many views were made.

    """
    if not sensors:
        return 0
    with engine.connect() as connection:
        rows = connection.execute(select(_sensor).where(_sensor.c.site == site)).all()
        names = {row.address: row.view_name for row in rows}
        anew = {row.address for row in rows if row.made_of} & {sensor.address for sensor in sensors}
        room = MOST_VIEWS - sum(bool(row.made_of) for row in rows)
        if not dialect_of(connection).is_server:
            held = select(func.count()).select_from(_sensor).where(_sensor.c.made_of != "")
            room = min(room, MOST_IN_FILE - (connection.scalar(held) or 0))
    # What has a view keeps one, however many there are of before.
    there_first = sorted(sensors, key=lambda sensor: sensor.address not in anew)
    wanted = there_first[: max(0, room) + len(anew)]
    for first in range(0, len(wanted), _AT_ONCE):
        if ended():
            return first
        if first:
            # There is one connection that writes; whoever waits for it gets it now.
            time.sleep(_BETWEEN_S)
        with engine.begin() as connection:
            some = wanted[first : first + _AT_ONCE]
            # Not all databases take a view back that was made before a crash.
            gone = [names[sensor.address] for sensor in some]
            together = len(gone) if dialect_of(connection).is_server else 1
            for at in range(0, len(gone), together):
                connection.execute(DropView(*gone[at : at + together]))
            statements = [
                view_statement(connection.dialect, names[sensor.address], sensor) for sensor in some
            ]
            dialect_of(connection).run_statements(connection, statements)
            made = {sensor.address: _made_of(sensor) for sensor in some}
            # One statement: a row each would be an answer to wait for each.
            connection.execute(
                update(_sensor)
                .where(_sensor.c.site == site, _sensor.c.address.in_(made))
                .values(made_of=case(made, value=_sensor.c.address))
            )
    if wanted:
        _LOG.info("%d sensors of %s have their views", len(wanted), site)
    return len(wanted)


def read_sensors(engine: Engine, site: str) -> list[dict[str, Any]]:
    """Give the rows of a site's sensors, those of former descriptions too."""
    with engine.begin() as connection:
        rows = connection.execute(select(_sensor).where(_sensor.c.site == site)).mappings()
        return [dict(row) for row in rows]


def adopt_sensors(engine: Engine, site: str, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write down what sensors of another server are, unless it is known; they have no views yet."""
    with engine.begin() as connection:
        known = set(connection.scalars(select(_sensor.c.address).where(_sensor.c.site == site)))
        taken = set(inspect(connection).get_table_names())
        taken |= set(connection.scalars(select(_sensor.c.view_name)))
        number = len(taken)
        for row in rows:
            if row["address"] in known:
                continue
            while (name := view_name(site, row["address"], number, taken)) in taken:
                number += 1
            taken.add(name)
            connection.execute(insert(_sensor), {**row, "view_name": name, "made_of": ""})


def drop_sensors(engine: Engine, site: str) -> int:
    """Drop the views of some of a site's sensors, and their rows; give how many."""
    with engine.begin() as connection:
        query = select(_sensor.c.address, _sensor.c.view_name).where(_sensor.c.site == site)
        rows = connection.execute(query.limit(_AT_ONCE)).all()
        there = set(inspect(connection).get_view_names()) if rows else set()
        for row in rows:
            if row.view_name in there:
                connection.execute(DropView(row.view_name))
            connection.execute(
                delete(_sensor).where(_sensor.c.site == site, _sensor.c.address == row.address)
            )
    return len(rows)


def _taken_names(
    connection: Connection, site: str, sensors: Sequence[SensorView]
) -> frozenset[str]:
    """Give those of the names that these could have which a sensor has."""
    wanted = set()
    for sensor in sensors:
        name = view_name(site, sensor.address, sensor.channels[0], ())
        wanted |= {name, view_name(site, sensor.address, sensor.channels[0], (name,))}
    found = select(_sensor.c.view_name).where(_sensor.c.view_name.in_(wanted))
    return frozenset(connection.scalars(found))


def _remember(
    connection: Connection, site: str, sensors: Sequence[SensorView], names: Mapping[str, str]
) -> None:
    connection.execute(delete(_sensor).where(_sensor.c.site == site, _sensor.c.address.in_(names)))
    rows = [
        {
            "site": site,
            "address": sensor.address,
            "view_name": names[sensor.address],
            "shown_name": sensor.shown[:_LONGEST_NAME],
            "unit": sensor.unit,
            "made_of": "",
            "type": sensor.type.value,
            "states": json.dumps(sensor.states),
            "decimals": sensor.decimals,
        }
        for sensor in sensors
    ]
    connection.execute(insert(_sensor), rows)


def _sensor_kind(row: Row[Any]) -> StoredSensorKind:
    return StoredSensorKind(
        row.shown_name,
        row.unit,
        row.type or "",
        tuple(json.loads(row.states or "[]")),
        -1 if row.decimals is None else row.decimals,
    )


def _made_of(sensor: SensorView) -> str:
    return hashlib.sha256(repr((_VERSION, *sensor)).encode()).hexdigest()[:32]
