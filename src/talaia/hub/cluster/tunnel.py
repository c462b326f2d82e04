"""One request that is asked at one hub and answered by another: its messages, both ways.

A request is what ASGI calls one: an HTTP request, or a WebSocket for as long as it stands. Its
messages go as they are. A message that is lost leaves a hole in the numbers, and then the whole
tunnel ends, at both ends: whoever is at it connects again and is told anew how things stand.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec

from talaia.hub.cluster.frames import FrameKind, SequenceCheck, TunnelFrame, cut_pieces
from talaia.hub.cluster.window import CreditWindow, TakenCount

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.hub.cluster.bus import BusLane
    from talaia.hub.cluster.shared_frames import SharedFrames
    from talaia.wire.socket_frame import SocketFrame

    # As ASGI has it.
    AsgiMessage = dict[str, Any]

__all__ = ["TunnelBroken", "TunnelEnd", "TunnelName", "window_of"]

# Bytes under way. Of a page's socket few: what does not go out yet is to be thinned, not to wait.
_SOCKET_WINDOW = 64 * 1024
_HTTP_WINDOW = 512 * 1024
# A message whose pieces are put together here is no longer than this (bytes).
_LONGEST = 64 * 1024 * 1024
# A frame that is shared is no longer than this (bytes): what is larger goes in pieces.
_LONGEST_SHARED = 64 * 1024
_NUMBER = msgspec.msgpack.Decoder(int)
_MESSAGE = msgspec.msgpack.Decoder(dict[str, Any])


class TunnelBroken(ConnectionError):
    """The other end is gone, or something was lost on the way."""


class TunnelName(NamedTuple):
    """Which tunnel: by the other hub, and the number that the opening hub gave it."""

    hub: str
    number: int


def window_of(kind: str) -> int:
    """Give how many bytes may be under way of a request of this ASGI type."""
    return _SOCKET_WINDOW if kind == "websocket" else _HTTP_WINDOW


class TunnelEnd:
    """One end of a tunnel; the other one is just like it.

    Attributes:
        name: which it is.
        lane: by which its frames go.
        kind: the request's ASGI type.

    """

    def __init__(
        self,
        name: TunnelName,
        lane: BusLane,
        kind: str,
        *,
        post: Callable[[TunnelName, BusLane, TunnelFrame], Awaitable[None]],
        shared: SharedFrames | None = None,
        write: Callable[[SocketFrame], bool] | None = None,
    ) -> None:
        """Send frames by ``post``, and those that many sockets get by ``shared``, if there is one.

        ``write`` writes such a frame to this end's own socket at once, or gives False.
        """
        self.name, self.lane, self.kind = name, lane, kind
        self._post = post
        self._shared = shared
        self._write = write
        # Frames of this tunnel may wait in ``shared``: the next one goes behind them.
        self._shares = False
        self._sent = 0
        self._check = SequenceCheck()
        self._window = CreditWindow(window_of(kind))
        self._taken = TakenCount(window_of(kind))
        # Set when there is room to send, or the end.
        self._room = asyncio.Event()
        self._room.set()
        # Pieces of one message follow each other.
        self._turn = asyncio.Lock()
        # What has come and was not read, with its size; and the pieces of what is not whole yet.
        self._come: deque[tuple[AsgiMessage, int]] = deque()
        # What was read last may not be handed on yet.
        self._handing = False
        self._telling: set[asyncio.Task[None]] = set()
        self._pieces: list[bytes] = []
        self._news = asyncio.Event()
        # Why nothing more comes; empty: a good end. None: it goes on.
        self._over: str | None = None
        self._ended = False
        # The end was the other one's word.
        self._other_ended = False

    @property
    def over(self) -> str | None:
        """Why nothing more comes; empty after a good end, None while it goes on."""
        return self._over

    async def send_open(self, about: AsgiMessage) -> None:
        """Begin: say what the request is about.

        Raises:
            TunnelBroken: it cannot be sent.

        """
        await self._send_frame(FrameKind.OPEN, msgspec.msgpack.encode(about))

    async def send_message(self, message: AsgiMessage) -> None:
        """Send one message; returns when there is room for another.

        Raises:
            TunnelBroken: the other end is gone.

        """
        data = msgspec.msgpack.encode(message)
        async with self._turn:
            # Before, not after: what is sent now is the newest there is.
            while not self._window.has_room and self._over is None:
                self._room.clear()
                await self._room.wait()
            for kind, piece in cut_pieces(data):
                self._window.spend_bytes(len(piece))
                await self._send_frame(kind, piece)

    def write_shared(self, frame: SocketFrame) -> bool:
        """Send a frame that other sockets get, too; never waits.

        False: nothing is sent, since something stands before it or it is too long. It is then to
        be sent by `send_message`.
        """
        if (
            self._shared is None
            or self._over is not None
            or self._turn.locked()
            or not self._window.has_room
            or len(frame) > _LONGEST_SHARED
        ):
            return False
        self._window.spend_bytes(len(frame))
        self._shared.add_taker(self, self._sent, frame)
        self._sent += 1
        self._shares = True
        return True

    def receive_shared(self, sequence: int, frame: SocketFrame) -> None:
        """Take a frame that other sockets get, too: at once, if nothing stands before it."""
        if self._over is not None:
            return
        if not self._check.accept_number(sequence):
            self.break_off("something was lost between two hubs")
            return
        if not (self._come or self._handing) and self._write is not None and self._write(frame):
            self._count_taken(len(frame))
            return
        word = "text" if isinstance(frame.data, str) else "bytes"
        self._come.append(({"type": "websocket.send", word: frame.data}, len(frame)))
        self._news.set()

    async def receive_message(self) -> AsgiMessage | None:
        """Give the next message; None at the end."""
        self._handing = False
        while not self._come:
            if self._over is not None:
                return None
            self._news.clear()
            await self._news.wait()
        message, size = self._come.popleft()
        self._handing = True
        told = self._taken.add_taken(size)
        if told and self._over is None:
            await self._send_frame(FrameKind.CREDIT, msgspec.msgpack.encode(told))
        return message

    async def end_tunnel(self, reason: str = "") -> None:
        """Say that nothing more comes; whatever fails here, the other end finds out."""
        if self._ended:
            return
        self._ended = True
        said = reason or self._over or ""
        self._finish(reason)
        # What was broken off at this end stands at the other one: without a word it would wait
        # there for ever, for neither end need have anything to say.
        if not self._other_ended:
            with contextlib.suppress(TunnelBroken):
                await self._post_frame(FrameKind.END, said.encode())

    def receive_frame(self, frame: TunnelFrame) -> None:
        """Take a frame from the other end."""
        if self._over is not None:
            return
        if not self._check.accept_number(frame.sequence):
            self.break_off("something was lost between two hubs")
            return
        match frame.kind:
            case FrameKind.PIECE | FrameKind.LAST:
                self._add_piece(frame)
            case FrameKind.CREDIT:
                try:
                    self._window.earn_bytes(_NUMBER.decode(frame.payload))
                except msgspec.DecodeError:
                    self.break_off("another hub sent nonsense")
                self._room.set()
            case FrameKind.END:
                self._other_ended = True
                self._finish(frame.payload.decode(errors="replace"))
            # One was opened already, and the others are told apart before.
            case FrameKind.OPEN | FrameKind.NOTICE | FrameKind.SHARED:
                pass

    def break_off(self, reason: str) -> None:
        """End it here: nothing that is under way counts any more."""
        self._come.clear()
        self._finish(reason or "broken off")

    def _count_taken(self, size: int) -> None:
        told = self._taken.add_taken(size)
        if told:
            telling = asyncio.create_task(self._tell_taken(told))
            self._telling.add(telling)
            telling.add_done_callback(self._telling.discard)

    async def _tell_taken(self, size: int) -> None:
        # Where it cannot be told, the tunnel is over.
        with contextlib.suppress(TunnelBroken):
            await self._send_frame(FrameKind.CREDIT, msgspec.msgpack.encode(size))

    def _add_piece(self, frame: TunnelFrame) -> None:
        self._pieces.append(frame.payload)
        size = sum(map(len, self._pieces)) if len(self._pieces) > 1 else len(frame.payload)
        if size > _LONGEST:
            self.break_off("a message of another hub is too long")
        if frame.kind is not FrameKind.LAST or self._over is not None:
            return
        data = self._pieces[0] if len(self._pieces) == 1 else b"".join(self._pieces)
        self._pieces.clear()
        try:
            self._come.append((_MESSAGE.decode(data), len(data)))
        except msgspec.DecodeError:
            self.break_off("another hub sent nonsense")
        self._news.set()

    def _finish(self, reason: str) -> None:
        if self._over is None:
            self._over = reason
        self._news.set()
        self._room.set()

    async def _send_frame(self, kind: FrameKind, payload: bytes) -> None:
        if self._over is not None:
            raise TunnelBroken(self._over or "the other end has ended it")
        await self._post_frame(kind, payload)

    async def _post_frame(self, kind: FrameKind, payload: bytes) -> None:
        # Again and again: more may be written while that is posted.
        while self._shares and self._shared is not None:
            self._shares = False
            await self._shared.post_waiting(self)
        frame = TunnelFrame(kind, self.name.number, self._sent, payload)
        self._sent += 1
        try:
            await self._post(self.name, self.lane, frame)
        except OSError as error:
            self.break_off(str(error))
            raise TunnelBroken(str(error)) from error
