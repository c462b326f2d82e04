"""The doors of the five sockets: who comes in, and to whom they are led."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, WebSocket

from talaia import __version__
from talaia.hub.api.access import deny
from talaia.hub.api.limits import MOST_SOCKETS
from talaia.hub.auth.permissions import sees_stream
from talaia.hub.live.browsers import Browser
from talaia.hub.live.viewer import Viewer
from talaia.wire import browser as page

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.api.access import Access
    from talaia.hub.api.limits import Limits
    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.browsers import Browsers
    from talaia.hub.live.commanding import Commanding
    from talaia.hub.live.fanout import Fanout
    from talaia.hub.live.gate import Gate
    from talaia.hub.live.gateways import Gateways
    from talaia.hub.live.media import Media
    from talaia.hub.live.reporting import Reporting
    from talaia.hub.live.seats import Seats
    from talaia.hub.live.sightings import Sightings
    from talaia.hub.live.sites import Sites
    from talaia.wire.browser import FromBrowser, Subscribe

__all__ = ["Sockets"]

# With these bounds the newest sample of every channel fits in a browser's outbox.
MOST_SUBSCRIPTIONS = 256
MOST_CHANNELS = 60_000
# What a page can show, as words with commas between (characters).
MOST_FORMS = 200


class Sockets:
    """Leads sockets to the live parts."""

    def __init__(
        self,
        access: Access,
        limits: Limits,
        sites: Sites,
        gate: Gate,
        seats: Seats,
        browsers: Browsers,
        fanout: Fanout,
        commanding: Commanding,
        reporting: Reporting,
        sightings: Sightings,
        media: Media,
        gateways: Gateways,
        clock: Clock,
    ) -> None:
        """Take the parts that a socket's words go to."""
        self._access = access
        self._limits = limits
        self._sites = sites
        self._gate = gate
        self._seats = seats
        self._browsers = browsers
        self._fanout = fanout
        self._commanding = commanding
        self._reporting = reporting
        self._sightings = sightings
        self._media = media
        self._gateways = gateways
        self._clock = clock

    def router(self) -> APIRouter:
        """Give the doors."""
        router = APIRouter()
        router.websocket("/ws")(self.room)
        router.websocket("/ws/media")(self.pictures)
        router.websocket("/gateway/link")(self.link)
        router.websocket("/gateway/media")(self.camera)
        router.websocket("/gateway/files")(self.files)
        return router

    async def room(self, socket: WebSocket) -> None:
        """Serve a page: values, commands, driving."""
        who = await self._access.admit(socket)
        if who is not None:
            with self._limits.socket(who) as allowed:
                await (self._room(socket, who) if allowed else _too_many(socket))

    async def _room(self, socket: WebSocket, who: Who) -> None:
        await socket.accept()
        browser = Browser(socket, who, self._gate, text=_speaks_json(socket))
        self._browsers.add(browser)
        self._seats.add(browser)
        browser.tell(
            page.Greeting(
                version=__version__,
                who=who.name,
                role=who.role,
                time_us=self._clock.wall_ns() // 1000,
            )
        )
        self._reporting.greet(browser)
        self._sightings.greet(browser)
        try:
            await browser.serve(self._handle, lambda: self._commanding.leave(browser))
        finally:
            self._seats.remove(browser)
            self._browsers.remove(browser)
            self._fanout.leave(browser)
            self._commanding.leave(browser)

    async def pictures(self, socket: WebSocket) -> None:
        """Serve the pictures of one stream to one page."""
        who = await self._access.admit(socket)
        if who is not None:
            with self._limits.socket(who) as allowed:
                await (self._pictures(socket, who) if allowed else _too_many(socket))

    async def _pictures(self, socket: WebSocket, who: Who) -> None:
        site, stream = (socket.query_params.get(key, "") for key in ("site", "stream"))
        live = self._sites.get(site)
        if live is None or not sees_stream(
            who.grants, live.description, *(stream.split("/", 1) if "/" in stream else ("", ""))
        ):
            await deny(socket, 404, "unknown", "there is no such stream")
            return
        await socket.accept()
        viewer = Viewer(
            socket, who, site, stream, self._now_us,
            frozenset(socket.query_params.get("forms", "")[:MOST_FORMS].split(",")) - {""},
            text=_speaks_json(socket),
        )  # fmt: skip
        self._seats.add(viewer)
        self._media.join(viewer)
        try:
            await viewer.serve()
        finally:
            self._media.leave(viewer)
            self._seats.remove(viewer)

    async def link(self, socket: WebSocket) -> None:
        """Serve a gateway."""
        key = await self._access.admit_gateway(socket)
        if key is not None:
            await socket.accept()
            await self._gateways.serve(socket, key)

    async def camera(self, socket: WebSocket) -> None:
        """Take a gateway's pictures."""
        key = await self._access.admit_gateway(socket)
        if key is not None:
            await socket.accept()
            await self._gateways.serve_media(socket, key)

    async def files(self, socket: WebSocket) -> None:
        """Take a gateway's recordings."""
        key = await self._access.admit_gateway(socket)
        if key is not None:
            await socket.accept()
            await self._gateways.serve_files(socket, key)

    def _now_us(self) -> int:
        return self._clock.monotonic_ns() // 1000

    def _handle(self, browser: Browser, message: FromBrowser) -> None:
        """Lead a message, which the gate has let pass, to its part."""
        match message:
            case page.Subscribe():
                self._subscribe(browser, message)
            case page.Unsubscribe():
                self._fanout.unsubscribe(browser, message.sub)
            case page.Ping():
                browser.tell(
                    page.Pong(
                        n=message.n,
                        at_ms=message.at_ms,
                        hub_us=self._clock.monotonic_ns() // 1000,
                    )
                )
            case _:
                self._commanding.ask(browser, message)

    def _subscribe(self, browser: Browser, asked: Subscribe) -> None:
        subscriptions, channels = self._fanout.held(browser)
        if subscriptions >= MOST_SUBSCRIPTIONS or channels + len(asked.channels) > MOST_CHANNELS:
            browser.tell(
                page.Problem(
                    code="busy",
                    message=f"at most {MOST_CHANNELS} channels in {MOST_SUBSCRIPTIONS}"
                    " subscriptions on one connection",
                    about="subscribe",
                )
            )
            return
        self._fanout.subscribe(browser, asked)


async def _too_many(socket: WebSocket) -> None:
    await deny(socket, 429, "busy", f"at most {MOST_SOCKETS} connections at once; close some pages")


def _speaks_json(socket: WebSocket) -> bool:
    return socket.query_params.get("form") == "json"
