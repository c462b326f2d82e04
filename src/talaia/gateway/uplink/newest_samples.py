"""Telling the hub the newest sample of each channel, before anything old."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from talaia.wire.frames import LINK_FROM_GATEWAY
from talaia.wire.newest import chosen_newest, newest_frame

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.spool.former_runs import FormerNewest
    from talaia.gateway.spool.spool_thread import SpoolThread
    from talaia.gateway.uplink.send_lanes import SendLanes
    from talaia.wire.newest import NewestSamples

__all__ = ["NewestSamplesSender"]


class NewestSamplesSender:
    """Tells it when a link comes up, and again when live samples had to be dropped.

    They go in the lane of live samples, so that what is heard later follows them.
    """

    def __init__(
        self,
        *,
        newest: Callable[[], NewestSamples],
        spool: SpoolThread,
        lanes: SendLanes,
        clock: Clock,
        boot: str,
    ) -> None:
        """Take who knows of this run (named ``boot``) and of former ones, and the way out."""
        self._newest = newest  # What this run knows, by channel.
        self._spool = spool  # Asked for former runs, on its own thread.
        self._lanes = lanes  # They go in the lane of live samples.
        self._clock = clock  # UTC, for how old a former run's sample may be.
        self._boot = boot  # Names this run.
        # Of former runs, once they have been read.
        self._former: list[FormerNewest] | None = None

    def tell_run(self, catalogue: str) -> None:
        """Tell what this run heard last."""
        known = self._newest()
        self._send(known, self._boot, catalogue, None)

    async def tell_former(self, addresses: Callable[[], list[str]]) -> None:
        """Tell what former runs heard last, where this one has heard nothing yet."""
        if self._former is None:
            former: list[FormerNewest] = []
            known = self._heard(addresses())
            now_us = self._clock.wall_ns() // 1000
            async for batch in self._spool.former_newest(known, now_us):
                former.append(batch)
                self._tell_one(batch, addresses())
                # Every channel is known by then: older runs could add nothing.
                if known.issuperset(addresses()):
                    break
            self._former = former
            return
        for batch in self._former:
            self._tell_one(batch, addresses())

    def _heard(self, addresses: list[str]) -> set[str]:
        return {addresses[at] for at in self._newest().columns.channel.tolist()}

    def _tell_one(self, former: FormerNewest, addresses: list[str]) -> None:
        heard = self._heard(addresses)
        columns = former.known.columns
        unheard = [former.addresses[at] not in heard for at in columns.channel.tolist()]
        keep = np.array(unheard, bool)
        if keep.any():
            known = chosen_newest(former.known, keep)
            self._send(known, former.boot, former.catalogue, former.addresses)

    def _send(
        self, known: NewestSamples, boot: str, catalogue: str, addresses: list[str] | None
    ) -> None:
        if not len(known.columns):
            return
        data = LINK_FROM_GATEWAY.encode(newest_frame(known, boot, catalogue, addresses))
        self._lanes.newest(data)
