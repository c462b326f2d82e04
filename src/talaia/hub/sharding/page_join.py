"""A page's one socket, joined of one socket to each shard.

A page knows of no shards. What it says of a site goes to the shard that has the site, and what any
of them tells goes to the page, both as the bytes they are. The main shard lets it in and answers
its pings. Of a shard that is away the page hears that its sites are, and it is asked again until it
is back; so is the main one, for whoever was let in.

Long, because the life of one page stands in one place.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import random
from typing import TYPE_CHECKING

from talaia.clock import SystemClock
from talaia.hub.sharding.asked_sites import AskedSites
from talaia.hub.sharding.kept_pongs import KeptPongs
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
_BROKEN = frozenset({None, 1000, 1001, 1005, 1006, 1011, 1012, 1013})
# Of HTTP, by which the main shard says that nobody has this session any more.
_NOBODY = frozenset({401, 403})
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
        self._subscriptions = PageSubscriptions()
        self._news = PageNews(join.known, self._subscriptions, join.apps, site_came=self._lead_site)
        self._pongs = KeptPongs(join.clock)
        self._asked = AskedSites(join.shard_of, self._hand_up, limit_reached=self._drop)
        # By shard: has a socket there.
        self._keeping: dict[str, asyncio.Task[None]] = {}
        # The main shard has let the page in.
        self._admitted = False
        # The page has gone, or is sent away, and with which code (None: it went by itself).
        self._over = asyncio.Event()
        self._code: int | None = None
        self._gone_code = 1001

    async def serve(self, receive: Receive) -> None:
        # The wish to connect: each shard's socket has its own.
        await receive()
        hearing = asyncio.create_task(self._hear_page(receive), name="page-hearing")
        over = asyncio.create_task(self._over.wait())
        main = self._begin_shard(MAIN)
        try:
            # Each of the others ends only after this one has, or when all is over.
            await asyncio.wait({main, over}, return_when=asyncio.FIRST_COMPLETED)
            self._writer.end()
            if self._code is not None:
                # At once: what is at shards may take a moment to end.
                await self._writer.close(self._code)
        finally:
            self._over.set()
            await self._end_all(hearing, over)
        if main.done() and not main.cancelled() and (error := main.exception()) is not None:
            raise error

    async def _end_all(self, *own: asyncio.Task[object]) -> None:
        """End what is at shards: by the word that the page has gone, or else by force."""
        for task in own:
            task.cancel()
        self._asked.close()
        for socket in self._open.values():
            socket.hang_up(self._gone_code)
        for shard, task in self._keeping.items():
            # Those that are not let in yet may be held for long.
            if shard not in self._open:
                task.cancel()
        serving = self._keeping.values()
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
            extensions[FRAME_WRITER] = {"write": self._make_write(shard)}
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
                self._lead_message(message)
        finally:
            self._over.set()

    def _lead_message(self, message: Message) -> None:
        """Lead what a page says to its shard; never waits."""
        asked = read_asked(data_of(message))
        if asked is not None and asked.t == "ping":
            # A session is kept by whoever touches the page, whichever site it shows.
            for socket in self._open.values():
                self._push(socket, message)
            if MAIN not in self._open and (pong := self._pongs.answer_ping(message)) is not None:
                self._writer.add_note(pong)
        elif asked is not None and (asked.site or asked.sub >= 0):
            self._asked.lead(asked, message, self._join.known.shards.get(asked.site))
        elif (main := self._open.get(MAIN)) is not None:
            # It answers what cannot be read, too.
            self._push(main, message)

    def _hand_up(self, asked: AskedAbout, message: Message, shard: str) -> None:
        """Hand on what a page says of a site of ``shard``, or of a subscription."""
        # While it was looked up, it may have gone to another one, which has told of it.
        shard = self._join.known.shards.get(asked.site, shard)
        shard = shard if shard in self._join.apps else MAIN
        if asked.t == "unsubscribe":
            shard = self._subscriptions.remove(asked.sub)
        elif asked.t == "subscribe":
            before = self._subscriptions.add(asked.sub, shard, message)
            # The number is another shard's from now on.
            if before is not None and (former := self._open.get(before)) is not None:
                self._push(former, end_message(asked.sub, message))
            if self._subscriptions.is_full:
                self._drop()
        socket = self._open.get(shard)
        if socket is not None:
            self._push(socket, message)
        elif asked.t not in _UNANSWERED:
            self._writer.add_note(RequestError(code="offline", message=_AWAY, about=asked.t))

    def _push(self, socket: ShardSocket, message: Message) -> None:
        if not socket.push(message, len(data_of(message))):
            _LOG.warning("shard %s does not hear what a page says", socket.shard)

    def _drop(self) -> None:
        """Let the page come again: too much waits that it has said."""
        self._end(_RESTARTS)

    # ── what shards say ──

    def _begin_shard(self, shard: str) -> asyncio.Task[None]:
        task = asyncio.create_task(self._keep_shard(shard), name=f"page-{shard}")
        self._keeping[shard] = task
        return task

    async def _keep_shard(self, shard: str) -> None:
        """Have a socket at a shard for as long as the page is there."""
        told = False
        while not self._over.is_set():
            socket = ShardSocket(shard, self._scope_of(shard), self._hear_shard)
            await self._serve_socket(socket)
            was_open = self._open.pop(shard, None) is not None
            if self._over.is_set():
                return
            if not self._admitted:
                # It was denied, and has heard so.
                self._over.set()
            elif was_open and socket.close_code not in _BROKEN:
                # Its word is for the page: the session is over, or what it said breaks the rules.
                self._end(socket.close_code)
            elif shard == MAIN and socket.denied in _NOBODY:
                # As it comes again it hears why.
                self._end(_RESTARTS)
            else:
                if was_open or not told:
                    told = True
                    # A page that has gone is heard to have: that ends all of this.
                    with contextlib.suppress(OSError, RuntimeError):
                        await self._tell_away(shard)
                pause = 0.5 + random.random()  # noqa: S311 - no secret
                await asyncio.sleep(pause * self._join.retry_s)

    async def _serve_socket(self, socket: ShardSocket) -> None:
        """Serve a page's socket at a shard to its end, which is here whatever it is there."""
        try:
            await socket.run(self._join.apps[socket.shard])
        except Exception as error:
            if not self._admitted:
                # The caller knows what to say to somebody who is not in.
                raise
            if isinstance(error, OSError):
                _LOG.debug("shard %s: %s", socket.shard, error)
            else:
                _LOG.exception("a page's socket at shard %s failed", socket.shard)

    async def _hear_shard(self, socket: ShardSocket, message: Message) -> None:
        kind = message["type"]
        if kind == "websocket.accept":
            if not self._admitted:
                await self._writer.send(message)
                self._admitted = True
            self._open_shard(socket)
        elif not self._admitted:
            await self._writer.send(message)
        elif kind == "websocket.send" and self._news.passes(socket.shard, data_of(message)):
            await self._writer.send(message)
            self._note_passed(socket.shard, data_of(message))

    def _open_shard(self, socket: ShardSocket) -> None:
        """Ask a shard that has let the page in for all that is asked of it."""
        self._open[socket.shard] = socket
        if not self._subscriptions.complete:
            # It was more than is remembered: the page asks for all of it anew.
            self._end(_RESTARTS)
        for asked in self._subscriptions.of_shard(socket.shard):
            self._push(socket, asked)

    def _lead_site(self, site: str, shard: str) -> None:
        """Ask a shard that a site has come to for what is asked of that site."""
        for sub, asked in self._subscriptions.of_site(site):
            before = self._subscriptions.add(sub, shard, asked)
            if before is None:
                continue
            if (former := self._open.get(before)) is not None:
                self._push(former, end_message(sub, asked))
            if (socket := self._open.get(shard)) is not None:
                self._push(socket, asked)

    def _note_passed(self, shard: str, data: bytes | str) -> None:
        """Follow what the page was told."""
        if shard != MAIN:
            return
        if not self._news.greeted:
            self._news.greeted = True
            # Not before: the greeting is the first that a page hears.
            for other in self._join.apps:
                if other != MAIN:
                    self._begin_shard(other)
        self._pongs.hear(data)

    def _make_write(self, shard: str) -> Callable[[SocketFrame], bool]:
        def write_frame(frame: SocketFrame) -> bool:
            if not self._news.passes(shard, frame.data):
                return True
            written = self._writer.write(frame)
            if written:
                self._note_passed(shard, frame.data)
            return written

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

    def _end(self, code: int | None) -> None:
        """Send the page away."""
        if not self._over.is_set():
            self._code = code
            self._over.set()
