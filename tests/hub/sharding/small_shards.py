"""Small applications in place of shards, and a page that speaks to whatever joins them."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio

from patience import PATIENCE_S

from talaia.wire.browser import FROM_BROWSER, TO_BROWSER, Greeting
from talaia.wire.errors import PeerError
from talaia.wire.socket_frame import FRAME_WRITER, SocketFrame


class News:
    """Things that come, one by one, to be waited for."""

    def __init__(self) -> None:
        self.all = []
        self._condition = asyncio.Condition()

    async def add(self, thing) -> None:
        async with self._condition:
            self.all.append(thing)
            self._condition.notify_all()

    async def take(self, fits=lambda _: True):
        """Wait for one that fits; it is taken out."""
        async with asyncio.timeout(PATIENCE_S), self._condition:
            while True:
                for thing in self.all:
                    if fits(thing):
                        self.all.remove(thing)
                        return thing
                await self._condition.wait()


class ShardEnd:
    """The application's end of one socket."""

    def __init__(self, scope, send, *, text: bool) -> None:
        self.scope = scope
        self.heard = News()
        # What is no message at all, as it came.
        self.unread = News()
        self.left = asyncio.Event()
        self._send = send
        self._text = text
        self._error = None
        self._ends = asyncio.Event()

    async def accept(self) -> None:
        await self._send({"type": "websocket.accept"})

    async def say(self, message) -> None:
        """Tell the page something, as ASGI has it."""
        if self._text:
            await self._send({"type": "websocket.send", "text": TO_BROWSER.encode_text(message)})
        else:
            await self._send({"type": "websocket.send", "bytes": TO_BROWSER.encode(message)})

    def write(self, frame: SocketFrame) -> bool:
        """Write a frame that others get, too."""
        return self.scope["extensions"][FRAME_WRITER]["write"](frame)

    async def close(self, code: int) -> None:
        await self._send({"type": "websocket.close", "code": code})
        self._ends.set()

    def break_off(self, error: Exception | None = None) -> None:
        """End without a word, or fail."""
        self._error = error
        self._ends.set()

    async def serve(self, receive) -> None:
        hearing = asyncio.create_task(self._hear(receive))
        await self._ends.wait()
        hearing.cancel()
        if self._error is not None:
            raise self._error

    async def _hear(self, receive) -> None:
        while (event := await receive())["type"] != "websocket.disconnect":
            data = event.get("bytes")
            data = event["text"] if data is None else data
            try:
                await self.heard.add(FROM_BROWSER.decode(data))
            except PeerError:
                await self.unread.add(data)
        self.left.set()
        self._ends.set()


class SmallShard:
    """The application of one shard: it lets a page in, or not, and says what a test says."""

    def __init__(self, name: str) -> None:
        self.name = name
        # Raised instead of anything; or the HTTP status with which pages are sent away.
        self.error = None
        self.denies = 0
        # Pages are held before they are let in.
        self.opens = asyncio.Event()
        self.opens.set()
        # It greets by a frame that is written at once.
        self.writes_greeting = False
        self.asked = 0
        self.ends = News()

    async def __call__(self, scope, receive, send) -> None:
        self.asked += 1
        if self.error is not None:
            raise self.error
        assert (await receive())["type"] == "websocket.connect"
        if self.denies:
            start = {"status": self.denies, "headers": [(b"retry-after", b"1")]}
            await send({"type": "websocket.http.response.start", **start})
            await send({"type": "websocket.http.response.body", "body": b"no"})
            return
        await self.opens.wait()
        end = ShardEnd(scope, send, text=b"form=json" in scope["query_string"])
        await end.accept()
        greeting = Greeting(who=f"ada at {self.name}", role="operator", time_us=1)
        if self.writes_greeting:
            assert end.write(SocketFrame(TO_BROWSER.encode(greeting)))
        else:
            await end.say(greeting)
        await self.ends.add(end)
        await end.serve(receive)

    async def end(self) -> ShardEnd:
        """Wait for a page; give the application's end of its socket."""
        return await self.ends.take()


class SmallPage:
    """A page, and the server before the hub."""

    def __init__(self, join, *, text: bool = False, writes: bool = True) -> None:
        self.text = text
        self.heard = News()
        self.answer = News()
        self.events = []
        # Taken away to be a page that does not read.
        self.reads = asyncio.Event()
        self.reads.set()
        self.written = 0
        # Raised whenever it is sent something: it has gone, and nobody knows it yet.
        self.error = None
        self._says: asyncio.Queue = asyncio.Queue()
        self._says.put_nowait({"type": "websocket.connect"})
        extensions = {FRAME_WRITER: {"write": self._write}} if writes else {}
        self.scope = {
            "type": "websocket",
            "path": "/ws",
            "query_string": b"form=json" if text else b"",
            "headers": [(b"cookie", b"talaia=secret")],
            "extensions": {**extensions, "websocket.http.response": {}, "talaia.message_taker": 1},
        }
        self.serving = asyncio.create_task(join.serve(self.scope, self._says.get, self._take))

    def say(self, message) -> None:
        if self.text:
            event = {"text": FROM_BROWSER.encode_text(message)}
        else:
            event = {"bytes": FROM_BROWSER.encode(message)}
        self.say_data(event)

    def say_data(self, event) -> None:
        self._says.put_nowait({"type": "websocket.receive", **event})

    async def hear(self, kind, where=lambda _: True):
        return await self.heard.take(lambda said: isinstance(said, kind) and where(said))

    async def closed(self) -> int:
        return (await self.answer.take(lambda said: said["type"] == "websocket.close"))["code"]

    async def leave(self) -> None:
        self._says.put_nowait({"type": "websocket.disconnect", "code": 1001})
        async with asyncio.timeout(PATIENCE_S):
            await self.serving

    async def _take(self, message) -> None:
        await self.reads.wait()
        if self.error is not None:
            raise self.error
        if message["type"] == "websocket.send":
            data = message.get("bytes")
            assert (data is None) == self.text
            await self.heard.add(TO_BROWSER.decode(message["text"] if data is None else data))
        else:
            await self.answer.add(message)

    def _write(self, frame: SocketFrame) -> bool:
        if not self.reads.is_set():
            return False
        self.written += 1
        self.heard.all.append(TO_BROWSER.decode(frame.data))
        return True
