"""One Foxglove client that plays a window of the past: signals as they are in the history."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from typing import TYPE_CHECKING

from talaia import __version__
from talaia.clock import SECOND
from talaia.first_completed import until_first
from talaia.hub.auth.tokens import new_token
from talaia.hub.clients.foxglove.advertised import AdvertisedThings
from talaia.hub.clients.foxglove.offer import make_foxglove_offer
from talaia.hub.clients.foxglove.playback_position import PlaybackPosition
from talaia.hub.clients.foxglove.playback_reader import PlaybackReader
from talaia.hub.clients.foxglove.signal_channels import SignalChannels
from talaia.hub.history.errors import HistoryError
from talaia.wire.browser import RequestError, SessionEnded, SiteUpdate
from talaia.wire.errors import UnknownKind
from talaia.wire.foxglove import client_messages as said
from talaia.wire.foxglove.codec import (
    PlaybackStatus,
    decode_client,
    encode_message_data,
    encode_playback_state,
    encode_server,
    encode_time,
)
from talaia.wire.foxglove.server_messages import FoxgloveTime, ServerInfo, ServerStatus

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from starlette.websockets import WebSocket

    from talaia.clock import Clock
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.foxglove.offer import SignalChannel
    from talaia.hub.clients.foxglove.playback_position import PlaybackWindow
    from talaia.hub.clients.signal_subscriptions import ClientSample
    from talaia.hub.ports import History
    from talaia.wire.browser import ToBrowser

__all__ = ["PlaybackSession"]

_CAPABILITIES = ["playbackControl", "time"]
_WARNING, _ERROR = 1, 2
# So much is read at a time: what is played in a second.
_READ_US = 1_000_000
# Between two looks at what is due (s).
_STEP_S = 0.05
# A reader that is later than this goes on from where it is, instead of hurrying after (µs).
_LATE_US = 1_000_000
_PAST = "the past is played on this connection: nothing can be published, called or set"


class PlaybackSession:
    """See `ClientSession`."""

    def __init__(
        self,
        socket: WebSocket,
        connection: ClientConnection,
        *,
        window: PlaybackWindow | str,
        history: History,
        clock: Clock,
    ) -> None:
        """Play ``window`` from ``history``; a text says why there is none."""
        self._socket = socket
        self._connection = connection
        self._clock = clock
        self._site = connection.live.name
        self._past = PlaybackReader(history, self._site)
        self._problem = window if isinstance(window, str) else ""
        self._position = None if isinstance(window, str) else PlaybackPosition(window)
        self._things = AdvertisedThings()
        self._signals = SignalChannels(self._site, wants=self._things.has_subscription)
        # Up to here all has been sent (µs).
        self._sent_us = 0
        # Something about playing has changed, so what was read ahead is void.
        self._changed = asyncio.Event()
        # Of the description that is advertised.
        self._edition = ""

    async def read_client(self) -> None:
        """Say which window there is, then read until the client has gone."""
        if self._position is None:
            await self._send_status(_ERROR, self._problem)
            return
        window = self._position.window
        self._sent_us = window.from_us - 1
        name = f"Talaia {__version__}: {self._connection.description.name}, past"
        info = ServerInfo(
            name=name,
            capabilities=_CAPABILITIES,
            metadata={"site": self._site},
            session_id=new_token(),
            data_start_time=_time_of(window.from_us),
            data_end_time=_time_of(window.to_us),
        )
        await self._socket.send_text(encode_server(info))
        await self._advertise_signals()
        for result in await until_first(
            self._read_frames(self._position), self._play_window(self._position)
        ):
            if isinstance(result, Exception):
                raise result

    async def _read_frames(self, position: PlaybackPosition) -> None:
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            data = event.get("bytes")
            try:
                message = decode_client(event.get("text", "") if data is None else data)
            except UnknownKind as error:
                await self._send_status(_WARNING, str(error))
                continue
            await self._handle_message(message, position)

    async def _handle_message(
        self, message: said.FoxgloveMessage, position: PlaybackPosition
    ) -> None:
        match message:
            case said.FoxglovePlayback():
                await self._control_playback(message, position)
            case said.FoxgloveSubscribe():
                await self._subscribe_topics(message, position)
            case said.FoxgloveUnsubscribe():
                for number in message.subscription_ids:
                    self._things.unsubscribe_topic(number)
                self._changed.set()
            case _:
                await self._send_status(_WARNING, _PAST)

    async def _control_playback(
        self, asked: said.FoxglovePlayback, position: PlaybackPosition
    ) -> None:
        now_ns = self._clock.monotonic_ns()
        # Before anything is awaited: what plays looks at it next.
        position.control(asked, now_ns)
        at_us = position.time_at(now_ns)
        sought = asked.seek_ns is not None
        self._changed.set()
        await self._send_state(position, sought=sought, request_id=asked.request_id)
        if sought:
            self._sent_us = at_us
            # Of a later time nothing is known now.
            self._signals.forget_parts()
            await self._send_newest(list(self._wanted()), at_us)

    async def _subscribe_topics(
        self, message: said.FoxgloveSubscribe, position: PlaybackPosition
    ) -> None:
        added: list[SignalChannel] = []
        for one in message.subscriptions:
            try:
                topic = self._things.subscribe_topic(one.id, one.channel_id)
            # What is wrong with one is no reason to refuse the others.
            except ValueError as error:
                await self._send_status(_WARNING, str(error))
            else:
                added.append(self._things.offer.signals[topic])
        self._changed.set()
        # What was true then, before anything new is played.
        await self._send_newest(added, position.time_at(self._clock.monotonic_ns()))

    # ── what is played ──

    async def _play_window(self, position: PlaybackPosition) -> None:
        while True:
            self._changed.clear()
            if not position.playing or self._sent_us >= position.window.to_us:
                await self._changed.wait()
                continue
            await self._play_part(position)

    async def _play_part(self, position: PlaybackPosition) -> None:
        """Read what is due in the next second, and send it when it is due."""
        begin_us = self._sent_us + 1
        span_us = round(_READ_US * max(1.0, position.speed))
        end_us = min(begin_us + span_us, position.window.to_us)
        messages = self._signals.compose_messages(await self._read_samples(begin_us, end_us))
        now_ns = self._clock.monotonic_ns()
        if position.time_at(now_ns) - begin_us > _LATE_US * max(1.0, position.speed):
            position.move_to(begin_us, now_ns)
        waiting = next(messages, None)
        while not self._changed.is_set():
            due_us = min(position.time_at(self._clock.monotonic_ns()), end_us)
            while waiting is not None and waiting.time_us <= due_us and not self._changed.is_set():
                # Before it goes: whoever seeks meanwhile sets this.
                self._sent_us = max(self._sent_us, waiting.time_us - 1)
                await self._send_message(waiting.topic, waiting.time_us, waiting.data)
                waiting = next(messages, None)
            if self._changed.is_set():
                return
            self._sent_us = max(self._sent_us, due_us)
            await self._socket.send_bytes(encode_time(due_us * 1000))
            if due_us >= end_us:
                break
            await self._wait_changed(_STEP_S)
        if self._sent_us >= position.window.to_us and not self._changed.is_set():
            position.stand_at_end()
            await self._send_state(position, sought=False)

    async def _wait_changed(self, most_s: float) -> None:
        try:
            async with asyncio.timeout(most_s):
                await self._changed.wait()
        except TimeoutError:
            pass

    async def _read_samples(self, from_us: int, to_us: int) -> Iterator[ClientSample]:
        try:
            return await self._past.read_samples(list(self._wanted()), from_us, to_us)
        except HistoryError as error:
            await self._send_status(_ERROR, str(error))
            # Said, and playing goes on: the next part may be there.
            return iter(())

    async def _send_newest(self, signals: list[SignalChannel], at_us: int) -> None:
        """Send what was newest at a time."""
        try:
            samples = await self._past.read_newest(signals, at_us)
        except HistoryError as error:
            await self._send_status(_ERROR, str(error))
            return
        for message in self._signals.compose_messages(samples):
            await self._send_message(message.topic, message.time_us, message.data)

    def _wanted(self) -> Iterable[SignalChannel]:
        for topic, offered in self._things.offer.signals.items():
            if self._things.subscription_of(topic) is not None:
                yield offered

    # ── to the client ──

    async def deliver_message(self, message: ToBrowser) -> None:
        """Pass over what is live; what is there, and why it ends, is told."""
        match message:
            case SiteUpdate() if message.site == self._site:
                if message.catalogue != self._edition and self._position is not None:
                    await self._advertise_signals()
            case RequestError():
                await self._send_status(_WARNING, message.message)
            case SessionEnded():
                await self._send_status(_ERROR, message.reason)
            case _:
                pass

    async def warn_person(self, text: str) -> None:
        """Show a warning in the client."""
        await self._send_status(_WARNING, text)

    async def close_client(self, code: int) -> None:
        """Close the socket."""
        await self._socket.close(code)

    async def _advertise_signals(self) -> None:
        live = self._connection.live
        self._edition = live.edition
        offer = make_foxglove_offer(live.description, self._connection.who.grants)
        # Signals alone have a past here that can be played.
        offer = replace(offer, cameras={}, services={}, driven={}, parameters={})
        change = self._things.update_offer(offer)
        self._signals.update_offer(offer)
        self._changed.set()
        # What is gone comes first, as on a live connection.
        for message in change.messages:
            await self._socket.send_text(encode_server(message))

    async def _send_message(self, topic: str, time_us: int, data: bytes) -> None:
        # It may have ended while another message was sent.
        subscription = self._things.subscription_of(topic)
        if subscription is not None:
            await self._socket.send_bytes(encode_message_data(subscription, time_us * 1000, data))

    async def _send_state(
        self, position: PlaybackPosition, *, sought: bool, request_id: str = ""
    ) -> None:
        now_ns = self._clock.monotonic_ns()
        status: PlaybackStatus = position.status_at(now_ns)
        time_ns = position.time_at(now_ns) * 1000
        state = encode_playback_state(
            status, time_ns, speed=position.speed, sought=sought, request_id=request_id
        )
        await self._socket.send_bytes(state)

    async def _send_status(self, level: int, text: str) -> None:
        await self._socket.send_text(encode_server(ServerStatus(level=level, message=text)))


def _time_of(time_us: int) -> FoxgloveTime:
    seconds, micros = divmod(time_us * 1000, SECOND)
    return FoxgloveTime(seconds, micros)
