"""What the journal holds goes back into memory, after a crash or when another hub takes over.

A hub lets nobody in before, so it is done for thousands of rows at once: many gateways that send
one sample each leave a row for each of them.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - NamedTuple reads it at run time
from sqlalchemy import select

from talaia.hub.history.blocks.block import BlockSamples
from talaia.hub.history.blocks.journal import JournalSamples, read_rows
from talaia.hub.history.writing.chunks import Chunk
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from sqlalchemy import Connection

    from talaia.hub.history.blocks.journal_rows import JournalRows
    from talaia.hub.history.sensors.plain_rows import Recent
    from talaia.hub.history.writing.channel_ids import Catalogue
    from talaia.hub.history.writing.open_blocks import Tails
    from talaia.hub.history.writing.stored_runs import StoredRuns

__all__ = ["JournalReader", "JournalTargets", "replay_journal"]

_LOG = logging.getLogger(__name__)
_AT_ONCE = 4_096
# Samples that are dealt out to the channels at once: each time costs by the channel.
_DEALT = 1_048_576


class JournalTargets(NamedTuple):
    """Where what is read goes."""

    tails: Tails
    runs: StoredRuns
    recent: Recent
    journal: JournalRows


class _Rows(NamedTuple):
    """Rows of the journal as they stand in the table, column by column."""

    id: NDArray[np.int64]
    boot: Sequence[int]
    catalogue: NDArray[np.int64]
    first: Sequence[int]
    samples: Sequence[int]
    bodies: Sequence[bytes]


class JournalReader:
    """Reads samples of rows, with the numbers of their channels. Pure."""

    def __init__(self, catalogues: Mapping[int, Catalogue], saved_row: Mapping[int, int]) -> None:
        """Know each list of channels, and the row up to which a channel's samples are elsewhere."""
        size = max(catalogues, default=0) + 1
        # Of all lists one behind the other, by a list's number: where it begins, how long it is.
        self._begins = np.zeros(size, np.int64)
        self._lengths = np.zeros(size, np.int64)
        self._channels = np.concatenate(
            [np.zeros(0, np.int64), *(known.channels for known in catalogues.values())]
        )
        at = 0
        for number, known in catalogues.items():
            self._begins[number], self._lengths[number] = at, known.channels.size
            at += known.channels.size
        most = max((*saved_row, *self._channels.tolist()), default=0)
        self._saved = np.zeros(most + 1, np.int64)
        for channel, row in saved_row.items():
            self._saved[channel] = row

    def read_chunk(
        self, ids: NDArray[np.int64], catalogues: NDArray[np.int64], read: JournalSamples
    ) -> Chunk:
        """Give what of these rows is in no block and in no saved tail.

        Args:
            ids: the rows' numbers, rising; at least one.
            catalogues: by row, the number of its list of channels; of a damaged one any.
            read: their samples.

        Raises:
            IndexError: a row names a channel that is not in its list.

        """
        columns = read.columns
        of_list = np.repeat(catalogues, read.sizes)
        if bool((columns.channel >= self._lengths[of_list]).any()):
            raise IndexError("a row of the journal names a channel that its list does not have")
        channels = self._channels[self._begins[of_list] + columns.channel]
        wanted = self._saved[channels] < np.repeat(ids, read.sizes)
        chunk = Chunk(int(ids[0]), channels, columns.time_us, columns.value, columns.texts)
        return chunk if bool(wanted.all()) else _select_samples(chunk, np.flatnonzero(wanted))


def replay_journal(connection: Connection, reader: JournalReader, targets: JournalTargets) -> int:
    """Read all of the journal; give the number of its last row, 0 if it is empty."""
    tails, last, waiting = targets.tails, 0, 0
    for rows in _read_tables(connection):
        targets.runs.add_rows(rows.boot, rows.first, rows.samples)
        for row, samples in zip(rows.id.tolist(), rows.samples, strict=True):
            targets.journal.append_row(row, samples)
        read = read_rows(rows.bodies)
        for at, error in read.damaged.items():
            _LOG.error("%d samples of the journal are lost: %s", rows.samples[at], error)
        chunk = reader.read_chunk(rows.id, rows.catalogue, read)
        last = int(rows.id[-1])
        tails.add_chunks([chunk], last)
        targets.recent.add_chunks([chunk])
        waiting += chunk.time_us.size
        if waiting >= _DEALT:
            tails.deal_chunks()
            waiting = 0
    tails.deal_chunks()
    return last


def _read_tables(connection: Connection) -> Iterator[_Rows]:
    columns = tables.hot.c
    wanted = (columns.id, columns.boot_id, columns.catalogue_id)
    asked = select(*wanted, columns.first_seq, columns.samples, columns.body).order_by(columns.id)
    found = connection.execution_options(yield_per=_AT_ONCE).execute(asked)
    for part in found.partitions():
        ids, boots, catalogues, firsts, samples, bodies = zip(*part, strict=True)
        yield _Rows(
            np.array(ids, np.int64), boots, np.array(catalogues, np.int64), firsts, samples, bodies
        )


def _select_samples(chunk: Chunk, positions: NDArray[np.intp]) -> Chunk:
    samples = BlockSamples(chunk.time_us, chunk.value, chunk.texts)
    return Chunk(chunk.row, chunk.channel[positions], *samples.select_positions(positions))
