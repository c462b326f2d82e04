"""Small rows of the journal that follow each other are made one, as if they had come as one batch.

With thousands of channels rows stay in the journal until each channel has a block's worth. SQLite
keeps whole rows in a page, of which a thousand samples fill two thirds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import delete

from talaia.hub.history.blocks.journal import MANY_CHANNELS, merge_bodies
from talaia.hub.history.writing.bulk_writes import put_rows
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Connection

__all__ = ["MergedRow", "RowMerger"]

# A row with more samples wastes little of its last page.
_SMALL = 8_192
# So many samples make a row that is worth writing them a second time.
_ENOUGH = 32_768


class MergedRow(NamedTuple):
    """A row in the place of several, under the number of their last one.

    Attributes:
        first: number of the first of them.

    """

    first: int
    row: dict[str, Any]

    def write_row(self, connection: Connection) -> None:
        """Put it in their place; the caller commits."""
        hot = tables.hot
        gone = (hot.c.id >= self.first, hot.c.id < self.row["id"])
        connection.execute(delete(hot).where(*gone))
        put_rows(connection, hot, [self.row])


class RowMerger:
    """Gathers rows that can be one; for the writing thread only.

    Of a merged row it must not be that a channel has one half in a block and the other half not:
    after a crash a row is read as a whole, or not at all. Channels are made blocks up to where
    batches were dealt out, so no merged row reaches across such a place.
    """

    def __init__(self) -> None:
        """Have none."""
        # Rows that follow each other.
        self._run: list[dict[str, Any]] = []
        self._samples = 0
        # How often batches had been dealt out when the run began.
        self._deals = 0

    def add_rows(self, rows: Sequence[dict[str, Any]], deals: int) -> None:
        """Take rows that have been committed, after so many deals."""
        for row in rows:
            if deals != self._deals or not self._follows(row):
                self._forget_run()
            self._deals = deals
            if row["body"][0] == MANY_CHANNELS and row["samples"] < _SMALL:
                self._run.append(row)
                self._samples += row["samples"]

    def next_row(self, deals: int) -> MergedRow | None:
        """Give a row in the place of those that were gathered, if they are enough."""
        if deals != self._deals or self._samples < _ENOUGH:
            return None
        first, last = self._run[0], self._run[-1]
        made = {**first, "id": last["id"], "samples": self._samples}
        made["body"] = merge_bodies([row["body"] for row in self._run], self._samples)
        self._forget_run()
        return MergedRow(first["id"], made)

    def _follows(self, row: dict[str, Any]) -> bool:
        if not self._run:
            return True
        last = self._run[-1]
        same = all(row[name] == last[name] for name in ("boot_id", "catalogue_id"))
        after = row["first_seq"] == last["first_seq"] + last["samples"]
        return same and after and bool(row["id"] == last["id"] + 1)

    def _forget_run(self) -> None:
        self._run, self._samples = [], 0
