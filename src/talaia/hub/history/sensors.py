"""Keeps the sensors' views in step with the site descriptions."""

from __future__ import annotations

import hashlib
import logging
from typing import TYPE_CHECKING

from sqlalchemy import delete, insert, inspect, select

from talaia.hub.history.views import CreateView, DropView, view_name
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from sqlalchemy import Connection, Engine

    from talaia.hub.history.views import Sensor

__all__ = ["show_sensors"]

_LOG = logging.getLogger(__name__)
# A view that is made otherwise than before is made anew.
_VERSION = "1"
_sensor = tables.sensor


def show_sensors(engine: Engine, site: str, sensors: list[Sensor]) -> int:
    """Make a view for each sensor that has none, or another than it should have.

    A sensor that is no longer described keeps its view, as it keeps its history.

    Returns:
        How many views were made.

    """
    with engine.connect() as connection:
        known = {
            row.address: (row.view_name, row.made_of)
            for row in connection.execute(select(_sensor).where(_sensor.c.site == site))
        }
        missing = [
            each for each in sensors if known.get(each.address, ("", ""))[1] != _made_of(each)
        ]
    if not missing:
        return 0
    with engine.begin() as connection:
        taken = set(inspect(connection).get_table_names())
        taken |= set(connection.scalars(select(_sensor.c.view_name)))
        for each in missing:
            name = known.get(each.address, ("", ""))[0]
            if not name:
                name = view_name(site, each.address, each.channels[0], frozenset(taken))
                taken.add(name)
            _show(connection, site, each, name)
    _LOG.info("%d sensors of %s have their views", len(missing), site)
    return len(missing)


def _show(connection: Connection, site: str, sensor: Sensor, name: str) -> None:
    connection.execute(DropView(name))
    connection.execute(CreateView(name, sensor))
    same = (_sensor.c.site == site, _sensor.c.address == sensor.address)
    connection.execute(delete(_sensor).where(*same))
    connection.execute(
        insert(_sensor),
        {
            "site": site,
            "address": sensor.address,
            "view_name": name,
            "shown_name": sensor.shown[:200],
            "unit": sensor.unit,
            "made_of": _made_of(sensor),
        },
    )


def _made_of(sensor: Sensor) -> str:
    return hashlib.sha256(repr((_VERSION, *sensor)).encode()).hexdigest()[:32]
