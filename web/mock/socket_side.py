"""The mock hub's sockets: one `Browser` for each page, and the camera."""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import time
from typing import TYPE_CHECKING

from fastapi import WebSocketDisconnect
from seen_side import things
from world import World, now_columns

from talaia.hub.anomaly.selection import score_channels
from talaia.wire import browser as wire
from talaia.wire.browser import FROM_BROWSER, MEDIA_FROM_BROWSER, MEDIA_TO_BROWSER, TO_BROWSER
from talaia.wire.columns import pack_columns
from talaia.wire.frames import CommandPhase, LeaseOp

if TYPE_CHECKING:
    from collections.abc import Iterable

    from fastapi import WebSocket


# Messages that wait for one page, at most; what comes later is left out until it reads again.
MOST_WAITING = 500


class Browser:
    """One connected page. Everything that is sent goes through ``outbox``."""

    def __init__(
        self, socket: WebSocket, name: str, role: str, world: World, peers: Iterable[Browser]
    ) -> None:
        """Take the accepted socket, who it is, and all pages (this one too)."""
        self.socket, self.name, self.role, self.world, self.peers = socket, name, role, world, peers
        self.mute = False
        self.outbox: asyncio.Queue[wire.ToBrowser] = asyncio.Queue()
        self.subs: dict[int, wire.Subscribe] = {}
        self.due: dict[int, float] = {}
        self.sent_until: dict[int, float] = {}
        self.reset_token = ""
        self.ticks = 0
        described = world.site.channels()
        scores = score_channels(world.site, len(described))
        self.known = {channel.address for channel in (*described, *scores)}
        self.tasks: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        """Serve the page until it goes."""
        self.say(
            wire.Greeting(
                who=self.name, role=self.role, version="mock", time_us=int(time.time() * 1e6)
            )
        )
        self.site_news()
        self.lease_news()
        self.stop_news("")
        writer = asyncio.create_task(self._write())
        try:
            while True:
                message = FROM_BROWSER.decode(await self.socket.receive_bytes())
                self.take(message)
        except WebSocketDisconnect:
            pass
        finally:
            self.free()
            writer.cancel()
            for task in self.tasks:
                task.cancel()

    async def _write(self) -> None:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            while True:
                await self.socket.send_bytes(TO_BROWSER.encode(await self.outbox.get()))

    def say(self, message: wire.ToBrowser) -> None:
        """Queue a message."""
        self.outbox.put_nowait(message)

    def everyone(self, message: wire.ToBrowser) -> None:
        """Queue a message for all pages."""
        for peer in self.peers:
            peer.say(message)

    # ── what the page asks ──────────────────────────────────────────────────────────────────

    def take(self, message: wire.FromBrowser) -> None:
        """Act on one message."""
        match message:
            case wire.PagePing(n=n, at_ms=at_ms):
                self.say(wire.PagePong(n=n, at_ms=at_ms, hub_us=time.monotonic_ns() // 1000))
            case wire.Subscribe():
                self.subscribe(message)
            case wire.Unsubscribe(sub=sub):
                self.subs.pop(sub, None)
            case wire.PageLease(op=op):
                self.lease(op)
            case wire.PageDrive():
                self.drive(message)
            case wire.PageStop(id=stop_id):
                self.world.latched, self.world.stopper = True, self.name
                self.news_to_all(stop_id)
            case wire.PageReset(token=token):
                self.reset(token)
            case wire.PageCommand():
                task = asyncio.create_task(self.command(message))
                self.tasks.add(task)
                task.add_done_callback(self.tasks.discard)

    def subscribe(self, message: wire.Subscribe) -> None:
        """Note it, and send the last known samples."""
        self.subs[message.sub] = message
        refused = [name for name in message.channels if name not in self.known]
        self.say(wire.Subscribed(sub=message.sub, refused=refused))
        if message.site == self.world.site.site:
            self.send_values(message, [time.time()], first=True)

    def lease(self, op: LeaseOp) -> None:
        """Give, renew or free the only lease there is."""
        world, mine = self.world, self.world.holder_key == id(self)
        if op is LeaseOp.FREE:
            self.free()
            return
        if self.role == "guest":
            self.say(self._lease_message(refused="Guests do not drive."))
            return
        if world.holder and not mine:
            self.say(self._lease_message(refused=f"{world.holder} is driving."))
            return
        if not world.holder:
            world.epoch += 1
            world.holder, world.holder_key = self.name, id(self)
        world.until = time.time() + 3
        self.leases_to_all()

    def free(self) -> None:
        """Let go of the lease, if it is this page's."""
        if self.world.holder_key == id(self):
            self.world.holder, self.world.holder_key, self.world.asked = "", 0, (0.0, 0.0)
            self.leases_to_all()

    def drive(self, frame: wire.PageDrive) -> None:
        """Take a driving frame, or count it as refused."""
        world = self.world
        if world.holder_key != id(self) or frame.epoch != world.epoch or frame.held_ms > 250:
            world.refused += 1
            return
        world.accepted += 1
        world.asked, world.asked_at = (frame.linear, frame.angular), time.time()

    def reset(self, token: str) -> None:
        """Two steps: a token, then the release."""
        key = {"site": self.world.site.site, "device": "base"}
        if self.world.holder_key != id(self):
            self.say(wire.ResetTokenUpdate(**key, refused="Take control first."))
        elif not token:
            self.reset_token = secrets.token_hex(8)
            self.say(wire.ResetTokenUpdate(**key, token=self.reset_token))
        elif token == self.reset_token:
            self.world.latched = False
            self.news_to_all("")
        else:
            self.say(wire.ResetTokenUpdate(**key, refused="That token is not the newest."))

    async def command(self, ask: wire.PageCommand) -> None:
        """Accept, run with progress, succeed."""

        def tell(phase: CommandPhase, progress: float = 0.0, message: str = "") -> None:
            self.everyone(
                wire.CommandUpdate(
                    site=ask.site, device=ask.device, command=ask.command, id=ask.id, who=self.name,
                    phase=phase, progress=progress, message=message,
                )
            )  # fmt: skip

        if not self.world.online:
            tell(CommandPhase.REFUSED, message="The site is not connected.")
            return
        tell(CommandPhase.ACCEPTED)
        for part in range(1, 4):
            await asyncio.sleep(0.3)
            tell(CommandPhase.RUNNING, part / 4)
        if ask.command == "wander":
            self.world.wandering = bool(ask.args.get("active", True))
        tell(CommandPhase.SUCCEEDED, 1.0, "Wander mode is " + str(ask.args.get("active")))

    # ── what the page is told ───────────────────────────────────────────────────────────────

    def tick(self) -> None:
        """Send what is due; called 20 times a second."""
        # A page that reads nothing (frozen, or its writer has ended) would fill the memory.
        if self.outbox.qsize() > MOST_WAITING:
            return
        self.ticks += 1
        world, now = self.world, time.time()
        if world.holder_key == id(self) and now > world.until:
            self.free()
        if world.holder and world.online:
            self.say(wire.TickUpdate(site=world.site.site, tick=time.monotonic_ns() // 1000))
        if self.ticks % 4 == 0 and world.online:
            self.say(
                wire.DriveUpdate(
                    site=world.site.site, device="base", linear=world.linear,
                    angular=world.angular, cap=1.0, loop_ms=4.2, accepted=world.accepted,
                    refused=world.refused, why="stopped" if world.latched else "",
                )
            )  # fmt: skip
        if self.mute or not world.online:
            return
        for sub, ask in self.subs.items():
            if ask.site == world.site.site and now >= self.due.get(sub, 0):
                self.due[sub] = now + ask.every_ms / 1000
                self.send_values(ask, [now])

    def send_values(self, ask: wire.Subscribe, times: list[float], *, first: bool = False) -> None:
        """Send one batch."""
        columns = now_columns(self.world, list(ask.channels), self.known, times)
        if not len(columns):
            return
        base, channel, offset, value, *_ = pack_columns(columns)
        age = 0.0 if self.world.online else (time.time() - self.world.since) * 1000
        self.say(
            wire.Values(
                sub=ask.sub, base_us=base, channel=channel, offset=offset, value=value,
                age_ms=[age] * len(columns) if first else [],
            )
        )  # fmt: skip

    def site_news(self) -> None:
        """Say whether the site is there."""
        world = self.world
        self.say(
            wire.SiteUpdate(
                site=world.site.site, online=world.online, since_us=int(world.since * 1e6),
                catalogue="1", loop_ms=4.2 if world.online else 0.0,
                why="" if world.online else "the gateway closed the link",
            )
        )  # fmt: skip

    def _lease_message(self, refused: str = "") -> wire.LeaseUpdate:
        world, mine = self.world, self.world.holder_key == id(self)
        return wire.LeaseUpdate(
            site=world.site.site, device="base", holder=world.holder, yours=mine,
            epoch=world.epoch if mine else 0, refused=refused,
            remains_ms=max(0, int((world.until - time.time()) * 1000)) if world.holder else 0,
        )  # fmt: skip

    def lease_news(self) -> None:
        """Say who drives."""
        self.say(self._lease_message())

    def leases_to_all(self) -> None:
        """Say to all who drives."""
        for peer in tuple(self.peers):
            peer.lease_news()

    def stop_news(self, stop_id: str) -> None:
        """Say how STOP stands."""
        world = self.world
        self.say(
            wire.StopUpdate(
                site=world.site.site, device="base", latched=world.latched,
                confirmed=world.latched and abs(world.linear) < 0.02, who=world.stopper,
                time_us=int(time.time() * 1e6), id=stop_id,
            )
        )  # fmt: skip

    def news_to_all(self, stop_id: str) -> None:
        """Say how STOP stands, and again once the vehicle stands still."""
        for peer in tuple(self.peers):
            peer.stop_news(stop_id)
            asyncio.get_running_loop().call_later(0.5, peer.stop_news, stop_id)


async def media(socket: WebSocket, world: World) -> None:
    """Send pictures at 15 Hz, two under way at the most."""
    credit = asyncio.Semaphore(2)

    boxed = False

    async def read() -> None:
        nonlocal boxed
        with contextlib.suppress(WebSocketDisconnect):
            while True:
                said = MEDIA_FROM_BROWSER.decode(await socket.receive_bytes())
                if isinstance(said, wire.PictureShown):
                    credit.release()
                elif isinstance(said, wire.BoxesRequest):
                    boxed = said.on

    async def look(seq: int, now: float) -> None:
        await asyncio.sleep(0.07)
        if boxed:
            found = wire.CameraPictureBoxes(seq=seq, time_us=int(now * 1e6), things=things(now))
            await socket.send_bytes(MEDIA_TO_BROWSER.encode(found))

    reader = asyncio.create_task(read())
    seq = 0
    looking: list[asyncio.Task[None]] = []
    try:
        while not reader.done():
            await credit.acquire()
            seq += 1
            now = time.time()
            shot = wire.CameraPicture(
                seq=seq, time_us=int(now * 1e6), hub_us=time.monotonic_ns() // 1000,
                width=640, height=480, format="jpeg", data=world.picture(seq, now),
            )  # fmt: skip
            await socket.send_bytes(MEDIA_TO_BROWSER.encode(shot))
            if seq % 2 == 0:
                looking.append(asyncio.create_task(look(seq, now)))
                looking = [each for each in looking if not each.done()]
            await asyncio.sleep(1 / 15)
    finally:
        reader.cancel()
