"""One program that is connected: the namespaces it is in, and what it sends there."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING, Protocol

from talaia.clock import SECOND
from talaia.first_completed import until_first
from talaia.gateway.adapters.socketio.event_data import place_of
from talaia.wire.socketio.engine_packets import EngineRevision
from talaia.wire.socketio.founding_namespaces import CONFIGURATION
from talaia.wire.socketio.socket_packets import (
    SocketAssembly,
    SocketKind,
    SocketPacket,
    encode_socket,
)

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from talaia.clock import Clock
    from talaia.engineio.engine_connection import EngineConnection

__all__ = ["EventReceiver", "ProgramSession"]

# Clients keep what they could not send and send it once they are back: for so long after a program
# has come into a namespace, nobody knows of when its data are.
_SETTLING_NS = 2 * SECOND
# Reasons that one program is told unasked; it may never read them.
_MOST_TOLD = 20
_PLACE_OF_CONFIGURATION = place_of(CONFIGURATION)


class EventReceiver(Protocol):
    """Takes what programs send; on the event loop."""

    @property
    def places(self) -> Collection[str]:
        """Name the namespaces that there are, as `place_of` gives them."""
        ...

    def receive_event(self, place: str, event: str, args: Sequence[object], *, fresh: bool) -> str:
        """Take an event; give why nothing of it is read, or nothing."""
        ...

    def count_program(self, place: str, change: int) -> None:
        """Take that one more, or one less, is in a namespace."""
        ...

    def describe_site(self) -> dict[str, object]:
        """Give what a program is told of the configuration."""
        ...


class ProgramSession:
    """Serves one program until its line ends."""

    def __init__(self, line: EngineConnection, receiver: EventReceiver, clock: Clock) -> None:
        """Hand what comes by ``line`` to ``receiver``."""
        self._line = line
        self._receiver = receiver
        self._clock = clock
        self._assembly = SocketAssembly()
        # Namespaces as the program spells them, with when it came (monotonic ns).
        self._joined: dict[str, int] = {}
        self._told: set[str] = set()

    async def read_program(self) -> None:
        """Read until the program has gone; raises what was wrong with what it sent."""
        try:
            results = await until_first(self._read_line(), self._line.keep_alive())
        finally:
            for namespace in list(self._joined):
                self._leave_namespace(namespace)
        for result in results:
            if isinstance(result, Exception):
                raise result

    async def _read_line(self) -> None:
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
        old, place = self._line.revision is EngineRevision.OLD, place_of(namespace)
        if place not in self._receiver.places:
            # Old clients know these two words.
            why: object = "Invalid namespace"
            if not old:
                why = {"message": f"{why}; there are {', '.join(sorted(self._receiver.places))}"}
            await self._send_packet(SocketPacket(SocketKind.ERROR, namespace, why))
            return
        if namespace not in self._joined:
            self._joined[namespace] = self._clock.monotonic_ns()
            self._receiver.count_program(place, 1)
        said = None if old else {"sid": secrets.token_urlsafe(16)}
        await self._send_packet(SocketPacket(SocketKind.CONNECT, namespace, said))
        if place == _PLACE_OF_CONFIGURATION:
            await self._send_event(namespace, place, self._receiver.describe_site())

    def _leave_namespace(self, namespace: str) -> None:
        if self._joined.pop(namespace, None) is not None:
            self._receiver.count_program(place_of(namespace), -1)

    async def _handle_event(self, packet: SocketPacket) -> None:
        # The decoder lets no other through.
        said = packet.data if isinstance(packet.data, list) else [""]
        event, place = str(said[0]), place_of(packet.namespace)
        if place == _PLACE_OF_CONFIGURATION:
            # Whatever it is called: there is nothing else to ask for here.
            told = self._receiver.describe_site()
            if packet.number is None:
                await self._send_event(packet.namespace, event[:100], told)
            else:
                await self._send_answer(packet, told)
            return
        age_ns = self._clock.monotonic_ns() - self._joined[packet.namespace]
        fresh = age_ns >= _SETTLING_NS
        why = self._receiver.receive_event(place, event, said[1:], fresh=fresh)
        if packet.number is not None:
            await self._send_answer(packet, {"accepted": not why, "reason": why})
        elif why and why not in self._told and len(self._told) < _MOST_TOLD:
            self._told.add(why)
            await self._send_event(packet.namespace, "refused", why)

    async def _send_event(self, namespace: str, name: str, said: object) -> None:
        await self._send_packet(SocketPacket(SocketKind.EVENT, namespace, [name, said]))

    async def _send_answer(self, asked: SocketPacket, said: object) -> None:
        answer = SocketPacket(SocketKind.ACK, asked.namespace, [said], asked.number)
        await self._send_packet(answer)

    async def _send_packet(self, packet: SocketPacket) -> None:
        await self._line.send_messages(encode_socket(packet))
