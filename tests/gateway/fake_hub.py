"""A hub small enough to see through: it speaks `wire.frames`, stores in lists, and obeys the test.

It is a peer for the gateway's tests, not a model of the real one: it keeps what it got, acks what
it is told to ack, and its sockets can be cut at any moment.
"""

from __future__ import annotations

import asyncio
import hashlib
from collections import defaultdict
from contextlib import asynccontextmanager
from http import HTTPStatus
from typing import TYPE_CHECKING, TypeVar

from patience import PATIENCE_S
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from talaia.wire.columns import unpack_columns
from talaia.wire.frames import (
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    LINK_FROM_GATEWAY,
    LINK_FROM_HUB,
    MEDIA_FROM_GATEWAY,
    MEDIA_FROM_HUB,
    Ack,
    ArchiveOffer,
    Beat,
    BeatReply,
    ControlTick,
    DescriptionUpdate,
    DetectedBoxes,
    DeviceState,
    FileOffer,
    FilePiece,
    FileProgress,
    FilmOffer,
    Hello,
    LinkHeld,
    LogLine,
    ModelOverlay,
    PictureFrame,
    RobotGraph,
    RobotLogAck,
    RobotLogBatch,
    SampleBatch,
    SampleGap,
    TapError,
    TapMessage,
    TapSchema,
    TopicList,
    Welcome,
)
from talaia.wire.gateway_proof import challenge_words, is_key_of, read_proof

if TYPE_CHECKING:
    import ssl
    from collections.abc import AsyncIterator, Callable

    from websockets.http11 import Request, Response

    from talaia.wire.frames import FromGateway, FromHub

KEY = "test-key"
M = TypeVar("M")


class FakeHub:
    """See the module."""

    def __init__(self) -> None:  # noqa: D107
        self.url = ""
        self.hellos: list[Hello] = []
        self.messages: list[FromGateway] = []
        self.away: dict[str, str] = {}
        self.pictures: list[PictureFrame] = []
        self.boxes: list[DetectedBoxes] = []
        self.overlays: list[ModelOverlay] = []
        self.taps: list[TopicList | TapSchema | TapMessage | TapError | RobotGraph] = []
        self.media_bytes = 0
        self.media: list[ServerConnection] = []
        self.takes: list[str] = []
        self.samples: dict[str, dict[int, tuple[str, int, float | str]]] = defaultdict(dict)
        self.log: list[RobotLogBatch] = []
        self.doubles = 0
        self.old_batches = 0
        # Samples in each batch that was live, in order.
        self.batch_sizes: list[int] = []
        self.tick = -1
        self.acking = True
        self.answering = True
        self.key = KEY
        self.requests = 0
        # Older hubs ask for the key itself.
        self.asks_proof = True
        # What each dial said of who it is, with its path.
        self.said: list[tuple[str, str]] = []
        self._nonces: set[str] = set()
        # So many of its numbers it does not know again: another hub answers, as in a take-over.
        self.forgets = 0
        # Lets gateways wait; the test says when their turn has come.
        self.holds = False
        # Handed down with the welcome.
        self.resume = ""
        self.links: list[ServerConnection] = []
        self.offers: list[FileOffer | FilmOffer | ArchiveOffer] = []
        self.pieces = 0
        self.knows_pictures = True
        self.finds_damage = False
        self.files: dict[str, bytes] = {}
        # Cut the connection that brings files after so many pieces.
        self.cut_after = 10**9
        self._changed = asyncio.Event()
        self._boot = ""
        self._lists: dict[str, list[str]] = {}
        self.catalogue: Callable[[Hello], list[str]] = lambda _: []

    # ── what a test does ──

    async def send(self, message: FromHub) -> None:
        await self.links[-1].send(LINK_FROM_HUB.encode(message))

    def cut(self) -> None:
        """End the newest link as a lost cable does: no good-bye."""
        self.links[-1].transport.abort()

    async def until(self, holds: Callable[[], object], what: str) -> None:
        """Wait until something holds; it is asked after every frame that comes."""
        async with asyncio.timeout(PATIENCE_S):
            while not holds():
                self._changed.clear()
                try:
                    await asyncio.wait_for(self._changed.wait(), 0.05)
                except TimeoutError:
                    continue
            return
        raise AssertionError(what)

    def of(self, kind: type[M]) -> list[M]:
        return [each for each in self.messages if isinstance(each, kind)]

    async def next(self, kind: type[M], which: Callable[[M], bool] = lambda _: True) -> M:
        """Wait for a message that fits, give it, and forget it and all before it."""
        found: list[int] = []

        def there() -> bool:
            found[:] = [
                index
                for index, each in enumerate(self.messages)
                if isinstance(each, kind) and which(each)
            ]
            return bool(found)

        await self.until(there, f"a {kind.__name__} that fits")
        message = self.messages[found[0]]
        del self.messages[: found[0] + 1]
        assert isinstance(message, kind)
        return message

    def values(self, address: str) -> list[float | str]:
        """Give a channel's values of all boots in order of boot and sequence."""
        return [
            value
            for boot in sorted(self.samples)
            for _, (name, _, value) in sorted(self.samples[boot].items())
            if name == address
        ]

    def log_lines(self) -> list[LogLine]:
        """Lines of the robot's log in the order in which they were said, each once."""
        found = {
            (batch.boot, batch.first + place): line
            for batch in self.log
            for place, line in enumerate(batch.lines)
        }
        return [found[key] for key in sorted(found)]

    def below(self, boot: str) -> int:
        """One past the last sequence up to which nothing is missing."""
        count = 0
        have = self.samples[boot]
        lost = [each for each in self.of(SampleGap) if each.boot == boot]
        while count in have or any(gap.first <= count <= gap.last for gap in lost):
            count += 1
        return count

    # ── what the gateway meets ──

    def _admit(self, socket: ServerConnection, request: Request) -> Response | None:
        self.requests += 1
        self._changed.set()
        said = request.headers.get("Authorization", "")
        self.said.append((request.path, said))
        proof = read_proof(said)
        if not self.asks_proof or proof is None:
            if said == f"Bearer {self.key}":
                return None
            return socket.respond(HTTPStatus.UNAUTHORIZED, "who are you?\n")
        key_hash = hashlib.sha256(self.key.encode()).hexdigest()
        if proof.nonce in self._nonces and is_key_of(proof, key_hash, request.path):
            self._nonces.remove(proof.nonce)
            return None
        nonce = f"n{self.requests}"
        if self.forgets:
            self.forgets -= 1
        else:
            self._nonces.add(nonce)
        answer = socket.respond(HTTPStatus.UNAUTHORIZED, "who are you?\n")
        answer.headers["WWW-Authenticate"] = challenge_words(nonce)
        return answer

    async def _serve(self, socket: ServerConnection) -> None:
        assert socket.request is not None
        try:
            if socket.request.path == "/gateway/files":
                await self._take_files(socket)
            elif socket.request.path == "/gateway/media":
                await self._media(socket)
            else:
                await self._link(socket)
        except ConnectionClosed:
            pass

    async def _media(self, socket: ServerConnection) -> None:
        self.media.append(socket)
        async for data in socket:
            self.media_bytes += len(data)
            message = MEDIA_FROM_GATEWAY.decode(data)
            if isinstance(message, Beat):
                reply = BeatReply(n=message.n, mono_us=message.mono_us, peer_us=0)
                await socket.send(MEDIA_FROM_HUB.encode(reply))
            elif isinstance(message, PictureFrame):
                self.pictures.append(message)
            elif isinstance(message, DetectedBoxes):
                self.boxes.append(message)
            elif isinstance(message, ModelOverlay):
                self.overlays.append(message)
            elif isinstance(message, TopicList | TapSchema | TapMessage | TapError | RobotGraph):
                self.taps.append(message)
            self._changed.set()

    async def _take_files(self, socket: ServerConnection) -> None:
        pieces = 0
        async for data in socket:
            message = FILES_FROM_GATEWAY.decode(data)
            if isinstance(message, ArchiveOffer) and not self.knows_pictures:
                continue
            if not isinstance(message, FilePiece):
                self.offers.append(message)
                self.files.setdefault(message.id, b"")
            else:
                assert message.at == len(self.files[message.id])
                self.files[message.id] += message.data
                pieces += 1
                self.pieces += 1
            if pieces >= self.cut_after:
                self.cut_after = 10**9
                socket.transport.abort()
                return
            if self.finds_damage:
                self.files[message.id] = b""
            have, size = len(self.files[message.id]), self.offers[-1].size
            answer = FileProgress(id=message.id, have=have, done=have == size)
            await socket.send(FILES_FROM_HUB.encode(answer))
            self._changed.set()

    async def _link(self, socket: ServerConnection) -> None:
        hello = LINK_FROM_GATEWAY.decode(await socket.recv())
        assert isinstance(hello, Hello)
        self._boot = hello.boot
        self._lists[hello.catalogue] = self.catalogue(hello)
        welcome = Welcome(acked=self.below(hello.boot), takes=self.takes, resume=self.resume)
        first = LinkHeld(reason="another one is here") if self.holds else welcome
        await socket.send(LINK_FROM_HUB.encode(first))
        # A new link tells of the devices that are not reached, and of no others.
        self.away.clear()
        self.hellos.append(hello)
        self.links.append(socket)
        self._changed.set()
        async for data in socket:
            await self._take(socket, LINK_FROM_GATEWAY.decode(data))
            self._changed.set()

    async def _take(self, socket: ServerConnection, message: FromGateway) -> None:
        if isinstance(message, Beat):
            if self.answering:
                reply = BeatReply(n=message.n, mono_us=message.mono_us, peer_us=0)
                await socket.send(LINK_FROM_HUB.encode(reply))
        elif isinstance(message, SampleBatch):
            self._store(message)
            if self.acking:
                ack = Ack(boot=message.boot, below=self.below(message.boot))
                await socket.send(LINK_FROM_HUB.encode(ack))
        elif isinstance(message, DescriptionUpdate):
            self._lists[message.catalogue] = message.addresses
            self.messages.append(message)
        elif isinstance(message, DeviceState):
            self.away.pop(message.device, None)
            if not message.reached:
                self.away[message.device] = message.why
            self.messages.append(message)
        elif isinstance(message, ControlTick):
            self.tick = message.tick
        elif isinstance(message, RobotLogBatch):
            self.log.append(message)
            if self.acking:
                below = message.first + len(message.lines)
                await socket.send(LINK_FROM_HUB.encode(RobotLogAck(boot=message.boot, below=below)))
        else:
            self.messages.append(message)

    def _store(self, frame: SampleBatch) -> None:
        self.old_batches += not frame.live
        addresses = frame.addresses or self._lists[frame.catalogue]
        columns = unpack_columns(frame)
        have = self.samples[frame.boot]
        if frame.live:
            self.batch_sizes.append(len(columns))
        for index in range(len(columns)):
            sequence = frame.first + index
            value = columns.texts.get(index, float(columns.value[index]))
            row = (addresses[columns.channel[index]], int(columns.time_us[index]), value)
            if sequence in have:
                self.doubles += 1
                assert repr(have[sequence]) == repr(row), "one key, two samples"
            have[sequence] = row


@asynccontextmanager
async def fake_hub(
    catalogue: Callable[[Hello], list[str]], context: ssl.SSLContext | None = None, port: int = 0
) -> AsyncIterator[FakeHub]:
    hub = FakeHub()
    hub.catalogue = catalogue
    async with serve(
        hub._serve,
        "127.0.0.1",
        port,
        process_request=hub._admit,
        compression=None,
        ping_interval=None,
        ssl=context,
        max_size=16 * 1024 * 1024,
        close_timeout=0.2,
    ) as server:
        name = server.sockets[0].getsockname()
        hub.url = f"{'ws' if context is None else 'wss'}://127.0.0.1:{name[1]}"
        yield hub
