"""One Socket.IO client: what it asks becomes messages of a page, what it is told becomes events."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING

from talaia.first_completed import until_first
from talaia.hub.auth.tokens import new_token
from talaia.hub.clients.signal_subscriptions import SignalSubscriptions
from talaia.hub.clients.socketio.control_keys import ControlKeys
from talaia.hub.clients.socketio.founding_words import read_control
from talaia.hub.clients.socketio.offer import (
    SocketioOffer,
    make_socketio_offer,
    sensor_magnitude,
)
from talaia.wire.browser import RequestError, SessionEnded, SiteUpdate, Values
from talaia.wire.socketio.engine_packets import EngineRevision
from talaia.wire.socketio.founding_namespaces import (
    CONFIGURATION,
    NAMESPACES,
    PICTURES_IN,
    PICTURES_OUT,
    SENSED,
)
from talaia.wire.socketio.socket_packets import (
    SocketAssembly,
    SocketKind,
    SocketPacket,
    encode_socket,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.engineio.engine_connection import EngineConnection
    from talaia.hub.clients.client_cameras import ClientCameras
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.socketio.founding_words import ClientWishes
    from talaia.wire.browser import CameraPicture, ToBrowser

__all__ = ["SocketioSession"]

# The event by which a client is told why something is not done.
_REFUSED = "refused"
_NOT_TAKEN_IN = (
    "the hub takes in no sensed data and no pictures: send them to the robot's gateway, by a"
    " connection of kind socketio in the site's description"
)


class SocketioSession:
    """See `ClientSession`."""

    def __init__(
        self,
        line: EngineConnection,
        connection: ClientConnection,
        *,
        cameras: ClientCameras,
        wishes: ClientWishes,
    ) -> None:
        """Speak over ``line`` for ``connection``, as its address wishes."""
        self._line = line
        self._connection = connection
        self._cameras = cameras
        self._wishes = wishes
        self._assembly = SocketAssembly()
        self._signals = SignalSubscriptions(connection.live.name)
        self._keys = ControlKeys(connection, wishes.vehicle)
        self._offer = SocketioOffer()
        # Of the description that is offered.
        self._edition = ""
        # Namespaces that the client is in, as it spells them.
        self._joined: set[str] = set()
        # Where it last said something that was refused, and what it was told: each key would
        # repeat it.
        self._place = "/"
        self._told = ""
        # The camera that it looks at.
        self._camera = ""

    # ── from the client ──

    async def read_client(self) -> None:
        """Read until the client has gone."""
        try:
            results = await until_first(self._read_line(), self._line.keep_alive())
        finally:
            # The line stays open: why it ends may still be told.
            self._cameras.end_views()
        for result in results:
            if isinstance(result, Exception):
                raise result

    async def _read_line(self) -> None:
        self._update_offer()
        # Old clients are in it without asking.
        if self._line.revision is EngineRevision.OLD:
            await self._join_namespace("/")
        while True:
            packet = self._assembly.add_message(await self._line.next_message())
            if packet is not None:
                await self._handle_packet(packet)

    async def _handle_packet(self, packet: SocketPacket) -> None:
        match packet.kind:
            case SocketKind.CONNECT:
                await self._join_namespace(packet.namespace)
            case SocketKind.DISCONNECT:
                self._leave_namespace(packet.namespace)
            case SocketKind.EVENT if packet.namespace in self._joined:
                await self._handle_event(packet)
            case _:
                # Answers that nobody asked for, and events of a namespace that it is not in.
                pass

    async def _join_namespace(self, namespace: str) -> None:
        old = self._line.revision is EngineRevision.OLD
        if namespace not in NAMESPACES:
            # Old clients know these two words.
            why: object = "Invalid namespace"
            if not old:
                why = {"message": f"{why}; there are {', '.join(NAMESPACES)}"}
            await self._send_packet(SocketPacket(SocketKind.ERROR, namespace, why))
            return
        self._joined.add(namespace)
        said = None if old else {"sid": new_token()}
        await self._send_packet(SocketPacket(SocketKind.CONNECT, namespace, said))
        if namespace == CONFIGURATION:
            await self._send_configuration([namespace])
        elif namespace == PICTURES_OUT:
            await self._look_at_camera()
        elif namespace in SENSED:
            await self._subscribe_sensors()

    def _leave_namespace(self, namespace: str) -> None:
        self._joined.discard(namespace)
        if namespace == PICTURES_OUT:
            self._cameras.end_views()
            self._camera = ""
        if not self._sensing():
            for asked in self._signals.remove_addresses(list(self._signals.wanted)):
                self._connection.request(asked)

    async def _handle_event(self, packet: SocketPacket) -> None:
        # The decoder lets no other through.
        said = packet.data if isinstance(packet.data, list) else [""]
        name, args = said[0], said[1:]
        key = read_control(name, args)
        if key:
            await self._answer_event(packet, self._keys.press_key(key, self._offer))
        elif packet.namespace == CONFIGURATION:
            # Whatever it is called: there is nothing else to ask for here.
            told = self._offer.describe_site(self._connection.description)
            if packet.number is None:
                await self._send_event(packet.namespace, str(name)[:100], told)
            else:
                await self._send_answer(packet, told)
        elif packet.namespace in {*SENSED, PICTURES_IN}:
            await self._answer_event(packet, _NOT_TAKEN_IN)
        else:
            why = "what is said here is one character of w, x, a, d, s, or stop"
            await self._answer_event(packet, why)

    async def _answer_event(self, packet: SocketPacket, why: str) -> None:
        self._place = packet.namespace
        if packet.number is not None:
            await self._send_answer(packet, {"accepted": not why, "reason": why})
        elif why and why != self._told:
            await self._send_event(packet.namespace, _REFUSED, why)
        self._told = why

    # ── to the client ──

    async def deliver_message(self, message: ToBrowser) -> None:
        """Write a message of the hub as events, if it has a place there."""
        self._keys.observe_news(message)
        match message:
            case Values():
                await self._deliver_values(message)
            case SiteUpdate() if message.site == self._connection.live.name:
                if self._edition and message.catalogue != self._edition:
                    await self._follow_description()
            case RequestError():
                await self.warn_person(message.message)
            case SessionEnded():
                await self.warn_person(message.reason)
                await self._send_packets(
                    SocketPacket(SocketKind.DISCONNECT, place) for place in sorted(self._joined)
                )
            case _:
                pass

    async def warn_person(self, text: str) -> None:
        """Tell the client why something is not done, where it last asked for something."""
        place = self._place if self._place in self._joined else next(iter(self._joined), "")
        if place:
            await self._send_event(place, _REFUSED, text)

    async def close_client(self, code: int) -> None:
        """Close the line."""
        await self._line.close_line(code)

    async def _deliver_values(self, values: Values) -> None:
        packets = []
        for sample in self._signals.read_samples(values):
            sensor = self._offer.sensors.get(sample.address)
            if sensor is not None:
                said = {"name": sensor.name, "magnitude": sensor_magnitude(sensor, sample)}
                packets += [self._event(place, said) for place in self._sensing()]
        if packets:
            await self._send_packets(packets)

    async def _deliver_picture(self, picture: CameraPicture) -> None:
        if picture.format != "jpeg" or PICTURES_OUT not in self._joined:
            return
        said: str | bytes = picture.data
        if self._wishes.pictures == "base64":
            said = base64.b64encode(picture.data).decode()
        # One at a time: of those that would wait, only the newest is worth its way.
        event = encode_socket(self._event(PICTURES_OUT, said))
        await self._line.send_messages(event, until_pulled=True)

    def _update_offer(self) -> None:
        self._edition = self._connection.live.edition
        self._offer = make_socketio_offer(self._connection.description, self._connection.who.grants)

    async def _follow_description(self) -> None:
        self._update_offer()
        gone = [at for at in self._signals.wanted if at not in self._offer.sensors]
        for asked in self._signals.remove_addresses(gone):
            self._connection.request(asked)
        if self._sensing():
            await self._subscribe_sensors()
        if self._camera and self._camera not in self._offer.cameras:
            self._cameras.end_views()
            self._camera = ""
        await self._send_configuration(self._joined & {CONFIGURATION})

    async def _subscribe_sensors(self) -> None:
        if len(self._sensing()) > 1:
            # It is in the other spelling, too: the newest values are for this one as well.
            for asked in self._signals.remove_addresses(list(self._signals.wanted)):
                self._connection.request(asked)
        for asked in self._signals.add_addresses(self._offer.sensors):
            problem = self._connection.request(asked)
            if problem is not None:
                await self.warn_person(problem.message)

    async def _look_at_camera(self) -> None:
        self._place = PICTURES_OUT
        camera = self._wishes.camera or next(iter(self._offer.cameras), "")
        if camera not in self._offer.cameras:
            there = ", ".join(self._offer.cameras) or "none"
            await self.warn_person(f"there is no camera {camera!r} for this account: {there}")
            return
        self._camera = camera
        self._cameras.subscribe_stream(camera, self._deliver_picture, self.warn_person)

    def _sensing(self) -> list[str]:
        return [place for place in SENSED if place in self._joined]

    def _event(self, namespace: str, said: object) -> SocketPacket:
        name = self._wishes.event or namespace.strip("/")
        return SocketPacket(SocketKind.EVENT, namespace, [name, said])

    async def _send_configuration(self, places: Iterable[str]) -> None:
        told = self._offer.describe_site(self._connection.description)
        await self._send_packets(self._event(place, told) for place in places)

    async def _send_event(self, namespace: str, name: str, said: object) -> None:
        await self._send_packet(SocketPacket(SocketKind.EVENT, namespace, [name, said]))

    async def _send_answer(self, asked: SocketPacket, said: object) -> None:
        answer = SocketPacket(SocketKind.ACK, asked.namespace, [said], asked.number)
        await self._send_packet(answer)

    async def _send_packet(self, packet: SocketPacket) -> None:
        await self._line.send_messages(encode_socket(packet))

    async def _send_packets(self, packets: Iterable[SocketPacket]) -> None:
        messages = [message for packet in packets for message in encode_socket(packet)]
        await self._line.send_messages(messages)
