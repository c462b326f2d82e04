"""Old samples, behind the live ones and at a bounded rate."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.spool.journal import Place
from talaia.wire.errors import PeerError
from talaia.wire.frames import LINK_FROM_GATEWAY, Samples

if TYPE_CHECKING:
    from talaia.gateway.spool.journal import Stored
    from talaia.gateway.spool.keeper import Keeper
    from talaia.gateway.uplink.lanes import Lanes

__all__ = ["CatchUp", "as_old"]

STEP_S = 0.05
MAX_WAITING = 8


def as_old(stored: Stored, catalogue: str) -> bytes:
    """Turn a kept batch into the frame to send: no longer live, and able to stand alone.

    A batch of another channel list than the link's carries the addresses of its own.

    Raises:
        PeerError: the frame cannot be read.

    """
    frame = LINK_FROM_GATEWAY.decode(stored.record.body)
    if not isinstance(frame, Samples):
        raise PeerError("the spool holds a frame that is no batch of samples")
    addresses = [] if stored.head.catalogue == catalogue else stored.head.addresses
    return LINK_FROM_GATEWAY.encode(msgspec.structs.replace(frame, live=False, addresses=addresses))


class CatchUp:
    """Sends what the spool held when the link came up, then what the live lane had to drop."""

    def __init__(self, keeper: Keeper, lanes: Lanes, boot: str, catalogue: str, rate: int) -> None:
        """Take the spool, the lanes, this boot's and channel list's names, and bytes a second."""
        self._keeper = keeper
        self._lanes = lanes
        self._boot = boot
        self._catalogue = catalogue
        self._rate = rate

    async def run(self, live_from: int) -> None:
        """Catch up for as long as the link lasts.

        Args:
            live_from: samples of this boot from here on go out live.

        """
        for gap in await self._keeper.gaps():
            self._lanes.backfill(LINK_FROM_GATEWAY.encode(gap))
        told = len(await self._keeper.gaps())
        await self._range(0, live_from, old_boots=True)
        while True:
            await asyncio.sleep(1.0)
            if self._lanes.overflowed is not None:
                (first, end), self._lanes.overflowed = self._lanes.overflowed, None
                await self._range(first, end, old_boots=False)
            gaps = await self._keeper.gaps()
            if len(gaps) != told:
                told = len(gaps)
                for gap in gaps:
                    self._lanes.backfill(LINK_FROM_GATEWAY.encode(gap))

    async def _range(self, first: int, end: int, *, old_boots: bool) -> None:
        place = Place()
        step = max(1, round(self._rate * STEP_S))
        while True:
            found, place = await self._keeper.read(place, step)
            if not found:
                return
            sent = 0
            for stored in found:
                ours = stored.head.boot == self._boot
                if (ours and stored.record.end > first and stored.record.first < end) or (
                    not ours and old_boots
                ):
                    try:
                        data = as_old(stored, self._catalogue)
                    except PeerError as error:
                        # Whole on disk, yet written by a version that said it differently.
                        self._keeper.lose(stored.record, str(error), stored.head.boot)
                        continue
                    self._lanes.backfill(data)
                    sent += len(data)
            await asyncio.sleep(sent / self._rate)
            # Asked from time to time: the writer has more urgent things to do than to tell us.
            while self._lanes.backfill_waiting > MAX_WAITING:  # noqa: ASYNC110
                await asyncio.sleep(STEP_S)
            if found[-1].head.boot == self._boot and found[-1].record.first >= end:
                return
