"""A reading of each channel every few seconds as a plain row, for people with an SQL client.

The views show these rows after the rollups, which come with the blocks: of a slow channel, hours
later. Rows that rollups stand for by now are deleted; those of texts and of channels so slow that
they have no rollups stay.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from sqlalchemy import and_, delete, func, or_, select

from talaia.hub.history.blocks.rows import to_cells
from talaia.hub.history.writing.bulk_writes import put_rows
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from talaia.hub.history.writing.chunks import Chunk

__all__ = ["Recent"]

# So many times rows are written, they are tidied once.
_TIDY = 150
_AT_ONCE = 50
# Numbers that are written again in one turn, and samples that wait for one at most.
_MOST_AGAIN = 1_000
_MOST_WAITING = 65_536
_table = tables.recent
_rollup = tables.rollup


class Recent:
    """Chooses the rows; for the writing thread only.

    A text, and the first reading of a channel, are written at the next turn. Of numbers it is so
    many a turn, those that were written longest ago first: with ten thousand channels a row for
    each and turn would cost more than storing all of their samples.
    """

    def __init__(self) -> None:
        """Start without knowing what is there."""
        # Batches since the last turn, and how many samples they hold.
        self._batches: list[Chunk] = []
        self._samples = 0
        # By channel id: its newest reading, and the time of the one that was written last.
        self._time_us = np.zeros(0, np.int64)
        self._value = np.zeros(0, np.float64)
        self._written_us = np.zeros(0, np.int64)
        # By channel id: it has a reading that was not written, and the turn of the last that was.
        self._pending = np.zeros(0, np.bool_)
        self._turn = np.zeros(0, np.int64)
        # By channel, its newest reading if that is a text, and the text that was written last: of
        # a channel that says nothing new, no row is written.
        self._texts: dict[int, str] = {}
        self._written_texts: dict[int, str] = {}
        # Times that rows were chosen.
        self._turns = 0
        # Times that something was written; each so many, what is over is deleted.
        self._writes = 0

    def add_chunks(self, chunks: list[Chunk]) -> None:
        """Take batches that have been committed, in order of their rows."""
        self._batches += chunks
        self._samples += sum(chunk.time_us.size for chunk in chunks)
        if self._samples >= _MOST_WAITING:
            self._sum_up()

    def newest_rows(self) -> list[dict[str, Any]]:
        """Give the newest reading of channels that have a new one; a text, if it changed."""
        self._sum_up()
        self._turns += 1
        for channel, text in self._texts.items():
            if self._written_texts.get(channel) == text:
                self._pending[channel] = False
        pending = np.flatnonzero(self._pending)
        first = pending[self._turn[pending] == 0]
        again = pending[self._turn[pending] > 0]
        if again.size > _MOST_AGAIN:
            again = again[np.argsort(self._turn[again], kind="stable")[:_MOST_AGAIN]]
        texts = [channel for channel in self._texts if self._pending[channel]]
        chosen = np.unique(np.concatenate([first, again, np.array(texts, np.int64)]))
        self._pending[chosen] = False
        self._turn[chosen] = self._turns
        self._written_us[chosen] = self._time_us[chosen]
        channels = chosen.tolist()
        words = self._write_texts(channels)
        times, values = self._time_us[chosen].tolist(), to_cells(self._value[chosen])
        return [
            {"time_us": time_us, "channel_id": channel, "value": value, "text": words.get(channel)}
            for time_us, channel, value in zip(times, channels, values, strict=True)
        ]

    def _write_texts(self, channels: list[int]) -> dict[int, str]:
        """Give the texts of channels that are written now, as a database keeps them."""
        # Most hubs have few channels that say words, or none.
        if not self._texts and not self._written_texts:
            return {}
        words = {}
        for channel in channels:
            text = self._texts.get(channel, "")
            if text:
                self._written_texts[channel] = text
                words[channel] = text.replace("\0", "�")
            else:
                self._written_texts.pop(channel, None)
        return words

    def forget_channels(self, channels: list[int]) -> None:
        """Write no more readings of channels that are gone."""
        self._sum_up()
        known = [channel for channel in channels if channel < self._pending.size]
        self._pending[known] = False
        self._turn[known] = 0
        for channel in known:
            self._texts.pop(channel, None)
            self._written_texts.pop(channel, None)

    def _sum_up(self) -> None:
        """Keep of the batches what is newest of each channel."""
        batches, self._batches, self._samples = self._batches, [], 0
        if not batches:
            return
        ids = np.concatenate([chunk.channel for chunk in batches])
        if not ids.size:
            return
        self._make_room(int(ids.max()) + 1)
        last = np.full(self._time_us.size, -1, np.int64)
        # Of equal indexes the last one counts: NumPy assigns in order.
        last[ids] = np.arange(ids.size)
        channels = np.flatnonzero(last >= 0)
        positions = last[channels]
        self._time_us[channels] = np.concatenate([chunk.time_us for chunk in batches])[positions]
        self._value[channels] = np.concatenate([chunk.value for chunk in batches])[positions]
        new = (self._turn[channels] == 0) | (self._time_us[channels] != self._written_us[channels])
        self._pending[channels] |= new
        for channel in [channel for channel in self._texts if last[channel] >= 0]:
            del self._texts[channel]
        start = 0
        for chunk in batches:
            for position, text in chunk.texts.items():
                channel = int(chunk.channel[position])
                if last[channel] == start + position:
                    self._texts[channel] = text
            start += chunk.channel.size

    def _make_room(self, size: int) -> None:
        more = size - self._time_us.size
        if more <= 0:
            return
        # Twice as much at once: ids come one after the other.
        more = max(more, self._time_us.size)
        self._time_us = np.pad(self._time_us, (0, more))
        self._value = np.pad(self._value, (0, more))
        self._written_us = np.pad(self._written_us, (0, more))
        self._pending = np.pad(self._pending, (0, more))
        self._turn = np.pad(self._turn, (0, more))

    def write_rows(self, connection: Connection, rows: list[dict[str, Any]]) -> None:
        """Write rows, in place of those that are there, and tidy from time to time."""
        put_rows(connection, _table, rows)
        self._writes += 1
        if self._writes % _TIDY == 0:
            self.delete_old(connection)

    def delete_old(self, connection: Connection) -> None:
        """Delete rows of which the views show rollups instead."""
        finest = (
            select(_rollup.c.channel_id, func.min(_rollup.c.width_us).label("width_us"))
            .where(_rollup.c.channel_id.in_(np.flatnonzero(self._turn).tolist()))
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
