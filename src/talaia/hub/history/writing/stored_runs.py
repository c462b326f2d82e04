"""Which sequence numbers of each boot are stored or lost, and the rows that record them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import delete, select

from talaia.hub.history.blocks.ranges import Ranges
from talaia.hub.history.writing.bulk_writes import put_rows
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from sqlalchemy import Connection

__all__ = ["StoredRuns"]


class StoredRuns:
    """By boot; for the writing thread only."""

    def __init__(self) -> None:
        """Know none."""
        # By boot, where the ranges begin that stand in the database: those that were joined go.
        self._written: dict[int, set[int]] = {}
        # By boot, the numbers of all samples that are stored: what comes again is passed over.
        self._stored: dict[int, Ranges] = {}
        # The same with what is recorded as lost; a gateway need not send below the first hole.
        self._settled: dict[int, Ranges] = {}
        # Boots whose ranges are not in the database as they are here.
        self._changed: set[int] = set()

    def load_runs(self, connection: Connection) -> None:
        """Read what is recorded; rows of the journal come by `add_stored`."""
        for row in connection.execute(select(tables.stored_range)):
            self._written.setdefault(row.boot_id, set()).add(row.first_seq)
            self.stored_of(row.boot_id).add_range(row.first_seq, row.past_seq)
            self.settled_of(row.boot_id).add_range(row.first_seq, row.past_seq)
        for row in connection.execute(select(tables.gap)):
            self.settled_of(row.boot_id).add_range(row.first_seq, row.last_seq + 1)

    def stored_of(self, boot: int) -> Ranges:
        """Give what is stored of a boot."""
        return self._stored.setdefault(boot, Ranges())

    def settled_of(self, boot: int) -> Ranges:
        """Give what is stored of a boot or recorded as lost."""
        return self._settled.setdefault(boot, Ranges())

    def settled_below(self, boot: int) -> int:
        """Give the first number of a boot that is neither stored nor lost."""
        return self._settled.get(boot, Ranges()).contiguous_end()

    def add_stored(self, boot: int, first: int, past: int) -> None:
        """Count numbers as stored that a row of the journal, or a commit to come, has."""
        self.stored_of(boot).add_range(first, past)
        self.settled_of(boot).add_range(first, past)
        self._changed.add(boot)

    def add_rows(self, boots: Sequence[int], firsts: Sequence[int], samples: Sequence[int]) -> None:
        """Count as stored what these rows of the journal have, row by row."""
        # What follows on another of its boot goes with it: a gateway's rows, nearly always.
        ends: dict[int, tuple[int, int]] = {}
        for boot, first, count in zip(boots, firsts, samples, strict=True):
            begun, past = ends.get(boot, (first, first))
            if past != first:
                self.add_stored(boot, begun, past)
                begun = first
            ends[boot] = begun, first + count
        for boot, (begun, past) in ends.items():
            self.add_stored(boot, begun, past)

    def write_changed(self, connection: Connection) -> dict[int, set[int]]:
        """Write the ranges of changed boots; those that were joined with others go.

        Returns:
            By boot, where the ranges begin that stand in the database once this is committed.

        """
        rows, written = [], {}
        for boot in self._changed:
            ranges = list(self._stored[boot])
            written[boot] = {first for first, _ in ranges}
            _delete_ranges(connection, boot, self._written.get(boot, set()) - written[boot])
            rows += [
                {"boot_id": boot, "first_seq": first, "past_seq": past} for first, past in ranges
            ]
        put_rows(connection, tables.stored_range, rows)
        return written

    def mark_written(self, written: dict[int, set[int]]) -> None:
        """Remember what `write_changed` wrote, now that it is committed."""
        self._written.update(written)

    def clear_changed(self) -> None:
        """Forget which boots have changed: their ranges are in the database."""
        self._changed.clear()

    def forget_boots(self, boots: Iterable[int]) -> None:
        """Forget boots whose rows are deleted."""
        for boot in boots:
            for known in (self._written, self._stored, self._settled):
                known.pop(boot, None)
            self._changed.discard(boot)


def _delete_ranges(connection: Connection, boot: int, firsts: Iterable[int]) -> None:
    table = tables.stored_range
    for first in firsts:
        gone = (table.c.boot_id == boot, table.c.first_seq == first)
        connection.execute(delete(table).where(*gone))
