"""A reading of each channel every few seconds as a plain row, for people with an SQL client.

The views show these rows after the rollups, which come with the blocks: of a slow channel, hours
later. Rows that rollups stand for by now are deleted; those of texts and of channels so slow that
they have no rollups stay.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sqlalchemy import and_, delete, func, or_, select

from talaia.hub.history.blocks.rows import to_cell
from talaia.hub.history.writing.bulk_writes import put_rows
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Mapping

    from sqlalchemy import Connection

    from talaia.hub.history.writing.open_blocks import Tail

__all__ = ["Recent"]

# So many times rows are written, they are tidied once.
_TIDY = 150
_AT_ONCE = 50
_table = tables.recent
_rollup = tables.rollup


class Recent:
    """Chooses the rows; for the writing thread only."""

    def __init__(self) -> None:
        """Start without knowing what is there."""
        # By channel, the time and the text of the last reading that was written. Of a channel that
        # says nothing new, no row is written.
        self._shown: dict[int, tuple[int, str]] = {}
        # Times that something was written; each so many, what is over is deleted.
        self._turns = 0

    def newest_rows(self, tails: Mapping[int, Tail]) -> list[dict[str, Any]]:
        """Give the newest reading of each channel that has a new one; a text, if it changed."""
        rows = []
        for channel, tail in tails.items():
            if not tail.parts or not tail.parts[-1].time_us.size:
                continue
            part = tail.parts[-1]
            at = part.time_us.size - 1
            time_us, text = int(part.time_us[at]), part.texts.get(at, "")
            before = self._shown.get(channel)
            if before is not None and (before[0] == time_us or (text and before[1] == text)):
                continue
            self._shown[channel] = (time_us, text)
            rows.append(
                {
                    "time_us": time_us,
                    "channel_id": channel,
                    "value": to_cell(float(part.value[at])),
                    "text": text.replace("\0", "�") or None,
                }
            )
        return rows

    def write_rows(self, connection: Connection, rows: list[dict[str, Any]]) -> None:
        """Write rows, in place of those that are there, and tidy from time to time."""
        put_rows(connection, _table, rows)
        self._turns += 1
        if self._turns % _TIDY == 0:
            self.delete_old(connection)

    def delete_old(self, connection: Connection) -> None:
        """Delete rows of which the views show rollups instead."""
        finest = (
            select(_rollup.c.channel_id, func.min(_rollup.c.width_us).label("width_us"))
            .where(_rollup.c.channel_id.in_(self._shown))
            .group_by(_rollup.c.channel_id)
        )
        over = []
        for channel, width_us in connection.execute(finest).all():
            newest = select(func.max(_rollup.c.bucket_us)).where(
                _rollup.c.channel_id == channel, _rollup.c.width_us == width_us
            )
            over.append((channel, connection.scalar(newest)))
        for at in range(0, len(over), _AT_ONCE):
            done = [
                and_(_table.c.channel_id == channel, _table.c.time_us < past_us)
                for channel, past_us in over[at : at + _AT_ONCE]
            ]
            connection.execute(delete(_table).where(or_(*done), _table.c.text.is_(None)))
