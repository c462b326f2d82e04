"""What every signal is, or was, and the views of sensors that are made behind a description."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING

from talaia.hub.history.errors import HistoryError
from talaia.hub.history.sensors.sensor_views import (
    kinds_of,
    read_kinds,
    read_table_names,
    remember_sensors,
    rename_sensors,
    show_sensors,
)
from talaia.hub.history.sensors.view_sql import sensors_of
from talaia.hub.store.dialects.choice import dialect_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from sqlalchemy import Engine

    from talaia.hub.history.database_threads import DatabaseThreads
    from talaia.hub.history.sensors.sensor_views import StoredSensorKind
    from talaia.hub.history.sensors.view_sql import SensorView
    from talaia.model.site import Site

__all__ = ["SensorRegistry"]

# Without a description for so long, views are made (s).
_QUIET_S = 0.2
_LOG = logging.getLogger(__name__)


class SensorRegistry:
    """Kinds in memory are those in the database: both change together, the database first."""

    def __init__(self, threads: DatabaseThreads, reading: Engine, writing: Engine) -> None:
        """Read and write in ``threads``; `load_sensors` comes first."""
        # What is asked here stands in the queue with charts.
        self._threads = threads
        # Read once, when the hub begins.
        self._reading = reading
        # The one connection that writes; the samples' commits use it in between.
        self._writing = writing
        # What each signal is, or was when it was last described, by site and address. Every page
        # asks for all of them, so they are not read from the database each time.
        self._kinds: dict[tuple[str, str], StoredSensorKind] = {}
        # No view has the name of a table; read once, too.
        self._table_names: frozenset[str] = frozenset()
        # That a file has no room for more views is said once, not for each site.
        self._is_full_told = False
        # Views that are being made; the event loop itself holds tasks only weakly.
        self._showing: set[asyncio.Task[None]] = set()
        # Sites take turns: the writing connection is one, and samples need it in between.
        self._one_site = asyncio.Lock()
        # Descriptions that are being written down: views wait for them, for they take the writing
        # connection a hundred times as long.
        self._describing = 0
        # How many there were, and when it was looked last whether there are more.
        self._described = self._seen = 0
        # Views that are not made yet wait for the next description.
        self._closing = False

    async def load_sensors(self) -> None:
        """Read what all signals of all times were.

        Raises:
            HistoryError: the database cannot be read.

        """
        self._kinds = await self._threads.run_query(read_kinds, self._reading)
        self._table_names = await self._threads.run_query(read_table_names, self._reading)

    def kind_of(self, site: str, address: str) -> StoredSensorKind | None:
        """Give what a channel's signal is, or was when it was last described; None: not known."""
        return self._kinds.get((site, address.partition(".")[0]))

    @contextlib.contextmanager
    def hold_views(self) -> Iterator[None]:
        """Begin with no further site's views meanwhile: somebody waits for a description."""
        self._describing += 1
        self._described += 1
        try:
            yield
        finally:
            self._describing -= 1

    async def describe_site(self, site: Site, channels: Mapping[tuple[str, str], int]) -> None:
        """Write down what a description's sensors are; their views are made behind it.

        Gateways that join do not wait for views, see `wait_for_views`. A database that refuses
        views (it takes a right of its own on a server) keeps the samples all the same; that is
        logged.

        Args:
            site: the description.
            channels: the numbers of all channels, by site and address.

        Raises:
            HistoryError: what they are is not stored.

        """
        sensors = sensors_of(site, channels)
        missing = await self._threads.run_query(
            remember_sensors, self._writing, site.site, sensors, self._table_names
        )
        for address, kind in kinds_of(sensors).items():
            self._kinds[site.site, address] = kind
        task = asyncio.create_task(self._show_sensors(site.site, missing))
        self._showing.add(task)
        task.add_done_callback(self._showing.discard)

    async def wait_for_views(self) -> None:
        """Wait until the views of all that was described so far are made, or cannot be made."""
        await asyncio.gather(*self._showing)

    async def rename_channels(self, site: str, moves: Mapping[str, str]) -> None:
        """Let signals go on under other addresses; ``moves``: new channels by former ones.

        Raises:
            HistoryError: nothing is renamed.

        """
        signals = {old.partition(".")[0]: new.partition(".")[0] for old, new in moves.items()}
        await self._threads.run_query(rename_sensors, self._writing, site, signals)
        for old, new in signals.items():
            if (kind := self._kinds.pop((site, old), None)) is not None:
                self._kinds.setdefault((site, new), kind)

    def forget_site(self, site: str) -> None:
        """Forget what a site's signals are, whose rows are deleted."""
        for key in [key for key in self._kinds if key[0] == site]:
            del self._kinds[key]

    async def _show_sensors(self, site: str, sensors: list[SensorView]) -> None:
        async with self._one_site:
            # Those that come one after the other leave a moment of quiet between them.
            while (self._describing or self._seen != self._described) and not self._closing:
                self._seen = self._described
                await asyncio.sleep(_QUIET_S)
            try:
                made = await self._threads.run_query(
                    show_sensors, self._writing, site, sensors, lambda: self._closing
                )
                if made < len(sensors) and not self._closing:
                    self._tell_full(site)
            except HistoryError as error:
                # Views need a right of their own on a server; samples are kept without them.
                _LOG.warning("the sensors of %s have no views for SQL: %s", site, error)

    def _tell_full(self, site: str) -> None:
        if dialect_of(self._writing).is_server:
            _LOG.warning("%s has many signals; of each further one there is no view for SQL", site)
        elif not self._is_full_told:
            self._is_full_told = True
            _LOG.warning(
                "%s has many signals, with the sites before it; of each further one there is no"
                " view for SQL in this file. A database server has them",
                site,
            )

    async def close(self) -> None:
        """Stop making views, and wait for those of the transaction that is under way."""
        self._closing = True
        await asyncio.gather(*self._showing, return_exceptions=True)
