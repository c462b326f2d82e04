"""Old samples, behind the live ones and at a bounded rate."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.spool.journal import SpoolPosition
from talaia.wire.errors import PeerError
from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from talaia.gateway.spool.journal import StoredRecord
    from talaia.gateway.spool.spool_thread import SpoolThread
    from talaia.gateway.uplink.send_lanes import SendLanes

__all__ = ["CatchUp", "as_old"]

STEP_S = 0.05
MAX_WAITING = 8
# Bytes that may go out without any word of the hub that it stores.
MOST_UNHEARD = 8 * 1024 * 1024


def as_old(stored: StoredRecord, catalogue: str) -> bytes:
    """Turn a kept batch into the frame to send: no longer live, and able to stand alone.

    A batch of another channel list than the link's carries the addresses of its own; one that
    waited in memory while the list changed has them already.

    Raises:
        PeerError: the frame cannot be read.

    """
    frame = LINK_FROM_GATEWAY.decode(stored.record.body)
    if not isinstance(frame, SampleBatch):
        raise PeerError("the spool holds a frame that is no batch of samples")
    addresses = frame.addresses
    if not addresses and stored.head.catalogue != catalogue:
        addresses = stored.head.addresses
    return LINK_FROM_GATEWAY.encode(msgspec.structs.replace(frame, live=False, addresses=addresses))


class CatchUp:
    """Sends what the spool held when the link came up, then what was dropped or is asked again."""

    def __init__(
        self,
        *,
        spool: SpoolThread,
        lanes: SendLanes,
        boot: str,
        catalogue: Callable[[], str],
        rate: int,
        dropped: Callable[[], None] = lambda: None,
        most_unheard: int = MOST_UNHEARD,
    ) -> None:
        """Take what it needs.

        Args:
            spool: the spool.
            lanes: the way out.
            boot: names this run.
            catalogue: gives its channel list's name.
            rate: bytes a second.
            dropped: called when live samples were dropped: what they said last must be told anew.
            most_unheard: bytes that may go out without any word of the hub that it stores.

        """
        self._most_unheard = most_unheard
        self._dropped = dropped
        self._spool = spool
        self._lanes = lanes
        self._boot = boot
        self._catalogue = catalogue
        self._rate = rate

    async def run(self, live_from: int) -> None:
        """Catch up for as long as the link lasts.

        Args:
            live_from: samples of this boot from here on go out live.

        """
        told = await self._tell_gaps(0)
        await self._send(
            SpoolPosition(),
            lambda boot, first, _: boot != self._boot or first < live_from,
            until=(self._boot, live_from),
        )
        while True:
            await asyncio.sleep(1.0)
            owed, self._lanes.owed = self._lanes.owed, {}
            if self._lanes.overflowed is not None:
                (first, below), self._lanes.overflowed = self._lanes.overflowed, None
                self._dropped()
                before = owed.get(self._boot, (first, below))
                owed[self._boot] = (min(first, before[0]), max(below, before[1]))
            for boot, (first, below) in owed.items():
                await self._again(boot, first, below)
            told = await self._tell_gaps(told)

    async def _tell_gaps(self, told: int) -> int:
        """Tell all gaps when their number has changed; give their number."""
        gaps = await self._spool.list_gaps()
        if len(gaps) != told:
            for gap in gaps:
                self._lanes.backfill(LINK_FROM_GATEWAY.encode(gap))
        return len(gaps)

    async def _again(self, boot: str, first: int, below: int) -> None:
        """Send a range of one boot that did not arrive or was not kept."""

        def wanted(of: str, begin: int, end: int) -> bool:
            return of == boot and begin < below and end > first

        await self._send(await self._spool.seek_sample(boot, first), wanted, until=(boot, below))

    async def _send(
        self,
        place: SpoolPosition,
        wanted: Callable[[str, int, int], bool],
        until: tuple[str, int],
    ) -> None:
        """Send what is wanted from a place on, at the rate, until the end or past a sample."""
        step = max(1, round(self._rate * STEP_S))
        # Bytes since the hub last acknowledged anything: beyond a bound it is waited for.
        acks, unheard = self._lanes.acks, 0
        while True:
            found, place = await self._spool.read_records(place, step)
            if not found:
                return
            sent = 0
            for data in self._frames(found, wanted):
                self._lanes.backfill(data)
                sent += len(data)
                unheard = unheard + len(data) if acks == self._lanes.acks else len(data)
                acks = self._lanes.acks
                # What was packed may be many frames, which are not sent at one blow.
                if sent >= step:
                    await self._pace(sent, acks if unheard > self._most_unheard else None)
                    sent = 0
            # Even where nothing is wanted, the reading is not to take the machine for itself.
            sent = max(sent, step // 10)
            await self._pace(sent, acks if unheard > self._most_unheard else None)
            last = found[-1]
            if last.head.boot == until[0] and last.record.end >= until[1]:
                return

    async def _pace(self, sent: int, acks: int | None) -> None:
        """Wait as long as ``sent`` bytes take, for the lane, and for an answer beyond ``acks``."""
        await asyncio.sleep(sent / self._rate)
        # Asked from time to time: the writer has more urgent things to do than to tell us.
        while self._lanes.backfill_waiting > MAX_WAITING or (  # noqa: ASYNC110
            # A hub that stores nothing now has no room for old samples either.
            acks == self._lanes.acks
        ):
            await asyncio.sleep(STEP_S)

    def _frames(
        self, found: list[StoredRecord], wanted: Callable[[str, int, int], bool]
    ) -> Iterator[bytes]:
        for stored in found:
            boot, record = stored.head.boot, stored.record
            if wanted(boot, record.first, record.end):
                try:
                    yield as_old(stored, self._catalogue())
                except PeerError as error:
                    # Whole on disk, yet written by a version that said it differently.
                    self._spool.record_loss(record, str(error), boot)
