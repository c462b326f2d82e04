"""The connection of one client of another tool: a page's, but with messages as they are.

It is a `Browser` like a page's: the same rights on every message both ways, the same bounded
outbox, the same leases. Only its transport differs: nothing is encoded, since the protocol's own
session, in this process, turns messages into what its client reads.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Protocol

from talaia.clock import SECOND
from talaia.first_completed import until_first
from talaia.hub.auth.tokens import new_token
from talaia.hub.clients.client_driving import ClientDriving
from talaia.hub.live.pages.outbox import MessageFrame

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Right, Who
    from talaia.hub.clients.open_protocols import OpenProtocols
    from talaia.hub.live.pages.outbox import Frame
    from talaia.hub.live.pages.page_connections import Browser
    from talaia.hub.live.pages.page_service import PageService
    from talaia.hub.live.sites import LiveSite
    from talaia.model.site import Site
    from talaia.wire.browser import FromBrowser, RequestError, ToBrowser

__all__ = ["ClientConnection", "ClientConnections", "ClientSession"]


class ClientSession(Protocol):
    """What a protocol does with a connection: one of these for each client."""

    async def read_client(self) -> None:
        """Read the client until it has gone, and ask the hub what it wants.

        Raises:
            PeerError: what came breaks the protocol.

        """
        ...

    async def deliver_message(self, message: ToBrowser) -> None:
        """Write a message of the hub for the client; returns when there is room for another.

        Messages of all sites come that the account may see. While this waits, the hub thins what
        comes after.
        """
        ...

    async def warn_person(self, text: str) -> None:
        """Tell the client's person something that is no answer: why it does not drive."""
        ...

    async def close_client(self, code: int) -> None:
        """Close the client's connection with a WebSocket close code."""
        ...


class ClientConnection:
    """One client of another tool, signed in, at one site.

    Attributes:
        who: signed in by a token.
        live: the site that it is connected to.

    """

    def __init__(
        self,
        live: LiveSite,
        who: Who,
        *,
        service: PageService,
        may_drive: Callable[[str], bool],
        clock: Clock,
        via: str = "",
    ) -> None:
        """Connect through ``service``; ``may_drive`` says it of each device, at each message."""
        # A change of rights ends the connection, as a page's.
        self.who = who
        self.live = live
        self._service = service
        self._clock = clock
        # Set as it is served; before that nothing is written.
        self._session: ClientSession | None = None
        self._may_drive = may_drive
        self._browser: Browser = service.connect(self, who, via=via)
        self._driving = ClientDriving(live.name, ask=self.request, permits=may_drive)
        # Something about driving has changed, so it may be due at another time.
        self._drive_changed = asyncio.Event()

    @property
    def form(self) -> str:
        """All such connections are sent the same objects."""
        return "object"

    @property
    def description(self) -> Site:
        """The site's description as it is now."""
        return self.live.description

    def has_right(self, right: Right, device: str) -> bool:
        """Tell whether the account has a right on a device."""
        return self.who.grants.has_right(right, self.live.name, device)

    def may_drive(self, device: str) -> bool:
        """Tell whether an admin lets the account drive a device by such clients, now."""
        return self._may_drive(device)

    def request(self, message: FromBrowser) -> RequestError | None:
        """Ask the hub; give the refusal if the account may not.

        What else comes of it is delivered to the session: `Subscribed`, `CommandUpdate` and so on.
        """
        return self._browser.request(message)

    def publish_drive(
        self, device: str, *, linear: float, angular: float, lateral: float = 0.0
    ) -> str:
        """Take a velocity that the client published; give why it is refused, if so."""
        described = self.description.devices.get(device)
        rule = described.drive if described is not None else None
        now_ns = self._clock.monotonic_ns()
        why = self._driving.publish_velocity(
            device, rule, linear=linear, angular=angular, lateral=lateral, now_ns=now_ns
        )
        self._drive_changed.set()
        return why

    def release_drive(self, device: str) -> None:
        """Stop a device that the client drives, and give its lease back."""
        self._driving.release_device(device, self._clock.monotonic_ns())
        self._drive_changed.set()

    def press_stop(self, device: str) -> tuple[str, str]:
        """Press STOP (software): give its id, which `StopUpdate` answers, and why not, if so."""
        press = f"client-{new_token()}"
        why = self._driving.press_stop(device, press, self._clock.monotonic_ns())
        self._drive_changed.set()
        return press, why

    async def serve_client(self, session: ClientSession) -> None:
        """Serve the client until either side ends it."""
        self._session = session
        await self._service.serve(self._browser)

    # ── a socket of a person, see `SessionSocket` ──

    def end(self, reason: str) -> None:
        """Close, with the reason; nothing else is sent or heard."""
        self._browser.end(reason)

    # ── a transport, see `PageTransport` ──

    def refuse_request(self, message: FromBrowser) -> None:
        """Refuse nothing: what a client drives has gone by the rules of `ClientDriving`."""

    def encode(self, message: ToBrowser) -> Frame:
        """Keep a message as it is."""
        return MessageFrame(message)

    async def read_messages(self, *_: object) -> None:
        """Let the session read its client, and driving keep its times."""
        for result in await until_first(self._opened().read_client(), self._keep_driving()):
            if isinstance(result, Exception):
                raise result

    def write_frame(self, _frame: Frame) -> bool:
        """Write nothing at once: the session may have to wait for its client."""
        return False

    async def send_frame(self, frame: Frame) -> None:
        """Hand a message to the session."""
        if not isinstance(frame, MessageFrame):
            raise TypeError(f"a client is not sent {type(frame).__name__}")
        # First: what is told to the client may wait for it, driving must not.
        told = self._driving.observe_news(frame.message, self._clock.monotonic_ns())
        self._drive_changed.set()
        if told:
            await self._opened().warn_person(told)
        await self._opened().deliver_message(frame.message)

    async def close_connection(self, code: int) -> None:
        """Close the client's connection."""
        await self._opened().close_client(code)

    def _opened(self) -> ClientSession:
        if self._session is None:
            raise RuntimeError("a client is served before it is written to")
        return self._session

    async def _keep_driving(self) -> None:
        while True:
            self._drive_changed.clear()
            due_ns = self._driving.due_ns()
            wait_s = None
            if due_ns is not None:
                wait_s = max(0.0, (due_ns - self._clock.monotonic_ns()) / SECOND)
            try:
                async with asyncio.timeout(wait_s):
                    await self._drive_changed.wait()
            except TimeoutError:
                self._driving.step(self._clock.monotonic_ns())


class ClientConnections:
    """Makes and serves the connections of clients."""

    def __init__(self, *, service: PageService, protocols: OpenProtocols, clock: Clock) -> None:
        """Serve them by ``service``, as pages are, while their protocol is open."""
        self._service = service
        self._protocols = protocols
        self._clock = clock

    def connect(self, live: LiveSite, who: Who, *, via: str = "") -> ClientConnection:
        """Connect an account to a site; ``via`` is what it is known by beside its name."""
        return ClientConnection(
            live,
            who,
            service=self._service,
            may_drive=lambda device: self._protocols.may_drive(who.user, live.name, device),
            clock=self._clock,
            via=via,
        )
