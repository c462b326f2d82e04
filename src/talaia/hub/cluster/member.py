"""This hub among the others: it says that it is there, hears them, and passes frames on."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import logging
import os
import secrets
import time
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from talaia.hub.cluster.answering import Answering
from talaia.hub.cluster.bus import BusLane
from talaia.hub.cluster.entrance import Entrance
from talaia.hub.cluster.frames import FrameKind, FrameSeal, TunnelFrame
from talaia.hub.cluster.peers import BEAT_S, HubNotice, Peers
from talaia.hub.cluster.tunnel import TunnelName

if TYPE_CHECKING:
    from collections.abc import Callable

    from starlette.types import ASGIApp

    from talaia.clock import Clock
    from talaia.hub.cluster.bus import Bus

__all__ = ["ClusterMember"]

_LOG = logging.getLogger(__name__)
_NOTICE = msgspec.msgpack.Decoder(HubNotice)
_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


class ClusterMember:
    """Says how this hub stands, and knows how the others do.

    Attributes:
        hub: names this run of it.
        entrance: hands requests to the hub that leads.
        answering: answers those that came to others, while this one leads.
        peers: the other hubs.

    """

    def __init__(
        self,
        bus: Bus,
        clock: Clock,
        *,
        key: bytes,
        name: str,
        version: str,
        superseded: Callable[[], None],
    ) -> None:
        """Speak over ``bus`` under ``key``; ``superseded`` hears that a newer lead is there."""
        self._bus = bus
        self._clock = clock
        self._seal = FrameSeal(key)
        # Of the key: hubs with another one, on the same NATS, are another installation.
        self._prefix = f"talaia.{hashlib.blake2b(key, digest_size=6).hexdigest()}"
        self._superseded = superseded
        self.hub = secrets.token_hex(8)
        self._name, self._version = name, version
        self._since_us = clock.wall_ns() // 1000
        # 0: this hub does not lead.
        self._epoch = 0
        self._leaving = False
        # It has the lock, and reads what is stored.
        self._opens = False
        # How often the bus was lost.
        self._losses = 0
        self._saying: asyncio.Task[None] | None = None
        self._cpu_s, self._cpu_ns = time.process_time(), clock.monotonic_ns()
        self.peers = Peers()
        self.entrance = Entrance(find_lead=self._find_lead_hub, post=self._post)
        self.answering = Answering(self._post)
        # Gives the links of gateways and other sockets that came to this process, and the shards
        # that it leads.
        self.describe_process: Callable[[], tuple[int, int, tuple[str, ...]]] = lambda: (0, 0, ())
        self.database_ms: Callable[[], float] = lambda: 0.0
        # Called when another hub says that it leads.
        self.lead_heard: Callable[[], None] = lambda: None

    @property
    def leads(self) -> bool:
        """Whether this hub leads, and answers."""
        return self._epoch > 0 and not self._leaving

    @property
    def connected(self) -> bool:
        """Whether the bus is there."""
        return self._bus.connected

    def find_lead(self) -> HubNotice | None:
        """Give the other hub that leads; None: none is heard."""
        return self.peers.find_lead(self._clock.monotonic_ns()) if self._bus.connected else None

    @property
    def hears_lead(self) -> bool:
        """Whether another hub says that it leads, or is about to."""
        return self.peers.hears_lead(self._clock.monotonic_ns())

    @property
    def led_lately(self) -> bool:
        """Whether another hub leads, or did a moment ago."""
        return self._bus.connected and self.peers.led_lately(self._clock.monotonic_ns())

    async def open(self) -> None:
        """Listen from now on."""
        own = {lane: f"{self._prefix}.{lane}.{self.hub}.*" for lane in BusLane}
        subjects = {
            BusLane.URGENT: (own[BusLane.URGENT], self._notices),
            BusLane.BULK: (own[BusLane.BULK],),
        }
        await self._bus.open(subjects, self._receive, self._lose_bus, self._regain_bus)

    async def run(self) -> None:
        """Say that this hub is there, and end what goes by hubs that are not, for ever."""
        while True:
            try:
                await self._say_notice()
                self._end_broken()
            except Exception:  # noqa: BLE001 - logged; a hub that fell silent would be taken for gone
                _LOG.exception("a beat between the hubs failed; the next one comes")
            await asyncio.sleep(BEAT_S)

    async def begin_opening(self) -> None:
        """Say that this hub is about to lead: nobody is to wait for the one of before."""
        self._opens = True
        await self._say_notice()

    async def pause_leading(self) -> None:
        """Say that this hub leads anew in a moment, and end what it answers for others.

        They hold who comes meanwhile, as within a take-over.
        """
        self._epoch, self._opens = 0, True
        await self._say_notice()
        await self.answering.finish_answering("the hub that leads begins anew")

    async def begin_leading(self, app: ASGIApp, epoch: int) -> None:
        """Answer for the others with ``app`` from now on."""
        self._epoch, self._opens = epoch, False
        # Whoever came through here to the lead of before comes again, and is answered here.
        self.entrance.break_off("this hub leads now")
        self.answering.begin_answering(app)
        # At once: who waits for a lead need not wait for the next beat.
        await self._say_notice()

    async def hand_over(self) -> None:
        """Say that this hub ends, and send whoever came to it to the others."""
        self._leaving = True
        await self._say_notice()
        await self.entrance.hand_over("the hub ends")

    async def leave_others(self) -> None:
        """Say that this hub ends, and end what it answers for others."""
        self._leaving = True
        await self._say_notice()
        await self.answering.finish_answering("the hub that leads ends")

    async def close(self) -> None:
        """Let go of the bus."""
        self.entrance.break_off("the hub ends")
        await self._bus.close()

    def own_notice(self) -> HubNotice:
        """Say how this hub stands."""
        now_ns, cpu_s = self._clock.monotonic_ns(), time.process_time()
        passed_s = (now_ns - self._cpu_ns) / 1e9
        cpu = (cpu_s - self._cpu_s) / passed_s if passed_s > 0 else 0.0
        # Over a few beats, so that one busy moment is no load.
        if passed_s > 5.0:
            self._cpu_s, self._cpu_ns = cpu_s, now_ns
        gateways, sockets, shards = self.describe_process()
        return HubNotice(
            hub=self.hub,
            name=self._name,
            version=self._version,
            leads=self._epoch > 0,
            epoch=self._epoch,
            leaving=self._leaving,
            opens=self._opens,
            losses=self._losses,
            since_us=self._since_us,
            cpu=round(cpu, 3),
            memory_bytes=_memory_bytes(),
            database_ms=self.database_ms(),
            gateways=gateways,
            sockets=sockets,
            shards=shards,
        )

    @property
    def _notices(self) -> str:
        return f"{self._prefix}.hubs"

    def _find_lead_hub(self) -> str | None:
        lead = self.find_lead()
        return lead.hub if lead else None

    def _end_broken(self) -> None:
        """End what goes by hubs that are gone."""
        now_ns = self._clock.monotonic_ns()
        for hub in self.answering.list_hubs():
            if not self.peers.is_living(hub, now_ns):
                self.answering.break_off("the hub between is gone", hub=hub)
        self.entrance.break_off("the hub that led is gone", but=self._find_lead_hub())

    async def _say_notice(self) -> None:
        payload = msgspec.msgpack.encode(self.own_notice())
        frame = TunnelFrame(FrameKind.NOTICE, 0, 0, payload)
        # Who does not hear it takes this hub for gone, and that is right.
        with contextlib.suppress(OSError):
            data = self._seal.write_frame(self._notices, frame)
            await self._bus.publish(BusLane.URGENT, self._notices, data)

    async def _post(self, name: TunnelName, lane: BusLane, frame: TunnelFrame) -> None:
        subject = f"{self._prefix}.{lane}.{name.hub}.{self.hub}"
        await self._bus.publish(lane, subject, self._seal.write_frame(subject, frame))

    def _receive(self, lane: BusLane, subject: str, data: bytes) -> None:
        frame = self._seal.read_frame(subject, data)
        if frame is None:
            _LOG.debug("something on %s is from no hub of ours", subject)
        elif subject == self._notices:
            self._hear_notice(frame)
        else:
            self._hear_tunnel(lane, subject.rsplit(".", 1)[1], frame)

    def _hear_notice(self, frame: TunnelFrame) -> None:
        try:
            notice = _NOTICE.decode(frame.payload)
        except msgspec.DecodeError as error:
            _LOG.debug("a hub says what cannot be read: %s", error)
            return
        # NATS gives back to everybody what they say themselves.
        if notice.hub == self.hub:
            return
        if self.peers.hear_notice(notice, self._clock.monotonic_ns()):
            # It has broken off what was under way, and could tell nobody.
            self.entrance.break_off_at(notice.hub, "the hub that leads had lost the bus")
            self.answering.break_off("the hub between had lost the bus", hub=notice.hub)
        if notice.leads and notice.epoch > self._epoch > 0:
            self._superseded()
        elif notice.opens and not self._epoch:
            # Sooner than its silence would tell; who comes again is held until that one leads.
            self.entrance.break_off("another hub is about to lead")
        elif notice.leads and not self._epoch:
            # Of a new lead at once: who still asks the one of before waits for nothing.
            self.entrance.break_off("another hub leads now", but=self._find_lead_hub())
            self.lead_heard()

    def _hear_tunnel(self, lane: BusLane, hub: str, frame: TunnelFrame) -> None:
        name = TunnelName(hub, frame.tunnel)
        # What is shared comes of a hub that led a moment ago, and answers nothing here.
        if self._epoch and frame.kind is not FrameKind.SHARED:
            if frame.kind is FrameKind.OPEN:
                self.peers.hear_request(hub, self._clock.monotonic_ns())
            self.answering.receive_frame(name, lane, frame)
        else:
            self.entrance.receive_frame(name, frame)

    def _regain_bus(self) -> None:
        # Before anything else goes out: the others end what this hub has broken off.
        self._saying = asyncio.create_task(self._say_notice(), name="say that the bus is back")

    def _lose_bus(self) -> None:
        self._losses += 1
        # What was under way may be lost: nothing is driven by what comes late.
        self.peers.silence_all()
        self.entrance.break_off("the bus between the hubs is gone")
        self.answering.break_off("the bus between the hubs is gone")


def _memory_bytes() -> int:
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * _PAGE_BYTES
    except (OSError, ValueError, IndexError):
        # Only Linux has it.
        return 0
