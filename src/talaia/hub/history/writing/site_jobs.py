"""A site that comes from another server, or has gone to one: what is written and deleted.

Blocks come as they are, with numbers of this server in the place of those that they had. How far
each channel has come is written in the same transaction, so that nothing comes twice.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import delete, select, update

from talaia.hub.history.writing.bulk_writes import insert_rows, put_rows
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from sqlalchemy import Connection

    from talaia.hub.history.writing.channel_ids import Names
    from talaia.hub.history.writing.chunks import Chunk
    from talaia.hub.history.writing.open_blocks import Tails
    from talaia.hub.history.writing.writer_jobs import Adopt, Forget

__all__ = ["Adopted", "Forgotten", "adopt_blocks", "count_outside", "forget_site"]

_AT_ONCE = 500


class Adopted(NamedTuple):
    """Rows that came, with the numbers that they have here.

    Attributes:
        longest_us: by channel, the length of its longest block, for those that have a longer one.

    """

    blocks: list[dict[str, Any]]
    bodies: list[dict[str, Any]]
    rollups: list[dict[str, Any]]
    recent: list[dict[str, Any]]
    copied: list[dict[str, Any]]
    longest_us: dict[int, int]

    def write_rows(self, connection: Connection) -> None:
        """Write all of it; the caller commits, and has written the channels."""
        insert_rows(connection, tables.block, self.blocks)
        insert_rows(connection, tables.body, self.bodies)
        put_rows(connection, tables.rollup, self.rollups)
        put_rows(connection, tables.recent, self.recent)
        put_rows(connection, tables.copied, self.copied)
        channel = tables.channel
        for number, longest_us in self.longest_us.items():
            connection.execute(
                update(channel).where(channel.c.id == number).values(longest_us=longest_us)
            )

    @property
    def channels(self) -> set[int]:
        """The channels that have more blocks now."""
        return {row["channel_id"] for row in self.blocks}


class Forgotten(NamedTuple):
    """A site whose rows go: numbers of its channels and boots."""

    site: str
    channels: list[int]
    boots: list[int]

    def delete_rows(self, connection: Connection) -> None:
        """Delete what is left once blocks, rollups and readings are; the caller commits."""
        for first in range(0, len(self.boots), _AT_ONCE):
            boots = self.boots[first : first + _AT_ONCE]
            for table in (tables.hot, tables.stored_range, tables.gap):
                connection.execute(delete(table).where(table.c.boot_id.in_(boots)))
            connection.execute(delete(tables.boot).where(tables.boot.c.id.in_(boots)))
        for first in range(0, len(self.channels), _AT_ONCE):
            channels = self.channels[first : first + _AT_ONCE]
            tail = tables.tail
            connection.execute(delete(tail).where(tail.c.channel_id.in_(channels)))
            # A list names channels of one site alone.
            begins = [number.to_bytes(4, "little") for number in channels]
            _delete_lists(connection, begins)
            connection.execute(delete(tables.channel).where(tables.channel.c.id.in_(channels)))
        connection.execute(delete(tables.copied).where(tables.copied.c.site == self.site))


def adopt_blocks(job: Adopt, names: Names, first_block: int, now_us: int) -> Adopted:
    """Give rows of another server their numbers here; the first block gets ``first_block``.

    Raises:
        HistoryError: a name that no database would keep.

    """
    numbers = {
        channel.source: names.channel_number(job.site, channel.address, channel.since_us or now_us)
        for channel in job.channels
    }
    blocks, bodies = [], []
    longest_us: dict[int, int] = {}
    for number, (row, body) in enumerate(job.blocks, first_block):
        channel = numbers[row["channel_id"]]
        blocks.append({**row, "channel_id": channel, "id": number})
        bodies.append({"block_id": number, "body": body})
        length = row["last_us"] - row["first_us"]
        if length > longest_us.get(channel, names.longest_us[channel]):
            # Before the commit: a reader that looks back too far loses nothing.
            longest_us[channel] = names.longest_us[channel] = length
    copied = [
        {
            "site": job.site,
            "source_channel": channel.source,
            "address": channel.address,
            "move": job.move,
            "block_id": channel.block,
        }
        for channel in job.channels
    ]
    return Adopted(
        blocks,
        bodies,
        _renumber(job.rollups, numbers),
        _renumber(job.recent, numbers),
        copied,
        longest_us,
    )


def forget_site(job: Forget, names: Names) -> Forgotten:
    """Find what is to be deleted of a site."""
    channels = sorted(names.of_site(job.site))
    boots = [number for (site, _), number in names.boots.items() if site == job.site]
    return Forgotten(job.site, channels, boots)


def count_outside(tails: Tails, channels: set[int], coming: Sequence[Chunk]) -> int:
    """Count those of some channels that have samples in no block, or in the commit to come."""
    found = tails.all_tails().keys() | tails.waiting_channels()
    found |= {channel for chunk in coming for channel in chunk.channel.tolist()}
    return len(channels & found)


def _renumber(
    rows: Sequence[Mapping[str, Any]], numbers: Mapping[int, int]
) -> list[dict[str, Any]]:
    return [{**row, "channel_id": numbers[row["channel_id"]]} for row in rows]


def _delete_lists(connection: Connection, begins: Sequence[bytes]) -> None:
    """Delete the lists of channels that begin with one of these numbers."""
    table = tables.catalogue
    wanted = set(begins)
    gone = [
        row.id for row in connection.execute(select(table)) if bytes(row.channels)[:4] in wanted
    ]
    if gone:
        connection.execute(delete(table).where(table.c.id.in_(gone)))
