"""The link and the media connection: one socket each, from handshake to loss.

What is sent comes from elsewhere (`SendLanes`, `PictureUplink`), and so does what received messages
mean (`HubMessageHandler`); here frames only pass, beats are kept, and a loss becomes one `LinkLost`
with a reason.

Long, because both sockets are dialled, kept and lost in the same way, told in one place.
"""

from __future__ import annotations

import asyncio
import logging
from contextlib import asynccontextmanager
from functools import partial
from http import HTTPStatus
from typing import TYPE_CHECKING, Protocol

from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus, WebSocketException

from talaia.gateway.errors import KeyRefused, LinkLost, RetryLater
from talaia.gateway.uplink.dialling import first_to_end
from talaia.gateway.uplink.heartbeat import HeartbeatMonitor, reply_to
from talaia.wire.errors import PeerError, UnknownKind
from talaia.wire.frames import (
    LINK_FROM_GATEWAY,
    LINK_FROM_HUB,
    MEDIA_FROM_GATEWAY,
    MEDIA_FROM_HUB,
    Beat,
    BeatReply,
    Bye,
    Hello,
    LinkHeld,
    StopRequest,
    StopState,
    Welcome,
)
from talaia.wire.message import PROTOCOL, is_compatible

if TYPE_CHECKING:
    import ssl
    from collections.abc import AsyncIterator, Callable

    from websockets.asyncio.client import ClientConnection

    from talaia.clock import Clock
    from talaia.gateway.uplink.key_prover import KeyProver
    from talaia.gateway.uplink.pictures import PictureUplink
    from talaia.gateway.uplink.send_lanes import SendLanes
    from talaia.gateway.uplink.tls import HubTrust
    from talaia.wire.frames import FromHub

__all__ = ["HubLink", "HubMessageHandler", "dial", "run_media"]

log = logging.getLogger(__name__)
# Long enough for a hub under load, short enough that a robot is not left with a dead dial.
HANDSHAKE_S = 5.0
# Small, so that what waits is in our lanes, where importance counts, and not in the socket.
WRITE_LIMIT = 32 * 1024
# Dials of which the last one is refused, before a key counts as void.
_DIALS = 4


class HubMessageHandler(Protocol):
    """Where the hub's messages are acted on. Returns at once; raises nothing."""

    def link_up(self, welcome: Welcome) -> None:
        """The hub has answered."""
        ...

    def link_lost(self) -> None:
        """The link is gone; also called when it never stood."""
        ...

    def handle(self, message: FromHub) -> None:
        """Act on one message."""
        ...


@asynccontextmanager
async def dial(trust: HubTrust, prover: KeyProver, path: str) -> AsyncIterator[ClientConnection]:
    """Open a WebSocket to the hub; a loss inside the block becomes `LinkLost`.

    Raises:
        LinkLost: the hub cannot be reached or went away.
        KeyRefused: it does not know our key.

    """
    hub = trust.url
    url = hub + path
    socket: ClientConnection | None = None
    try:
        # Twice the handshake: name lookup, TCP and TLS come before the WebSocket's own.
        async with asyncio.timeout(2 * HANDSHAKE_S):
            socket = await _connect(url, await trust.context(), prover, path)
        yield socket
    except LinkLost:
        # It ends, or is not well: of several hubs another one goes on.
        trust.turn_away(hub)
        raise
    except InvalidStatus as error:
        # The key itself is refused; dialling soon again cannot help.
        if error.response.status_code in (401, 403):
            raise KeyRefused(error.response.status_code, hub) from error
        trust.turn_away(hub)
        # 429 and 503: there is a hub, and it has no room now.
        if error.response.status_code in (429, 503):
            after_s = _seconds(error.response.headers.get("Retry-After", ""))
            raise RetryLater(f"{url} answers HTTP {error.response.status_code}", after_s) from error
        raise LinkLost(f"{url} answers HTTP {error.response.status_code}") from error
    except ConnectionClosed as error:
        trust.turn_away(hub)
        reason = error.rcvd.reason if error.rcvd is not None and error.rcvd.reason else str(error)
        raise LinkLost(f"the hub closed the link: {reason}") from error
    except PeerError as error:
        if socket is not None:
            await socket.close(error.code, error.problem[:100])
        raise LinkLost(f"the hub sent {error.problem}") from error
    except (OSError, TimeoutError, WebSocketException) as error:
        # The certificate may have been renewed: look at it again before the next dial.
        trust.forget()
        trust.turn_away(hub)
        raise LinkLost(f"{url} cannot be reached: {str(error) or type(error).__name__}") from error
    finally:
        if socket is not None:
            await _close(socket)


async def _connect(
    url: str, context: ssl.SSLContext | None, prover: KeyProver, path: str
) -> ClientConnection:
    # The first dial may only ask for the hub's number, and the next one answers it. Where another
    # hub takes over meanwhile it does not know that number, and tells one of its own.
    for again in range(_DIALS - 1, -1, -1):
        try:
            socket = await connect(
                url,
                ssl=context,
                # Batches are packed columns already; compressing again costs more than it saves.
                compression=None,
                # Beats of our own, see `HeartbeatMonitor`: they show that the hub's program
                # answers, not only its socket.
                ping_interval=None,
                open_timeout=HANDSHAKE_S,
                close_timeout=1,
                max_size=LINK_FROM_HUB.max_frame,
                write_limit=WRITE_LIMIT,
                # Sent inside TLS only after the hub has proved itself, see `HubTrust`.
                additional_headers={"Authorization": prover.make_header(path)},
                # Tells nobody which Python and which library run beside a robot.
                user_agent_header=None,
                # No proxy from the environment: a robot's link goes where its settings say.
                proxy=None,
            )
        except InvalidStatus as error:
            refused = error.response.status_code == HTTPStatus.UNAUTHORIZED
            if not (refused and prover.hear_refusal(error.response.headers) and again):
                raise
            continue
        if socket.response is not None:
            prover.hear_welcome(socket.response.headers)
        return socket
    raise AssertionError("the last dial is returned or raised")


def _seconds(text: str) -> float:
    """Read ``Retry-After``; 0 for a date, or nonsense."""
    return float(text) if text.isascii() and text.isdigit() and len(text) < 6 else 0.0


async def _close(socket: ClientConnection) -> None:
    """Say good-bye, but never wait long for a peer that is gone."""
    try:
        async with asyncio.timeout(0.5):
            await socket.close()
    except (TimeoutError, OSError, WebSocketException):
        pass
    finally:
        # Whatever the closing did, the descriptor is free.
        socket.transport.abort()


def _write_at_once(socket: ClientConnection, data: bytes) -> bool:
    """Send a message in one frame, unless the socket is full or lost; see `SendLanes.link_up`.

    What `ClientConnection.send` does, without what it needs for messages that come in parts and for
    waiting: that costs three times as much as the frame itself.
    """
    if socket.paused or socket.transport.is_closing():
        return False
    try:
        socket.protocol.send_binary(data)
        socket.send_data()
    # It closes, or was lost a moment ago; who reads and writes it finds that, too.
    except (OSError, RuntimeError, WebSocketException):
        return False
    return True


def _check_awake(beats: HeartbeatMonitor, clock: Clock) -> None:
    frozen = beats.stood_still_s(clock.monotonic_ns())
    # Not acted on: what waited in the socket through a freeze may be a driving frame of long ago.
    if frozen > 0:
        raise LinkLost(f"this process stood still for {frozen:.1f} s; starting clean")


async def _beat(
    socket_send: Callable[[Beat], None], beats: HeartbeatMonitor, clock: Clock, what: str
) -> None:
    while True:
        if beats.dead:
            raise LinkLost(f"{what} has not answered for {beats.MISSED} s")
        # Asked here and by the reader: whichever wakes first after a freeze ends the link.
        _check_awake(beats, clock)
        socket_send(beats.next(clock.monotonic_ns()))
        await asyncio.sleep(beats.PERIOD_S)


class HubLink:
    """The link, once: hello, welcome, then frames both ways until it is lost."""

    def __init__(
        self,
        *,
        trust: HubTrust,
        prover: KeyProver,
        clock: Clock,
        lanes: SendLanes,
        wake: asyncio.Event,
        handler: HubMessageHandler,
    ) -> None:
        """Take what to send and who acts on what comes."""
        self._trust = trust  # Where the hub is, and how it proves itself.
        self._prover = prover  # How we do.
        self._clock = clock  # Monotonic, for beats and freezes.
        self._lanes = lanes  # Everything that goes out.
        self._wake = wake  # Set by the lanes when they have something.
        self._handler = handler  # Acts on everything that comes in but beats and goodbyes.

    async def once(self, hello: Hello, beside: Callable[[Welcome], asyncio.Task[None]]) -> None:
        """Run one link to its end.

        Args:
            hello: first frame.
            beside: starts what runs beside the link (catching up); cancelled with it.

        Raises:
            LinkLost: always, with the reason.

        """
        try:
            # The hub may have been updated since the last link.
            self._prover.forget_hub()
            async with dial(self._trust, self._prover, "/gateway/link") as socket:
                beats = HeartbeatMonitor(self._clock.monotonic_ns())
                await socket.send(LINK_FROM_GATEWAY.encode(hello))
                welcome = await self._answer(socket, beats)
                if isinstance(welcome, LinkHeld):
                    log.warning("the hub lets this gateway wait: %s", welcome.reason)
                    welcome = await self._wait_place(socket)
                    beats = HeartbeatMonitor(self._clock.monotonic_ns())
                self._check(welcome)
                assert isinstance(welcome, Welcome)  # noqa: S101 - told to mypy; _check raised
                # Lanes before the handler, for it sends at once how things stand.
                self._lanes.link_up(partial(_write_at_once, socket))
                self._handler.link_up(welcome)
                log.info("linked to %s", self._trust.url)
                tasks = [
                    asyncio.ensure_future(self._read(socket, beats)),
                    asyncio.ensure_future(self._write(socket)),
                    asyncio.ensure_future(_beat(self._lanes.send, beats, self._clock, "the hub")),
                    # From here the link is as good as its slowest part: the first of these to end
                    # ends them all.
                    beside(welcome),
                ]
                await first_to_end(tasks)
        # Also when it never stood: both calls may be repeated, and the handler relies on it.
        finally:
            self._lanes.link_lost()
            self._handler.link_lost()

    async def _answer(self, socket: ClientConnection, beats: HeartbeatMonitor) -> FromHub:
        """Wait for the first frame. A slow hub is waited for; a freeze of ours ends the link."""

        async def pulse() -> None:
            while True:
                await asyncio.sleep(beats.PERIOD_S)
                beats.pulse(self._clock.monotonic_ns())

        pulsing = asyncio.ensure_future(pulse())
        try:
            async with asyncio.timeout(HANDSHAKE_S):
                data = await socket.recv()
        finally:
            pulsing.cancel()
        _check_awake(beats, self._clock)
        return LINK_FROM_HUB.decode(data)

    async def _wait_place(self, socket: ClientConnection) -> FromHub:
        """Wait while another gateway has our place; STOP is acted on, and nothing else."""
        # Of its own: what was asked before we waited counts no more.
        beats = HeartbeatMonitor(self._clock.monotonic_ns())
        # Said once each: a press is repeated, and who waits may say little.
        sent: dict[str, StopState] = {}
        self._lanes.held_stops = {}
        try:
            while True:
                async with asyncio.timeout(beats.MISSED * beats.PERIOD_S):
                    message = LINK_FROM_HUB.decode(await socket.recv())
                if not await self._handle_held(socket, message):
                    return message
                # Of a press at once, and that the robot stands still with the next beat.
                for device, state in self._lanes.held_stops.items():
                    if sent.get(device) != state:
                        await socket.send(LINK_FROM_GATEWAY.encode(state))
                sent |= self._lanes.held_stops
                self._lanes.held_stops.clear()
        finally:
            self._lanes.held_stops = None

    async def _handle_held(self, socket: ClientConnection, message: FromHub) -> bool:
        """Act on a message that comes while we wait; False: the wait is over by it."""
        match message:
            case Beat():
                reply = reply_to(message, self._clock.monotonic_ns())
                await socket.send(LINK_FROM_GATEWAY.encode(reply))
            case StopRequest():
                self._handler.handle(message)
            case LinkHeld():
                # Another one was quicker to the place.
                pass
            case _:
                return False
        return True

    def _check(self, welcome: FromHub) -> None:
        # A hub that refuses says so in the first frame.
        if isinstance(welcome, Bye):
            raise RetryLater(f"the hub refuses this gateway: {welcome.reason}", welcome.after_s)
        if not isinstance(welcome, Welcome):
            raise PeerError(f"{type(welcome).__name__} before the welcome")
        if not is_compatible(welcome.protocol):
            raise LinkLost(
                f"the hub speaks protocol {welcome.protocol}, this gateway {PROTOCOL}; "
                "bring both to the same version"
            )

    async def _read(self, socket: ClientConnection, beats: HeartbeatMonitor) -> None:
        while True:
            data = await socket.recv()
            try:
                message = LINK_FROM_HUB.decode(data)
            # A newer hub may say things that this version does not know; the link goes on.
            except UnknownKind as error:
                log.debug("the hub sent %s", error)
                continue
            _check_awake(beats, self._clock)
            now = self._clock.monotonic_ns()
            match message:
                case Beat():
                    self._lanes.send(reply_to(message, now))
                case BeatReply():
                    beats.answered(message, now)
                case Bye():
                    raise RetryLater(f"the hub closes the link: {message.reason}", message.after_s)
                case Welcome():
                    raise PeerError("a second welcome")
                case _:
                    self._handler.handle(message)

    async def _write(self, socket: ClientConnection) -> None:
        while True:
            data = self._lanes.next()
            if data is None:
                # Cleared before waiting and after the lanes were empty; nothing awaits in between,
                # so no wake is lost.
                self._wake.clear()
                await self._wake.wait()
            else:
                # Waits while the socket's buffer is full, so what is urgent can still overtake in
                # the lanes.
                await socket.send(data)


async def run_media(
    *,
    trust: HubTrust,
    prover: KeyProver,
    clock: Clock,
    pictures: PictureUplink,
    up: Callable[[], None],
) -> None:
    """Send pictures until the connection is lost; ``up`` is called once it stands.

    Raises:
        LinkLost: always, with the reason.

    """
    async with dial(trust, prover, "/gateway/media") as socket:
        beats = HeartbeatMonitor(clock.monotonic_ns())
        pictures.link_up()
        up()

        async def read() -> None:
            while True:
                message = MEDIA_FROM_HUB.decode(await socket.recv())
                now = clock.monotonic_ns()
                if isinstance(message, Beat):
                    pictures.enqueue_small(MEDIA_FROM_GATEWAY.encode(reply_to(message, now)))
                elif isinstance(message, BeatReply):
                    beats.answered(message, now)
                    pictures.answered(message)
                else:
                    raise LinkLost("the hub closes the media connection")

        async def write() -> None:
            while True:
                await socket.send(await pictures.next())

        def send_beat(beat: Beat) -> None:
            pictures.enqueue_small(MEDIA_FROM_GATEWAY.encode(beat))

        try:
            await first_to_end(
                [
                    asyncio.ensure_future(read()),
                    asyncio.ensure_future(write()),
                    asyncio.ensure_future(_beat(send_beat, beats, clock, "the hub's media side")),
                ]
            )
        finally:
            pictures.link_lost()
