"""Sends the outbox to the hub: one file at a time, below the live lanes, at a bounded rate.

The hub says how much of a file it has; a link that is lost begins there again.
"""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from talaia.wire.frames import MAX_PART, UploadPart

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Executor

    from talaia.gateway.frames.outbox import Outbox
    from talaia.gateway.ports import EventSink
    from talaia.gateway.uplink.lanes import Lanes
    from talaia.wire.frames import UploadOffer, UploadState

__all__ = ["Upload"]

T = TypeVar("T")
log = logging.getLogger(__name__)
# So much may be on its way without the hub's word for it.
MOST_UNHEARD = 16 * MAX_PART
ANSWER_S = 10.0
LOOK_S = 5.0


class Upload:
    """Runs beside a link; `hear` takes what the hub says."""

    def __init__(
        self, outbox: Outbox, lanes: Lanes, events: EventSink, rate: int, disk: Executor
    ) -> None:
        """Send at most ``rate`` bytes a second."""
        self._outbox, self._lanes, self._events = outbox, lanes, events
        self._rate, self._disk = rate, disk
        self._there = asyncio.Event()
        self._heard = asyncio.Event()
        self._state: UploadState | None = None

    def wake(self) -> None:
        """There is something new; any thread may have it called by the loop."""
        self._there.set()

    def hear(self, state: UploadState) -> None:
        """Take the hub's word on a file."""
        self._state = state
        self._heard.set()

    async def run(self) -> None:
        """Send for as long as the link lasts."""
        passed = ""
        while True:
            self._there.clear()
            offer = await self._on_disk(partial(self._outbox.first, passed))
            if offer is None:
                passed = ""
                try:
                    await asyncio.wait_for(self._there.wait(), LOOK_S)
                except TimeoutError:
                    continue
                continue
            passed = offer.file if not await self._one(offer) else ""

    async def _one(self, offer: UploadOffer) -> bool:
        """Send one file; tell whether it is dealt with."""
        self._state = None
        self._lanes.send(offer)
        state = await self._word(offer.file, -1)
        if state is None:
            return False
        sent = state.below
        while not state.done and not state.refused:
            if sent < offer.size and sent - state.below < MOST_UNHEARD:
                data = await self._on_disk(partial(self._outbox.read, offer.file, sent, MAX_PART))
                # The lane below all others; what is more urgent goes before each part.
                while self._lanes.backfill_waiting > 1:  # noqa: ASYNC110 - the writer tells nobody
                    await asyncio.sleep(0.05)
                self._lanes.send(UploadPart(file=offer.file, offset=sent, data=data))
                sent += len(data)
                await asyncio.sleep(len(data) / self._rate)
                state = self._newest(offer.file) or state
                continue
            newer = await self._word(offer.file, state.below)
            if newer is None:
                return False
            # It has less than was sent: a part was lost on its way.
            if newer.again:
                sent = newer.below
            state = newer
        if state.refused:
            log.warning(
                "the hub does not take %s of %s: %s", offer.kind, offer.device, state.refused
            )
            said = f"the hub does not take it: {state.refused}"
            self._events.tell("file_refused", said, device=offer.device)
            await self._on_disk(lambda: self._outbox.set_aside(offer.file))
        else:
            await self._on_disk(lambda: self._outbox.drop(offer.file))
        return True

    def _newest(self, file: str) -> UploadState | None:
        state = self._state
        return state if state is not None and state.file == file and not state.again else None

    async def _word(self, file: str, above: int) -> UploadState | None:
        """Wait until the hub says more than it had; none if it does not."""
        try:
            async with asyncio.timeout(ANSWER_S):
                while True:
                    state = self._state
                    if state is not None and state.file == file and (
                        state.below > above or state.done or state.refused or state.again
                    ):  # fmt: skip
                        self._state = None
                        return state
                    self._heard.clear()
                    await self._heard.wait()
        except TimeoutError:
            return None

    async def _on_disk(self, work: Callable[[], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._disk, work)
