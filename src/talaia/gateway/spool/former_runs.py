"""The newest samples that former runs left in the spool. Reads files; changes nothing.

After the gateway was killed, what its former run heard last may be nowhere but here, behind hours
of older samples. So segments are read from the newest back, and only what is not known yet is
looked for.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.gateway.spool.packing import unpack_record
from talaia.gateway.spool.segment import RecordKind, read_records
from talaia.wire.columns import Columns, unpack_columns
from talaia.wire.errors import PeerError
from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch
from talaia.wire.newest import NewestSamples

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.gateway.spool.files import Segment
    from talaia.gateway.spool.segment import SampleRecord

__all__ = ["FormerNewest", "newest_in", "newest_of_segment"]

log = logging.getLogger(__name__)


class FormerNewest(NamedTuple):
    """The newest samples of one former run; channels are places in ``addresses``."""

    boot: str
    catalogue: str
    addresses: list[str]
    known: NewestSamples


class _Found(NamedTuple):
    sequence: int  # By it the order between channels is kept.
    time_us: int  # Wall time of the run that heard it.
    value: float
    # Text signals have NaN as their value; the text stands here.
    text: str


def newest_of_segment(segment: Segment, known: set[str], now_us: int) -> FormerNewest | None:
    """Give the newest samples of a segment's file (`newest_in`); none where it cannot be read."""
    try:
        data = segment.path.read_bytes()
    except OSError as error:
        log.debug("%s: %s", segment.path, error)
        return None
    return newest_in(
        data=data,
        boot=segment.head.boot,
        catalogue=segment.head.catalogue,
        addresses=segment.head.addresses,
        known=known,
        now_us=now_us,
    )


def newest_in(
    *, data: bytes, boot: str, catalogue: str, addresses: list[str], known: set[str], now_us: int
) -> FormerNewest | None:
    """Give the newest sample in a segment of each channel that is not ``known``; none of none.

    Args:
        data: the segment's bytes.
        boot: whose it is.
        catalogue: its channel list's name.
        addresses: its channel list.
        known: addresses that are not looked for; those that are found are added.
        now_us: the wall clock (UTC), for their age.

    """
    found: dict[str, _Found] = {}
    for record in _read_batches(data):
        frame = LINK_FROM_GATEWAY.decode(record.body)
        if not isinstance(frame, SampleBatch):
            continue
        columns = unpack_columns(frame)
        # Records that waited in memory over a change of the list name their channels themselves.
        named = frame.addresses or addresses
        # The first of the reversed column is the last.
        channels, at = np.unique(columns.channel[::-1], return_index=True)
        for channel, back in zip(channels.tolist(), at.tolist(), strict=True):
            place = len(columns) - 1 - back
            # Damage may point beyond the list; such a sample has no name.
            if channel < len(named) and named[channel] not in known:
                found[named[channel]] = _Found(
                    record.first + place,
                    int(columns.time_us[place]),
                    float(columns.value[place]),
                    columns.texts.get(place, ""),
                )
    # After the segment is read through: a later record of it overwrites an earlier one.
    known.update(found)
    return _as_told(boot, catalogue, found, now_us) if found else None


def _read_batches(data: bytes) -> Iterator[SampleRecord]:
    for _, record in read_records(data):
        if record.kind == RecordKind.SEGMENT:
            continue
        try:
            yield from unpack_record(record)
        # One record that cannot be read hides no other.
        except PeerError:
            # It is told as a gap when it is its turn to be sent.
            continue


def _as_told(boot: str, catalogue: str, found: dict[str, _Found], now_us: int) -> FormerNewest:
    rows = sorted(found.items(), key=lambda row: row[1].sequence)
    # Local numbers from 0, for a list that names only these channels.
    times = np.array([row.time_us for _, row in rows], np.int64)
    columns = Columns(
        np.arange(len(rows), dtype=np.uint16),
        times,
        np.array([row.value for _, row in rows], np.float64),
        {at: row.text for at, (_, row) in enumerate(rows) if row.text},
    )
    sequence = np.array([row.sequence for _, row in rows], np.int64)
    # Never negative: the clock may have been set back since.
    ages = np.maximum(0, now_us - times) / 1e3
    return FormerNewest(
        boot,
        catalogue,
        [address for address, _ in rows],
        NewestSamples(columns, sequence, ages),
    )
