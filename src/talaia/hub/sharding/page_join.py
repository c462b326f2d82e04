"""A page's one socket, joined of one socket to each shard.

A page knows of no shards. What it says of a site goes to the shard that has the site, and what any
of them tells goes to the page, both as the bytes they are. The main shard lets it in and answers
its pings; without it there is no page. Of another shard that is away the page hears that its sites
are, and it is asked again until it is back.
"""

from __future__ import annotations

import asyncio
import logging
import random
from typing import TYPE_CHECKING

from talaia.clock import SystemClock
from talaia.hub.sharding.asked_sites import AskedSites
from talaia.hub.sharding.page_frames import data_of, read_asked
from talaia.hub.sharding.page_news import KnownSites, PageNews
from talaia.hub.sharding.page_subscriptions import PageSubscriptions, end_message
from talaia.hub.sharding.page_writer import PageWriter
from talaia.hub.sharding.plan import MAIN
from talaia.hub.sharding.shard_socket import ShardSocket
from talaia.wire.browser import RequestError, SiteUpdate
from talaia.wire.socket_frame import FRAME_WRITER

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from talaia.clock import Clock
    from talaia.hub.sharding.page_frames import AskedAbout
    from talaia.wire.socket_frame import SocketFrame

__all__ = ["PageJoin"]

_LOG = logging.getLogger(__name__)
# A shard that is away is asked again so often (s), more or less: pages do not all come at once.
_RETRY_S = 1.0
# When the page goes, sockets at shards end by themselves within this (s), or are cancelled.
_ENDING_S = 2.0
# Sites that a page is told are away, before others have a turn.
_AT_ONCE = 20
# Codes (RFC 6455, 7.4.1, and IANA's registry) by which a shard says nothing to the page, but that
# it cannot go on: it goes away, broke off, failed, starts anew, or has too much to do.
_BROKEN = frozenset({1000, 1001, 1005, 1006, 1011, 1012, 1013})
_RESTARTS = 1012
# Asked many times a second: the page sees by the site itself that it is away.
_UNANSWERED = frozenset({"drive", "twin_drive", "subscribe", "unsubscribe"})
_AWAY = "the hub that has this site cannot be reached; it is tried again"


class PageJoin:
    """Serves pages' sockets by the applications of all shards."""

    def __init__(
        self,
        apps: Mapping[str, ASGIApp],
        shard_of: Callable[[str], Awaitable[str] | str],
        *,
        retry_s: float = _RETRY_S,
        clock: Clock | None = None,
    ) -> None:
        """Join what ``apps`` say, by the names of their shards; ``main`` is among them.

        ``shard_of`` names the shard of a site. It gives the name at once where it can: what a page
        says of other sites does not wait for an answer, and what it says of this one does. A shard
        that is away is asked again every ``retry_s``.
        """
        self.apps = apps
        self.shard_of = shard_of
        self.retry_s = retry_s
        self.clock = clock or SystemClock()
        self.known = KnownSites()

    async def serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one page until it has gone, or the main shard has.

        Raises:
            Exception: what the main shard's application raised before it let the page in.

        """
        page = _JoinedPage(self, scope, PageWriter(scope, send))
        await page.serve(receive)


class _JoinedPage:
    """One page."""

    def __init__(self, join: PageJoin, scope: Scope, writer: PageWriter) -> None:
        self._join = join
        self._scope = scope
        self._writer = writer
        # By shard, while it has let the page in.
        self._open: dict[str, ShardSocket] = {}
        self._main = ShardSocket(MAIN, self._scope_of(MAIN), self._hear_main)
        self._subscriptions = PageSubscriptions()
        self._news = PageNews(join.known, self._subscriptions, join.apps)
        self._asked = AskedSites(join.shard_of, self._hand_up, limit_reached=self._drop)
        # By shard: has a socket there.
        self._keeping: dict[str, asyncio.Task[None]] = {}
        # The page has gone, or is sent away, and with which code (None: it went by itself).
        self._over = asyncio.Event()
        self._code: int | None = None
        self._gone_code = 1001
        self._begun = False

    async def serve(self, receive: Receive) -> None:
        # The wish to connect: each shard's socket has its own.
        await receive()
        main = asyncio.create_task(self._main.run(self._join.apps[MAIN]), name="page at main")
        hearing = asyncio.create_task(self._hear_page(receive), name="hear a joined page")
        over = asyncio.create_task(self._over.wait())
        try:
            await asyncio.wait({main, over}, return_when=asyncio.FIRST_COMPLETED)
            self._writer.end()
            error = main.exception() if main.done() and not main.cancelled() else None
            # A main shard that breaks off begins anew elsewhere, and so does the page.
            if self._main.accepted and isinstance(error, OSError):
                self._code, error = _RESTARTS, None
            # At once: what is at shards may take a moment to end.
            if self._code is not None and self._main.accepted:
                await self._writer.close(self._code)
        finally:
            self._over.set()
            await self._end_all(main, hearing, over)
        if error is not None:
            raise error

    async def _end_all(self, main: asyncio.Task[None], *own: asyncio.Task[object]) -> None:
        """End what is at shards: by the word that the page has gone, or else by force."""
        for task in own:
            task.cancel()
        self._asked.close()
        for socket in (self._main, *self._open.values()):
            socket.hang_up(self._gone_code)
        for shard, task in self._keeping.items():
            # Those that are not let in yet may be held for long.
            if shard not in self._open:
                task.cancel()
        serving = {main, *self._keeping.values()}
        try:
            await asyncio.wait(serving, timeout=_ENDING_S)
        finally:
            for task in serving:
                task.cancel()
            await asyncio.gather(*serving, *own, return_exceptions=True)

    def _scope_of(self, shard: str) -> Scope:
        """Give a shard's socket what the page's own has."""
        extensions = dict(self._scope.get("extensions", {}))
        for name in [name for name in extensions if name.startswith("talaia.")]:
            del extensions[name]
        if self._writer.writes_frames:
            write = self._write_main if shard == MAIN else self._make_write(shard)
            extensions[FRAME_WRITER] = {"write": write}
        state = dict(self._scope.get("state", {}))
        return {**self._scope, "extensions": extensions, "state": state}

    # ── what the page says ──

    async def _hear_page(self, receive: Receive) -> None:
        try:
            while True:
                message = await receive()
                if message["type"] == "websocket.disconnect":
                    self._gone_code = message.get("code", 1001)
                    break
                self._take(message)
        finally:
            self._over.set()

    def _take(self, message: Message) -> None:
        """Lead what a page says to its shard; never waits."""
        data = data_of(message)
        asked = read_asked(data)
        if asked is None or not (asked.site or asked.sub >= 0 or asked.t == "ping"):
            # It answers what cannot be read, too.
            self._push(self._main, message)
        elif asked.t == "ping":
            # A session is kept by whoever touches the page, whichever site it shows.
            for socket in (self._main, *self._open.values()):
                self._push(socket, message)
        else:
            self._asked.lead(asked, message, self._join.known.shards.get(asked.site))

    def _hand_up(self, asked: AskedAbout, message: Message, shard: str) -> None:
        """Hand on what a page says of a site of ``shard``, or of a subscription."""
        shard = shard if shard in self._join.apps else MAIN
        if asked.t == "unsubscribe":
            shard = self._subscriptions.remove(asked.sub)
        elif asked.t == "subscribe":
            before = self._subscriptions.add(asked.sub, shard, message)
            # The number is another shard's from now on.
            if before is not None and (former := self._socket_at(before)) is not None:
                self._push(former, end_message(asked.sub, message))
            if self._subscriptions.is_full:
                self._drop()
        socket = self._socket_at(shard)
        if socket is not None:
            self._push(socket, message)
        elif asked.t not in _UNANSWERED:
            self._writer.add_note(RequestError(code="offline", message=_AWAY, about=asked.t))

    def _socket_at(self, shard: str) -> ShardSocket | None:
        return self._main if shard == MAIN else self._open.get(shard)

    def _push(self, socket: ShardSocket, message: Message) -> None:
        if not socket.push(message, len(data_of(message))):
            _LOG.warning("shard %s does not hear what a page says", socket.shard)

    def _drop(self) -> None:
        """Let the page come again: too much waits that it has said."""
        self._end(_RESTARTS)

    # ── what shards say ──

    async def _hear_main(self, _socket: ShardSocket, message: Message) -> None:
        kind = message["type"]
        if kind == "websocket.close":
            self._writer.end()
            await self._writer.send_last(message)
        elif kind != "websocket.send":
            await self._writer.send(message)
        elif self._news.passes(MAIN, data_of(message)):
            await self._writer.send(message)
            self._begin_others()

    def _write_main(self, frame: SocketFrame) -> bool:
        if not self._news.passes(MAIN, frame.data):
            return True
        written = self._writer.write(frame)
        if written and not self._begun:
            self._begin_others()
        return written

    def _begin_others(self) -> None:
        """Open a socket at each other shard, once the page has been greeted."""
        if self._begun:
            return
        self._begun = True
        for shard in self._join.apps:
            if shard != MAIN:
                keeping = self._keep_shard(shard)
                self._keeping[shard] = asyncio.create_task(keeping, name=f"page at {shard}")

    async def _keep_shard(self, shard: str) -> None:
        """Have a socket at a shard for as long as the page is there."""
        told = False
        while not self._over.is_set():
            socket = ShardSocket(shard, self._scope_of(shard), self._hear_shard)
            try:
                await socket.run(self._join.apps[shard])
            except OSError as error:
                _LOG.debug("shard %s: %s", shard, error)
            except Exception:  # noqa: BLE001 - a shard must not take the page's others with it
                _LOG.exception("a page's socket at shard %s failed", shard)
            was_open = self._open.pop(shard, None) is not None
            if self._over.is_set():
                return
            code = socket.close_code
            if was_open and code is not None and code not in _BROKEN:
                # Its word is for the page: the session is over, or what it said breaks the rules.
                self._end(code)
                return
            if was_open or not told:
                told = True
                await self._tell_away(shard)
            pause = 0.5 + random.random()  # noqa: S311 - no secret
            await asyncio.sleep(pause * self._join.retry_s)

    async def _hear_shard(self, socket: ShardSocket, message: Message) -> None:
        kind = message["type"]
        if kind == "websocket.accept":
            self._open[socket.shard] = socket
            if not self._subscriptions.complete:
                # What it had asked for was more than is remembered: it asks for all of it anew.
                self._end(_RESTARTS)
            for asked in self._subscriptions.of_shard(socket.shard):
                self._push(socket, asked)
        elif kind == "websocket.send" and self._news.passes(socket.shard, data_of(message)):
            await self._writer.send(message)

    def _make_write(self, shard: str) -> Callable[[SocketFrame], bool]:
        def write_frame(frame: SocketFrame) -> bool:
            return not self._news.passes(shard, frame.data) or self._writer.write(frame)

        return write_frame

    async def _tell_away(self, shard: str) -> None:
        """Tell the page that nothing is known now of a shard's sites."""
        now_us = self._join.clock.wall_ns() // 1000
        for number, (site, catalogue) in enumerate(self._news.sites_of(shard), 1):
            away = SiteUpdate(
                site=site,
                online=False,
                since_us=now_us,
                catalogue=catalogue,
                why=_AWAY,
                away=True,
            )
            await self._writer.send_message(away)
            if number % _AT_ONCE == 0:
                # Whoever drives is served between them.
                await asyncio.sleep(0)

    def _end(self, code: int) -> None:
        """Send the page away."""
        if not self._over.is_set():
            self._code = code
            self._over.set()
