"""Who comes while no hub leads waits for the next one, for a moment."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, MutableMapping
    from typing import Any

    from starlette.types import Receive

__all__ = ["HeldOpening", "LeadWait"]

# A take-over lasts no longer in most cases, and gateways have a little more patience (s).
HELD_S = 4.0
# Each is a socket in memory.
_MOST_HELD = 5_000


class LeadWait:
    """Holds requests until a hub leads.

    To send them away would cost each the pause after which it dials again, and whatever stands
    before the hubs as many connections more.
    """

    def __init__(
        self, find: Callable[[], bool], expects: Callable[[], bool], *, held_s: float = HELD_S
    ) -> None:
        """Ask ``find`` whether a hub leads, and ``expects`` whether one is to be waited for."""
        self._find, self._expects = find, expects
        self._held_s = held_s
        self._held = 0
        self._news = asyncio.Event()

    def notify(self) -> None:
        """Let those who wait look again."""
        news, self._news = self._news, asyncio.Event()
        news.set()

    async def wait_for_lead(self, since_s: float) -> bool:
        """Return once a hub leads; False: it takes too long for one who came at ``since_s``."""
        if self._find():
            return True
        if self._held >= _MOST_HELD or not self._expects():
            return False
        self._held += 1
        try:
            async with asyncio.timeout_at(since_s + self._held_s):
                while not self._find():
                    await self._news.wait()
        except TimeoutError:
            return False
        finally:
            self._held -= 1
        return True


class HeldOpening:
    """What somebody said who wants to open a socket, so that another hub can be told, too.

    Attributes:
        began_s: when they came (of the event loop).

    """

    def __init__(self, receive: Receive) -> None:
        """Hear them by ``receive``."""
        self._receive = receive
        self._first: MutableMapping[str, Any] | None = None
        self._again = False
        self._said_more = False
        self.began_s = asyncio.get_running_loop().time()

    async def receive(self) -> MutableMapping[str, Any]:
        """Give what they say next; what they said first once more after `begin_again`."""
        if self._again and self._first is not None:
            self._again = False
            return self._first
        message = await self._receive()
        if self._first is None:
            self._first = message
        else:
            self._said_more = True
        return message

    def begin_again(self) -> bool:
        """Begin anew with what they said first; False: they have said more, or have gone."""
        self._again = True
        return not self._said_more
