"""Numbers for sites' channels, boots and lists of channels, and the rows that record them."""

from __future__ import annotations

import logging
from itertools import repeat
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - NamedTuple reads it at run time
from sqlalchemy import select, update

from talaia.hub.history.errors import HistoryError
from talaia.hub.history.writing.bulk_writes import insert_rows, insert_values, put_rows
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from sqlalchemy import Connection, Table

__all__ = ["Catalogue", "Names", "write_counters"]

_LOG = logging.getLogger(__name__)
_LONGEST_NAME = 200
_CHANNEL = ("id", "site", "address", "since_us", "saved_row", "longest_us")
# Lists of channels change when a description does; a peer that sends a new one each time
# must not fill the memory.
_MOST_LISTS = 1_000


class Catalogue(NamedTuple):
    """A list of channels that a batch indexes; ``channels`` has the shape (n,)."""

    id: int
    channels: NDArray[np.int64]


class Names:
    """What has a number already, and what gets one with the next commit.

    Attributes:
        channels: (site, address) to channel id.
        saved_row: channel id to the journal row up to which its samples are elsewhere.
        longest_us: channel id to the length of its longest block.
        boots: (site, boot) to boot id.

    """

    def __init__(self) -> None:
        """Start with no names."""
        self.channels: dict[tuple[str, str], int] = {}
        self.saved_row: dict[int, int] = {}
        self.longest_us: dict[int, int] = {}
        self.boots: dict[tuple[str, str], int] = {}
        # Lists of channels by their bytes: the same list of another day gets the same number.
        self._catalogues: dict[bytes, Catalogue] = {}
        # The same lists by number, to read the journal.
        self._by_id: dict[int, Catalogue] = {}
        # What the last lists of addresses are called: they come with each batch.
        self._lists: dict[tuple[str, tuple[str, ...]], Catalogue] = {}
        # By site, the list that came last: to look up ten thousand names is to look at each.
        self._came_last: dict[str, tuple[tuple[str, ...], Catalogue]] = {}
        # Rows that the next commit writes, with their tables; those of channels are thousands.
        self._new: list[tuple[Table, dict[str, Any]]] = []
        self._new_channels: list[tuple[int, str, str, int, int, int]] = []
        # By kind, the number that the next one gets. A number that was given once is never given
        # again, though its row be deleted: blocks, batches and views name each other by numbers.
        self._next: dict[str, int] = {}
        # New addresses that the next commit writes, by channel id.
        self._renamed: dict[int, str] = {}

    def load_names(self, connection: Connection) -> None:
        """Read all names from the database."""
        for row in connection.execute(select(tables.counter)):
            self._next[row.name] = row.next_number
        table = tables.channel
        for row in connection.execute(select(table)):
            self._count_up("channel", row.id)
            self.channels[row.site, row.address] = row.id
            self.saved_row[row.id] = row.saved_row
            self.longest_us[row.id] = row.longest_us
        for row in connection.execute(select(tables.boot)):
            self._count_up("boot", row.id)
            self.boots[row.site, row.boot] = row.id
        for row in connection.execute(select(tables.catalogue)):
            self._count_up("catalogue", row.id)
            self._add_catalogue(
                Catalogue(row.id, np.frombuffer(row.channels, "<u4").astype(np.int64))
            )

    def next_of(self, kind: str) -> int:
        """Give the number that the next one of a kind gets, as far as it is known here."""
        return self._next.get(kind, 1)

    def boot_id(self, site: str, boot: str) -> int:
        """Give the number of a boot, a new one if need be.

        Raises:
            HistoryError: a name no database would keep.

        """
        known = self.boots.get((site, boot))
        if known is None:
            # Before it gets a number: nothing of a refused name is kept.
            _check_names(site, boot)
            known = self.boots[site, boot] = self._take_number("boot")
            self._new.append((tables.boot, {"id": known, "site": site, "boot": boot}))
        return known

    def channel_catalogue(self, site: str, addresses: Sequence[str], now_us: int) -> Catalogue:
        """Give the number of a list of channels, and a number for each of them.

        Raises:
            HistoryError: a name no database would keep.

        """
        last = self._came_last.get(site)
        if last is not None and last[0] is addresses:
            return last[1]
        # Of a tuple it is itself, which nobody can change later.
        names = tuple(addresses)
        known = self._lists.get((site, names))
        if known is None:
            known = self._find_catalogue(self._channel_ids(site, names, now_us))
            if len(self._lists) >= _MOST_LISTS:
                self._lists.clear()
            self._lists[site, names] = known
        self._came_last[site] = (names, known)
        return known

    def channel_number(self, site: str, address: str, since_us: int) -> int:
        """Give the number of a channel, a new one if need be.

        Raises:
            HistoryError: a name no database would keep.

        """
        return int(self._channel_ids(site, (address,), since_us)[0])

    def of_site(self, site: str) -> set[int]:
        """Give the numbers of a site's channels."""
        return {number for (owner, _), number in self.channels.items() if owner == site}

    def forget_site(self, site: str) -> None:
        """Forget a site's channels and boots, whose rows are deleted."""
        for key in [key for key in self.channels if key[0] == site]:
            number = self.channels.pop(key)
            self.saved_row.pop(number, None)
            self.longest_us.pop(number, None)
        for key in [key for key in self.boots if key[0] == site]:
            del self.boots[key]
        self._forget_lists(site)

    @property
    def counters(self) -> dict[str, int]:
        """The number that comes next of each kind."""
        return {kind: self.next_of(kind) for kind in ("channel", "boot", "catalogue")}

    def rename_channels(self, site: str, moves: Mapping[str, str]) -> None:
        """Let channels have other addresses; one whose new address has a history stays."""
        for old, new in moves.items():
            _check_names(site, new)
            if (site, old) not in self.channels:
                continue
            if (site, new) in self.channels:
                _LOG.warning("%s: %s has a history already; %s keeps its own", site, new, old)
                continue
            channel = self.channels.pop((site, old))
            self.channels[site, new] = channel
            self._renamed[channel] = new
        # An address may stand for another channel now.
        self._forget_lists(site)

    def all_catalogues(self) -> Mapping[int, Catalogue]:
        """Give all lists by their numbers."""
        return self._by_id

    def write_new(self, connection: Connection) -> None:
        """Record what has got a number since the last commit."""
        insert_values(connection, tables.channel, _CHANNEL, self._new_channels)
        for table in (tables.boot, tables.catalogue):
            rows = [row for owner, row in self._new if owner is table]
            if rows:
                insert_rows(connection, table, rows)
        table = tables.channel
        for channel, address in self._renamed.items():
            same = table.c.id == channel
            connection.execute(update(table).where(same).values(address=address))

    def clear_new(self) -> None:
        """Forget what was new, now that it is committed."""
        self._new.clear()
        self._new_channels.clear()
        self._renamed.clear()

    def _forget_lists(self, site: str) -> None:
        self._lists = {key: channels for key, channels in self._lists.items() if key[0] != site}
        self._came_last.pop(site, None)

    def _channel_ids(self, site: str, addresses: Sequence[str], now_us: int) -> NDArray[np.int64]:
        known = self.channels
        keys = list(zip(repeat(site), addresses))
        new = [name for _, name in dict.fromkeys(key for key in keys if key not in known)]
        _check_names(site, *new)
        if new:
            # Together: a list of ten thousand names is what a hub has once, and waits for.
            first = self.next_of("channel")
            numbers = range(first, first + len(new))
            self._next["channel"] = numbers.stop
            known.update(zip(zip(repeat(site), new), numbers, strict=True))
            none = dict.fromkeys(numbers, 0)
            self.saved_row.update(none)
            self.longest_us.update(none)
            none_yet = repeat(0)
            self._new_channels += zip(
                numbers, repeat(site), new, repeat(now_us), none_yet, none_yet
            )
        return np.fromiter(map(known.__getitem__, keys), np.int64, len(keys))

    def _take_number(self, kind: str) -> int:
        number = self.next_of(kind)
        self._next[kind] = number + 1
        return number

    def _count_up(self, kind: str, number: int) -> None:
        if number >= self.next_of(kind):
            self._next[kind] = number + 1

    def _find_catalogue(self, channels: NDArray[np.int64]) -> Catalogue:
        # Little-endian on every machine: it is compared with what the database has.
        data = channels.astype("<u4").tobytes()
        known = self._catalogues.get(data)
        if known is None:
            known = Catalogue(self._take_number("catalogue"), channels)
            self._add_catalogue(known)
            self._new.append((tables.catalogue, {"id": known.id, "channels": data}))
        return known

    def _add_catalogue(self, catalogue: Catalogue) -> None:
        self._catalogues[catalogue.channels.astype("<u4").tobytes()] = catalogue
        self._by_id[catalogue.id] = catalogue


def write_counters(connection: Connection, counters: Mapping[str, int]) -> None:
    """Record which numbers come next, by kind: rows that had the last ones are deleted."""
    rows = [{"name": kind, "next_number": number} for kind, number in counters.items()]
    put_rows(connection, tables.counter, rows)


def _check_names(*names: str) -> None:
    together = "".join(names)
    sizes = [*map(len, names)]
    # All at once first: which of ten thousand it is matters only where one is wrong.
    if min(sizes) < 1 or max(sizes) > _LONGEST_NAME or "\0" in together or _have_spaces(names):
        for name in names:
            if not 0 < len(name) <= _LONGEST_NAME or "\0" in name or name != name.strip():
                raise HistoryError(
                    f"the name {name[:40]!r} cannot be kept",
                    f"use 1 to {_LONGEST_NAME} characters, no NUL and no space at either end",
                )
    try:
        together.encode()
    except UnicodeEncodeError as error:
        wrong = error.object[error.start : error.end]
        name = next((name for name in names if wrong in name), wrong)
        raise HistoryError(f"the name {name[:40]!r} is not Unicode text") from error


def _have_spaces(names: Sequence[str]) -> bool:
    """Tell whether one has a space at either end."""
    return [*map(str.strip, names)] != [*names]
