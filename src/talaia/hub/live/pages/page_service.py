"""What every connection goes through, a page's or another tool's: greeting, messages, the end."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from talaia import __version__
from talaia.hub.live.pages.page_connections import Browser
from talaia.wire import browser as page

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.pages.fanout import Fanout
    from talaia.hub.live.pages.message_authorizer import MessageAuthorizer
    from talaia.hub.live.pages.page_commands import PageCommands
    from talaia.hub.live.pages.page_connections import Browsers
    from talaia.hub.live.pages.page_transport import PageTransport
    from talaia.hub.live.pages.session_registry import SocketSessions
    from talaia.wire.browser import FromBrowser, Subscribe

__all__ = ["PageMessages", "PageService"]

# With these bounds the newest sample of every channel fits in a browser's outbox.
MOST_SUBSCRIPTIONS = 256
MOST_CHANNELS = 60_000


class Greeter(Protocol):
    """A part that tells a page how things are when it connects."""

    def greet(self, browser: Browser) -> None:
        """Send the page what is true now."""
        ...


class PageMessages:
    """Hands each message of a page to the part that it is for."""

    def __init__(self, *, fanout: Fanout, commanding: PageCommands, clock: Clock) -> None:
        """Subscribe at ``fanout``; the rest is asked of robots by ``commanding``."""
        self._fanout = fanout
        self._commanding = commanding
        self._clock = clock

    def send_greeting(self, browser: Browser) -> None:
        """Send the first message."""
        # Refused whole: a part of the channels would look like all of them.
        browser.send_message(
            page.Greeting(
                version=__version__,
                who=browser.who.name,
                role=browser.who.role,
                time_us=self._clock.wall_ns() // 1000,
            )
        )

    def receive(self, browser: Browser, message: FromBrowser) -> None:
        """Lead a message, which the gate has let pass, to its part."""
        match message:
            case page.Subscribe():
                self._subscribe(browser, message)
            case page.Unsubscribe():
                self._fanout.unsubscribe(browser, message.sub)
            case page.PagePing():
                browser.send_message(
                    page.PagePong(
                        n=message.n,
                        at_ms=message.at_ms,
                        hub_us=self._clock.monotonic_ns() // 1000,
                    )
                )
            case _:
                self._commanding.ask(browser, message)

    def release_leases(self, browser: Browser) -> None:
        """Give back what a page held, at once."""
        self._commanding.leave(browser)

    def forget(self, browser: Browser) -> None:
        """End the subscriptions and leases of a page that is gone."""
        self._fanout.leave(browser)
        self._commanding.leave(browser)

    def _subscribe(self, browser: Browser, asked: Subscribe) -> None:
        subscriptions, channels = self._fanout.held(browser)
        if subscriptions >= MOST_SUBSCRIPTIONS or channels + len(asked.channels) > MOST_CHANNELS:
            browser.send_message(
                page.RequestError(
                    code="busy",
                    message=f"at most {MOST_CHANNELS} channels in {MOST_SUBSCRIPTIONS}"
                    " subscriptions on one connection",
                    about="subscribe",
                )
            )
            return
        self._fanout.subscribe(browser, asked)


class PageService:
    """Serves connections over any transport, all by the same rights."""

    def __init__(
        self,
        *,
        gate: MessageAuthorizer,
        seats: SocketSessions,
        browsers: Browsers,
        greeters: Sequence[Greeter],
        messages: PageMessages,
    ) -> None:
        """Messages pass ``gate``; ``greeters`` tell each how things are when it comes."""
        # One for all connections: pages and clients have the same rights.
        self._gate = gate
        self._seats = seats
        # Who is told of news; a connection is in it while it is served.
        self._browsers = browsers
        self._greeters = greeters
        self._messages = messages

    def connect(self, transport: PageTransport, who: Who, *, via: str = "") -> Browser:
        """Make the connection of a person; `serve` serves it. ``via`` names what they come by."""
        return Browser(transport, who, self._gate, handle=self._messages.receive, via=via)

    async def serve(self, browser: Browser) -> None:
        """Greet, read and write until either side ends it."""
        # Nothing is awaited until all has been said, so no news gets in between or is missed.
        self._browsers.add(browser)
        self._seats.add(browser)
        self._messages.send_greeting(browser)
        for greeter in self._greeters:
            greeter.greet(browser)
        try:
            await browser.serve(lambda: self._messages.release_leases(browser))
        finally:
            # Whatever ended it: a lease that stayed would keep others from driving.
            self._seats.remove(browser)
            self._browsers.remove(browser)
            self._messages.forget(browser)
