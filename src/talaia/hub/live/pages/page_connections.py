"""The connection of one browser or of another tool's client, and all of them together.

Long, because all that one connection may wait for, and all that it is told, stands in one place.
How it is read and written is its transport's (`page_transport`).
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.first_completed import until_first
from talaia.hub.auth.tokens import new_token
from talaia.hub.live.pages.message_authorizer import STORE
from talaia.hub.live.pages.outbox import Outbox
from talaia.hub.live.pages.page_transport import GONE
from talaia.wire.browser import (
    AlarmUpdate,
    AnomalyUpdate,
    CommandUpdate,
    DeviceUpdate,
    DriveUpdate,
    HeldStopUpdate,
    InterlockUpdate,
    LeaseUpdate,
    PageCommand,
    PageDrive,
    PageLease,
    PagePing,
    PagePong,
    PageReset,
    PageStop,
    PageTwin,
    PageTwinDrive,
    RequestError,
    SessionEnded,
    SessionUpdate,
    SightingUpdate,
    SiteUpdate,
    StopUpdate,
    Subscribe,
    TickUpdate,
    TwinUpdate,
    Unsubscribe,
)
from talaia.wire.errors import PeerError
from talaia.wire.frames import LeaseOp

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterable, Iterator

    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.pages.message_authorizer import MessageAuthorizer
    from talaia.hub.live.pages.outbox import Frame
    from talaia.hub.live.pages.page_transport import PageTransport
    from talaia.wire.browser import FromBrowser, ToBrowser, Values
    from talaia.wire.columns import Columns

__all__ = ["SESSION_OVER", "Browser", "Browsers"]

# Close code for "your session is over": the page goes to the sign-in instead of trying again.
SESSION_OVER = 4401
# A browser that does not read must not hold up the end of its socket (s).
_FAREWELL_S = 0.3
# While the hub cannot tell who may do what, this many subscriptions are kept for later, and it is
# looked so often whether it can again (s).
_MOST_WISHES = 256
# Letters that a gateway and the log take as a name.
_MOST_SIGNATURE = 200
_WISH_S = 0.5


class Browser:
    """One connection of one person. A slow one hurts nobody but itself.

    Attributes:
        who: never replaced: a change of rights ends the connection, and the page loads anew.
        signature: who asks, for robots, other people and the log: the person, and by what.
        key: names this connection to gateways: a lease is held by a page, not by a person.
        form: those of the same form can be sent what was written once.
        known: asked for the newest values of a subscription's channels, by their places in its
            list.

    """

    def __init__(
        self,
        transport: PageTransport,
        who: Who,
        gate: MessageAuthorizer,
        *,
        handle: Callable[[Browser, FromBrowser], None],
        via: str = "",
    ) -> None:
        """Speak over ``transport``; what ``gate`` lets pass goes to ``handle``."""
        self.who = who
        self.signature = f"{who.name} by {via}"[:_MOST_SIGNATURE] if via else who.name
        self.key = new_token()
        self.form = transport.form
        self.known: Callable[[Browser, int, list[int]], list[Values]] = lambda *_: []
        self._transport = transport
        # Holds every message in both directions against rights.
        self._gate = gate
        # Leads what may be done to its part of the hub.
        self._handle = handle
        # What waits to be sent, bounded.
        self._outbox = Outbox(transport.encode, known=lambda sub, at: self.known(self, sub, at))
        # The outbox's task waits, with nothing in its hands: then what comes may pass it by.
        self._idle = False
        # Something waits in the outbox, or the end.
        self._wake = asyncio.Event()
        # The session is over: only the reason is still sent.
        self._over = asyncio.Event()
        self._reason = ""
        # A person has done something since this was last asked.
        self._used = False
        # Subscriptions that could not be judged, by their number, in the order they were asked.
        self._wishes: dict[int, Subscribe] = {}
        # There are such subscriptions.
        self._wished = asyncio.Event()

    @property
    def waiting(self) -> int:
        """Bytes that wait to be sent."""
        return self._outbox.weight

    def encode(self, message: ToBrowser) -> Frame:
        """Write a message in the form this browser reads."""
        return self._transport.encode(message)

    def send_message(self, message: ToBrowser, encoded: dict[str, Frame] | None = None) -> None:
        """Send a message if this person may get it; never waits.

        ``encoded`` keeps its bytes, by form, for others who get the same.
        """
        # Rights are looked at for each message, so a message has to name what it is about.
        if self._over.is_set() or not self._gate.may_get(self.who.grants, message):
            return
        encoded = {} if encoded is None else encoded
        frame = encoded.get(self.form)
        if frame is None:
            frame = encoded[self.form] = self.encode(message)
        if self._write_at_once(frame):
            return
        key = _state_key(message)
        if key is None:
            self._outbox.enqueue_frame(frame)
        else:
            self._outbox.state(key, frame)
        self._wake.set()

    def values(self, sub: int, columns: Columns, frame: Frame | None) -> None:
        """Send samples of a subscription; never waits."""
        if self._over.is_set() or (frame is not None and self._write_at_once(frame)):
            return
        self._outbox.values(sub, columns, frame)
        self._wake.set()

    def owe(self, sub: int, places: Iterable[int], *, first: bool = False) -> None:
        """Have the newest values of channels of a subscription told; see `Outbox.owe`."""
        if not self._over.is_set():
            self._outbox.owe(sub, places, first=first)
            self._wake.set()

    def forget(self, sub: int) -> None:
        """Drop what waits of a subscription."""
        self._outbox.forget(sub)

    def end(self, reason: str) -> None:
        """Tell the person that the session is over and close; nothing else is sent or heard."""
        # The first reason stays.
        self._reason = self._reason or reason
        self._over.set()

    def tell_end(self, ends_us: int, *, idle: bool) -> None:
        """Tell the person when the session ends (UTC, µs); 0: it goes on after all."""
        self.send_message(SessionUpdate(ends_us=ends_us, idle=idle))

    def take_use(self) -> bool:
        """Tell whether the person has done something since this was last asked."""
        used, self._used = self._used, False
        return used

    async def serve(self, left: Callable[[], None]) -> None:
        """Read and write until either side ends it; ``left`` is called before any farewell."""
        results = await until_first(
            self._transport.read_messages(self._receive, self.send_message),
            self._write(),
            self._grant(),
            self._over.wait(),
        )
        # Before the farewell, which takes a while: leases of this page are free at once.
        left()
        if self._over.is_set():
            await self._farewell(SESSION_OVER, SessionEnded(reason=self._reason))
        for result in results:
            if isinstance(result, PeerError):
                await self._farewell(
                    result.code, RequestError(code="invalid", message=result.problem[:500])
                )
            elif isinstance(result, Exception) and not isinstance(result, GONE):
                raise result

    def request(self, message: FromBrowser) -> RequestError | None:
        """Do what a message asks if it may be done; else give why not, for the asker alone.

        A subscription that cannot be judged now is kept, and granted when it can be.
        """
        # What was read before the end was known is not done any more.
        if self._over.is_set():
            return RequestError(code="forbidden", message=self._reason or "the connection ends")
        # What a page does by itself does not keep its session alive.
        self._used = self._used or _by_hand(message)
        if isinstance(message, Subscribe | Unsubscribe):
            # A newer wish, or none, takes the place of one that waits.
            self._wishes.pop(message.sub, None)
        # Rights first: who may not even see a device must not learn of it from another refusal.
        problem = self._gate.refusal(self.who.grants, message)
        problem = problem or self._transport.refuse_request(message)
        if problem is None:
            self._handle(self, message)
        elif (
            isinstance(message, Subscribe)
            and problem.code == STORE
            and len(self._wishes) < _MOST_WISHES
        ):
            self._wishes[message.sub] = message
            self._wished.set()
        return problem

    def _receive(self, message: FromBrowser) -> None:
        """Do what a page asks, and tell it why not."""
        problem = self.request(message)
        if problem is not None:
            self.send_message(problem)

    async def _grant(self) -> None:
        """Grant what was wished while nobody could tell whether it may be."""
        while True:
            await self._wished.wait()
            await asyncio.sleep(_WISH_S)
            for sub, message in list(self._wishes.items()):
                problem = self._gate.refusal(self.who.grants, message)
                if problem is not None and problem.code == STORE:
                    # Rights are not known yet: the others would get the same answer.
                    break
                del self._wishes[sub]
                if problem is None:
                    self._handle(self, message)
                else:
                    self.send_message(problem)
            if not self._wishes:
                self._wished.clear()

    def _write_at_once(self, frame: Frame) -> bool:
        """Send a frame past the outbox if nothing waits there; a task for each costs more."""
        return self._idle and not self._outbox and self._transport.write_frame(frame)

    async def _write(self) -> None:
        while True:
            self._idle = True
            await self._wake.wait()
            self._idle = False
            # Before the outbox is emptied: what is added meanwhile sets it again.
            self._wake.clear()
            while self._outbox:
                for frame in self._outbox.next_frames():
                    await self._transport.send_frame(frame)

    async def _farewell(self, code: int, last: ToBrowser) -> None:
        """Say one last thing and close, to a browser that may not be listening."""
        try:
            async with asyncio.timeout(_FAREWELL_S):
                await self._transport.send_frame(self.encode(last))
                await self._transport.close_connection(code)
        except GONE:
            return


class Browsers:
    """All sockets that are open now."""

    def __init__(self) -> None:
        """Start with none."""
        # By key.
        self._browsers: dict[str, Browser] = {}

    def __iter__(self) -> Iterator[Browser]:
        """Go through them; the list may change meanwhile."""
        return iter(list(self._browsers.values()))

    def add(self, browser: Browser) -> None:
        """Take a browser in."""
        self._browsers[browser.key] = browser

    def remove(self, browser: Browser) -> None:
        """Let a browser go."""
        self._browsers.pop(browser.key, None)

    def get(self, key: str) -> Browser | None:
        """Find the socket with a key."""
        return self._browsers.get(key)

    def broadcast_message(self, message: ToBrowser) -> None:
        """Send a message to everyone who may get it."""
        # Written once in each form, for all who read it.
        encoded: dict[str, Frame] = {}
        for browser in self:
            browser.send_message(message, encoded)


def _by_hand(message: FromBrowser) -> bool:
    """Tell whether a person did something, and not the page by itself."""
    match message:
        case PagePing():
            return message.active
        case PageLease():
            return message.op is not LeaseOp.RENEW
        case PageDrive() | PageTwin() | PageTwinDrive() | PageStop() | PageReset() | PageCommand():
            return True
        case _:
            return False


def _state_key(message: ToBrowser) -> Hashable | None:
    """Give the key of a message of which only the newest counts; None when each does."""
    match message:
        case SiteUpdate() | TickUpdate():
            return type(message), message.site
        case (
            DeviceUpdate()
            | DriveUpdate()
            | TwinUpdate()
            | HeldStopUpdate()
            | LeaseUpdate(refused="")
        ):
            return type(message), message.site, message.device
        case AlarmUpdate():
            return AlarmUpdate, message.site, message.alarm
        case SightingUpdate():
            return SightingUpdate, message.site, message.id
        case AnomalyUpdate():
            return AnomalyUpdate, message.site, message.address, message.detector
        case InterlockUpdate():
            return InterlockUpdate, message.site, message.interlock
        case StopUpdate():
            # A repeated STOP waits for the answer with its own id.
            return StopUpdate, message.site, message.device, message.id
        case CommandUpdate():
            return CommandUpdate, message.site, message.id
        case PagePong() | SessionUpdate():
            return type(message)
        case _:
            return None
