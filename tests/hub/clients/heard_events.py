"""Events that a client in a test heard, and a wait for one of them."""

from __future__ import annotations

import asyncio

from patience import PATIENCE_S


class HeardEvents:
    """Events in their order: a name, maybe more about it, and last its data."""

    def __init__(self) -> None:
        """Begin with none."""
        self.events = []
        # How many were taken out: places are others then.
        self._taken = 0
        self._news = asyncio.Condition()

    async def note(self, *event) -> None:
        async with self._news:
            self.events.append(event)
            self._news.notify_all()

    async def hear(self, event, where=lambda _data: True):
        """Wait for an event, of those heard already or still to come; it is taken out."""
        async with asyncio.timeout(PATIENCE_S), self._news:
            seen, taken = 0, self._taken
            while True:
                if taken != self._taken:
                    seen, taken = 0, self._taken
                # Only what is new: a flood would be gone through again with each message.
                for at in range(seen, len(self.events)):
                    found = self.events[at]
                    if found[0] == event and where(found[-1]):
                        del self.events[at]
                        self._taken += 1
                        return found[-1]
                seen = len(self.events)
                await self._news.wait()
