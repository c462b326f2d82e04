"""Links of gateways that wait while another one has the place: only STOP goes down to them."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.first_completed import until_first
from talaia.hub.live.gateways.doubles.duplicate_gateways import HELD
from talaia.hub.live.gateways.link import GONE
from talaia.hub.live.site_state import HeldGateway
from talaia.wire import frames
from talaia.wire.errors import PeerError

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.live.gateways.link import GatewayLink
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.sites import LiveSite

__all__ = ["MOST_HELD", "HeldLinks"]

# Of one site; whoever has the key could else fill the hub's memory with hellos.
MOST_HELD = 4
# In one beat. One that waits answers beats and has nothing else to say, and what it does say must
# cost the gateway that is linked nothing of its allowance.
_MOST_FRAMES = 20
_MISSED_BEATS = 3


class HeldLinks:
    """Keeps a link while its gateway waits."""

    def __init__(self, reporting: RobotEvents, clock: Clock, beat_s: float) -> None:
        """Tell by ``reporting``; a beat every ``beat_s``."""
        self._reporting = reporting
        self._clock = clock
        self._beat_s = beat_s

    async def wait_turn(
        self, link: GatewayLink, live: LiveSite, hello: frames.Hello, address: str
    ) -> bool:
        """Hold a link; False: it has ended. True: the place is free, or an admin gave it to it."""
        held = HeldGateway(
            link=link,
            boot=hello.boot,
            version=hello.version,
            address=address,
            since_us=self._clock.wall_ns() // 1000,
        )
        # Before anything is awaited: a STOP that is pressed now goes down to it as well.
        live.rivals.held.append(held)
        link.send(frames.LinkHeld(reason=HELD))
        try:
            # Whichever ends first ends the waiting: a hang-up, silence, an admin, or its turn.
            results = await until_first(
                self._read_all(link, live, held),
                self._send_beats(link, held),
                link.write_queued(),
                link.wait_dismissed(),
                held.turn.wait(),
            )
        finally:
            # Out of the list first, so that pages are not told of one that has gone.
            live.rivals.held.remove(held)
            self._reporting.held_stops.forget_gateway(live, held)
            self._reporting.publish_site(live)
        for result in results:
            if isinstance(result, str | PeerError):
                code = result.code if isinstance(result, PeerError) else 1000
                await link.send_farewell(str(result), code)
                return False
            if isinstance(result, Exception) and not isinstance(result, GONE):
                raise result
        # The last is the turn, unless something else has ended first.
        return results[-1] is True

    async def _read_all(self, link: GatewayLink, live: LiveSite, held: HeldGateway) -> None:
        while (message := await link.receive_message()) is not None:
            held.frames += 1
            if held.frames > _MOST_FRAMES:
                raise PeerError("a gateway that waits has nothing to say", 1013)
            match message:
                case frames.Beat():
                    now_us = self._clock.monotonic_ns() // 1000
                    reply = frames.BeatReply(n=message.n, mono_us=message.mono_us, peer_us=now_us)
                    link.send(reply)
                case frames.BeatReply():
                    now_us = self._clock.monotonic_ns() // 1000
                    link.offset.add_beat(message.mono_us, now_us, message.peer_us)
                case frames.StopState():
                    self._reporting.held_stops.receive_state(live, held, message)
                case frames.Bye():
                    return
                case _:
                    # What the one that is linked says is what counts.
                    pass

    async def _send_beats(self, link: GatewayLink, held: HeldGateway) -> None:
        sent = 0
        while True:
            heard, held.frames = link.offset.heard, 0
            link.send(frames.Beat(n=sent, mono_us=self._clock.monotonic_ns() // 1000))
            sent += 1
            # Half open, it would hold one of few places for good.
            if sent - heard > _MISSED_BEATS:
                link.dismiss_gateway("it has not answered for three beats")
            await asyncio.sleep(self._beat_s)
