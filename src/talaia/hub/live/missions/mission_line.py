"""The connection by which a mission asks: a page's, with nobody before it.

Each of its commands passes the same gate as a person's, so rights, interlocks, holders and the log
treat it alike; and the connection ends, as theirs do, when the account's rights change.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.live.pages.outbox import MessageFrame
from talaia.wire.browser import CommandUpdate, PageCommand, SessionEnded

if TYPE_CHECKING:
    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.pages.outbox import Frame
    from talaia.hub.live.pages.page_connections import Browser
    from talaia.hub.live.pages.page_service import PageService
    from talaia.wire.browser import FromBrowser, RequestError, ToBrowser

__all__ = ["MissionLine"]

_OVER = "the mission is over"


class MissionLine:
    """One run's connection.

    Attributes:
        over: why it has ended; empty while it stands.
        newest: how the command stands that was asked for last; None before anything was heard.

    """

    def __init__(self, service: PageService, who: Who, name: str) -> None:
        """Ask for ``who``, by the mission ``name``."""
        self.over = ""
        self.newest: CommandUpdate | None = None
        self._service = service
        self._asked = ""
        self._browser: Browser = service.connect(self, who, via=f"mission {name}")
        self._serving: asyncio.Task[None] | None = None

    @property
    def signature(self) -> str:
        """Who asks, for robots and the log."""
        return self._browser.signature

    def begin_hearing(self) -> None:
        """Begin to hear."""
        self._serving = asyncio.create_task(self._service.serve(self._browser))

    async def end_hearing(self) -> None:
        """End it."""
        self._browser.end(_OVER)
        if self._serving is not None:
            await asyncio.wait([self._serving])

    def request_command(self, command: PageCommand) -> str:
        """Ask for a command; give why it was refused at once, if so. The rest is `newest`."""
        self._asked, self.newest = command.id, None
        problem = self._browser.request(command)
        return "" if problem is None else problem.message

    # ── a transport, see `PageTransport` ──

    @property
    def form(self) -> str:
        """It is sent messages as they are."""
        return "object"

    def encode(self, message: ToBrowser) -> Frame:
        """Keep a message as it is."""
        return MessageFrame(message)

    def refuse_request(self, message: FromBrowser) -> RequestError | None:
        """Refuse nothing: a mission asks for commands alone."""
        return None

    async def read_messages(self, *_: object) -> None:
        """Wait: nobody speaks here."""
        await asyncio.Event().wait()

    def write_frame(self, _frame: Frame) -> bool:
        """Take nothing at once."""
        return False

    async def send_frame(self, frame: Frame) -> None:
        """Take what is told of the command that was asked for."""
        if not isinstance(frame, MessageFrame):
            raise TypeError(f"a mission is not sent {type(frame).__name__}")
        message = frame.message
        if isinstance(message, CommandUpdate) and message.id == self._asked:
            self.newest = message
        elif isinstance(message, SessionEnded):
            self.over = message.reason

    async def close_connection(self, code: int) -> None:
        """Note the end."""
        self.over = self.over or _OVER
