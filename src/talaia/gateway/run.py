"""The gateway's process: builds every part, runs them in one task group, ends them in order.

Long, because the parts are joined here and nowhere else.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import logging
import os
import secrets
import signal
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING

import uvloop

from talaia import __version__
from talaia.clock import SECOND, SystemClock
from talaia.errors import TalaiaError
from talaia.gateway import enrol
from talaia.gateway.adapters.catalog import adapter_of
from talaia.gateway.adapters.many import Many, Post
from talaia.gateway.arguments import parsed, settings_of
from talaia.gateway.batching import Batcher
from talaia.gateway.changing import Changing
from talaia.gateway.classic import Newest
from talaia.gateway.commanding import Commanding, Journal
from talaia.gateway.control import Control
from talaia.gateway.desk import FrontDesk, Voice
from talaia.gateway.door import Door, keys_of
from talaia.gateway.errors import SettingsError
from talaia.gateway.exchange import Exchange, Parts, catalogue_of, prepared
from talaia.gateway.found import joined, keep_found, kept_of, with_kept
from talaia.gateway.frames.outbox import Outbox
from talaia.gateway.frames.taking import FrameTaker
from talaia.gateway.frames.whole import WholeFiles
from talaia.gateway.interlocks import Interlocks
from talaia.gateway.keep import Epochs, KeptStops, locked
from talaia.gateway.own_copy import OwnCopy
from talaia.gateway.pacing import Pacer
from talaia.gateway.permitting import Accepts
from talaia.gateway.pictures.looks import Looks
from talaia.gateway.ports import Outlets
from talaia.gateway.reach import Reach
from talaia.gateway.recording.shelf import Shelf
from talaia.gateway.roster import Roster
from talaia.gateway.sequences import Sequences
from talaia.gateway.share import shares_of
from talaia.gateway.spool.journal import Head, Spool
from talaia.gateway.spool.keeper import Keeper
from talaia.gateway.stalls import watch_stalls
from talaia.gateway.uplink.catchup import CatchUp
from talaia.gateway.uplink.connection import LinkRun, run_media
from talaia.gateway.uplink.dialling import Outage, beside_link, keep_dialling
from talaia.gateway.uplink.files import Lane, Sending, send_files
from talaia.gateway.uplink.lanes import Lanes
from talaia.gateway.uplink.pictures import Pictures
from talaia.gateway.uplink.tls import Trust
from talaia.model.check import raise_first
from talaia.model.load import site_in
from talaia.wire.frames import ArchiveOffer, Hello
from talaia.wire.sealing import deflated

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping, Sequence

    from talaia.clock import Clock
    from talaia.gateway.ports import Adapter
    from talaia.gateway.recording.recorder import Recorder
    from talaia.gateway.settings import Settings
    from talaia.gateway.share import Share
    from talaia.gateway.spool.segment import Record
    from talaia.model.site import Device, Site
    from talaia.wire.frames import FileOffer, RecordState, Welcome

__all__ = ["Gateway", "catalogue_of", "main", "new_boot", "serve"]

log = logging.getLogger(__name__)
END_S = 1.5


def new_boot() -> str:
    """Name this run of the gateway; later runs sort behind while the clock is right."""
    return f"{time.time_ns() // 1_000_000:012x}-{secrets.token_hex(4)}"


class Gateway:
    """All parts of one gateway, built for one event loop.

    Attributes:
        redescribed: after `run`: the site with devices that were found, to begin again with.

    """

    def __init__(
        self, site: Site, settings: Settings, clock: Clock, copy: OwnCopy | None = None
    ) -> None:
        """Build every part and take up what an earlier run left in the data folder.

        Args:
            site: the description, with the devices that were found.
            settings: see `Settings`.
            clock: every part's.
            copy: the description's file; none leaves it as it is until the end.

        Raises:
            SpoolError: the data folder cannot be used.
            SettingsError: the description names a connection that cannot be used here.

        """
        # Set when a robot's side has shown more than the description knew.
        self.redescribed: Site | None = None
        self._again = asyncio.Event()
        self._settings, self._clock = settings, clock
        begun = prepared(site, copy.text if copy is not None and copy.editable else "")
        self._boot = new_boot()
        roster = Roster(site)
        self._told = 0
        self._loop = loop = asyncio.get_running_loop()
        data = settings.data
        self._lock = locked(data)
        # One thread for the small files: their writes keep their order.
        self._disk = ThreadPoolExecutor(1, "talaia-disk")
        # Pictures and recordings are large: their disk work has a thread of its own.
        self._files = ThreadPoolExecutor(1, "talaia-files")
        self._wake = asyncio.Event()
        self._lanes = Lanes(self._wake.set)
        self._voice = Voice(loop, clock, self._lanes)
        # Whoever looks at cameras here (a detector) takes pictures from `looks`.
        self.looks = Looks()
        self._pictures = Pictures(loop, clock, self.looks)
        head = Head(self._boot, begun.catalogue, begun.addresses)
        spool = Spool(
            data / "spool",
            head,
            settings.spool_bytes,
            age_s=settings.spool_age_s,
            spare=settings.spare_bytes,
            now=lambda: clock.monotonic_ns() / SECOND,
        )
        self._keeper = Keeper(spool)
        self._batcher = Batcher(
            loop, self._boot, begun.catalogue, settings.flush, self._on_batch, self._keeper.lose
        )
        self._reach = Reach(
            {device: site.connection_of(device) for device in site.devices},
            clock,
            self._lanes.send,
        )
        self._outbox = Outbox(
            data / "outbox",
            settings.outbox_bytes,
            self._on_file,
        )
        self._shelf: Shelf | None = None
        self._to_send = asyncio.Event()
        self._recorder = self._make_recorder(loop, site)
        self._answers: dict[str, str] = {}
        self._newest: Newest | None = None
        if settings.door is not None:
            self._newest = Newest(roster.numbers(site), self._batcher, clock.monotonic_ns)
        outlets = self._make_outlets(site)
        make = partial(self._make_adapter, loop, outlets)
        adapters = {each.name: make(each) for each in shares_of(site, roster)}
        self._adapter = self._make_many(site, adapters)
        self._voice.adapter = self._adapter
        self._voice.recorder = self._recorder
        interlocks = Interlocks(
            site,
            self._adapter,
            self._voice,
            lambda label, steps: self._sequences.begin(label, steps),
            clock.monotonic_ns(),
            clock.wall_ns,
        )
        self._control = Control(
            site,
            clock,
            self._voice,
            self._adapter,
            Epochs(data / "epochs.json").next,
            KeptStops(data / "stops.json"),
            self._on_disk,
            interlocks,
        )
        self._pacer = Pacer(loop, clock, self._control)
        self._commanding = Commanding(
            site,
            clock,
            self._adapter,
            Journal(data / "commands.jsonl"),
            self._on_disk,
            self._lanes.send,
            lambda device, command, args: interlocks.refusal(
                device, command, clock.monotonic_ns(), args
            ),
            interlocks.commanded,
            lambda device, command: interlocks.hold(device, command, clock.monotonic_ns()),
            lambda device: interlocks.ended(device, clock.monotonic_ns()),
        )
        self._sequences: Sequences = Sequences(self._commanding, self._voice, self._boot)
        self.door = self._make_door(site)
        parts = Parts(
            self._boot, clock, roster, self._batcher, self._keeper, self._reach, self._adapter,
            adapters, make, interlocks, self._control, self._pacer.touch, self._commanding,
            lambda: self._sequences.running, self._newest, self._recorder,
            () if self.door is None else (self.door.redescribe,),
        )  # fmt: skip
        self._exchange = Exchange(begun, parts, self._lanes.send, self._begin_again)
        self._changing = Changing(
            copy, settings.accepts, hashlib.sha256(settings.key.encode()).hexdigest(), data,
            self._exchange, self._lanes.send, self._voice, self._on_disk,
        )  # fmt: skip
        self._desk = FrontDesk(
            self._boot,
            self._control,
            self._pacer,
            self._commanding,
            self._keeper,
            self._adapter,
            self._voice,
            self._lanes,
            self._reach,
            self._recorder,
            self._changing,
            pictures=self._pictures,
        )
        self.looks.on_held = lambda: loop.call_soon_threadsafe(self._desk.look)
        self._trust = Trust(settings.hub)

    @property
    def _site(self) -> Site:
        """The description that counts now."""
        return self._exchange.now.site

    def _make_door(self, site: Site) -> Door | None:
        """Make the door for founding clients, where it is asked for.

        Raises:
            SettingsError: its certificate or token cannot be had.

        """
        settings = self._settings
        if settings.door is None or self._newest is None:
            return None
        keys = keys_of(settings.door, settings.data)
        return Door(
            settings.door, keys, site, self._clock, self._commanding, self._newest,
            self._answers, self._voice,
        )  # fmt: skip

    def _make_outlets(self, site: Site) -> Outlets:
        return Outlets(
            self._clock, self._newest or self._batcher, self._pictures, self._voice,
            self._settings.folder, self._settings.domain, self._answers, raw=self._recorder,
            frames=FrameTaker(
                self._settings.data / "taking", self._outbox, self._voice, self._clock, self._files
            ),
            files=WholeFiles(
                self._settings.data / "taking", self._outbox, self._voice, self._clock,
                self._files, site.name, site.place,
            ),
            site=site.name,
        )  # fmt: skip

    def _make_adapter(
        self, loop: asyncio.AbstractEventLoop, outlets: Outlets, share: Share
    ) -> tuple[Adapter, Post]:
        post = Post(share.name, loop, self._reach)
        post.on_found = partial(self._on_found, share.name)
        return adapter_of(share, outlets, post), post

    def _make_many(self, site: Site, adapters: Mapping[str, tuple[Adapter, Post]]) -> Many:
        return Many(
            {device: site.connection_of(device) for device in site.devices},
            dict(adapters),
            self._reach,
            self._voice,
            lambda devices: self._control.robot_lost(devices),
            lambda devices: self._control.robot_back(devices),
        )

    def _make_recorder(self, loop: asyncio.AbstractEventLoop, site: Site) -> Recorder | None:
        plan = site.recording
        if plan is None:
            return None
        try:
            from talaia.gateway.adapters.ros2_requests import class_of
            from talaia.gateway.recording.definitions import definition_of
            from talaia.gateway.recording.mcap_file import recover
            from talaia.gateway.recording.recorder import Recorder
        except ImportError as error:
            raise SettingsError(
                f"the description names topics to record, and they cannot be ({error}); "
                "install talaia[recording]"
            ) from error
        settings = self._settings
        self._shelf = shelf = Shelf(
            settings.data / "recordings", round(plan.disk_mb * 1e6), settings.spare_bytes
        )
        shelf.open(recover)
        self._to_send.set()

        def fields_of(name: str) -> dict[str, str]:
            fields: dict[str, str] = class_of(name, "recording").get_fields_and_field_types()
            return fields

        def tell_state(state: RecordState) -> None:
            loop.call_soon_threadsafe(self._lanes.send, state)

        def finished() -> None:
            loop.call_soon_threadsafe(self._to_send.set)

        return Recorder(
            plan,
            site.recorded(),
            shelf,
            self._clock,
            lambda name: definition_of(name, fields_of),
            tell_state,
            self._voice,
            finished,
        )

    def _on_found(self, connection: str, devices: Mapping[str, Device]) -> None:
        """Keep what was found; if any of it is new, end so as to begin again with it."""
        site = self.redescribed or self._site
        site = joined(site, connection, devices, kept_of(self._settings.data, connection))
        new = [
            name for name, device in site.devices.items() if device != self._site.devices.get(name)
        ]
        if not new:
            return
        log.info("%s: found %s; the description is made anew", connection, ", ".join(new))
        try:
            keep_found(self._settings.data, connection, devices)
        except OSError as error:
            log.warning("%s: what was found cannot be kept: %s", connection, error)
        self._begin_again(site)

    def _begin_again(self, site: Site) -> None:
        """End in favour of another gateway with this description, once nothing moves."""
        self.redescribed = site
        self._again.set()

    async def _until_again(self) -> None:
        """Wait until there is a new description and nothing moves for it to disturb."""
        await self._again.wait()
        while self._control.busy or self._commanding.busy or self._sequences.busy:  # noqa: ASYNC110 - rare, and told by nobody
            await asyncio.sleep(0.2)

    def _on_batch(self, record: Record) -> None:
        self._lanes.live(record.body, record.first, record.end)
        self._keeper.append(record)

    def _on_file(self) -> None:
        """Tell that a file waits; from the thread of files."""
        self._loop.call_soon_threadsafe(self._to_send.set)

    async def _on_disk(self, work: Callable[[], None]) -> None:
        await asyncio.get_running_loop().run_in_executor(self._disk, work)

    # ── running ──

    async def run(self, ended: asyncio.Event) -> None:
        """Run until ``ended`` is set, or there is a new description; then stop and close all."""
        self._pacer.touch()
        if self._recorder is not None:
            self._recorder.start()
        parts = [self._adapter.run, self._run_link, self._run_media, self._run_files]
        parts.append(self._run_sync)
        parts.append(partial(watch_stalls, self._clock, self._batcher.missed))
        parts.append(self._changing.watch)
        if self.door is not None:
            parts.append(self.door.run)
        tasks = [asyncio.ensure_future(self._until_cancelled(part)) for part in parts]
        waiting = asyncio.ensure_future(ended.wait())
        again = asyncio.ensure_future(self._until_again())
        try:
            await asyncio.wait([waiting, again, *tasks], return_when=asyncio.FIRST_COMPLETED)
        finally:
            waiting.cancel()
            again.cancel()
            # The zero goes out while there is still an adapter to carry it.
            self._control.halt()
            await asyncio.sleep(0.05)
            # An adapter that ends has no readings any more: that is no unsafe weather.
            self._pacer.close()
            for task in reversed(tasks):
                task.cancel()
            results = await asyncio.gather(*tasks, return_exceptions=True)
            await self.close()
        for result in results:
            if isinstance(result, Exception):
                raise result

    async def close(self) -> None:
        """Release everything; what waits is on disk then."""
        self._pacer.close()
        await self._sequences.close()
        if self._recorder is not None:
            await asyncio.to_thread(self._recorder.close)
        self._batcher.flush()
        await self._desk.close()
        await self._keeper.close()
        self._disk.shutdown(wait=True)
        self._files.shutdown(wait=True)
        os.close(self._lock)

    async def _until_cancelled(self, part: Callable[[], Awaitable[None]]) -> None:
        with contextlib.suppress(asyncio.CancelledError):
            await part()

    def _hello(self) -> Hello:
        now, self._told = self._exchange.now, self._exchange.turn
        return Hello(
            version=__version__,
            site=now.site.site,
            boot=self._boot,
            description=now.said,
            catalogue=now.catalogue,
            time_us=self._clock.wall_ns() // 1000,
            source=deflated(now.source) if now.source else b"",
            accepts=self._settings.accepts if now.source else Accepts.NO,
        )

    async def _run_link(self) -> None:
        link = LinkRun(
            self._settings, self._trust, self._clock, self._lanes, self._wake, self._desk
        )

        outage = Outage()

        def beside(welcome: Welcome) -> asyncio.Task[None]:
            outage.back()
            self._exchange.said_since(self._told)
            log.debug("the hub has %d samples of this run", welcome.acked)
            catchup = CatchUp(
                self._keeper,
                self._lanes,
                self._boot,
                lambda: self._exchange.now.catalogue,
                self._settings.backfill_bytes,
            )
            return asyncio.ensure_future(catchup.run(self._batcher.next))

        await keep_dialling(
            "the hub", lambda: link.once(self._hello(), beside), outage, self._clock
        )

    async def _run_media(self) -> None:
        outage = Outage()

        def up() -> None:
            if outage.back():
                log.info("the hub's media side is back")

        async def once() -> None:
            await run_media(self._settings, self._trust, self._clock, self._pictures, up)

        desk = self._desk
        await keep_dialling(
            "the hub's media side",
            lambda: beside_link(desk.linked, lambda: desk.links, once),
            outage,
            self._clock,
        )

    async def _run_files(self) -> None:
        """Hand pictures and recordings over, while there is a link and something waits."""
        plan, shelf, desk = self._site.recording, self._shelf, self._desk
        lanes = [Lane("pictures", self._outbox, self._settings.upload_bytes)]
        if plan is not None and shelf is not None:
            lanes.append(Lane("recordings", shelf, plan.upload * 1000))
        outage = Outage()

        def up() -> None:
            if outage.back():
                log.info("the hub takes files again")

        def refused(offer: FileOffer | ArchiveOffer, why: str) -> None:
            device = offer.device if isinstance(offer, ArchiveOffer) else ""
            said = f"the hub does not take {offer.id}: {why}"
            self._voice.tell("file_refused", said, device=device)

        sending = Sending(lambda: self._lanes.busy, up, refused)

        async def once() -> None:
            await send_files(self._settings, self._trust, lanes, sending)

        def waiting() -> bool:
            return any(lane.source.offers() for lane in lanes)

        async def waited() -> None:
            await self._to_send.wait()
            self._to_send.clear()
            try:
                await beside_link(desk.linked, lambda: desk.links, once)
            except BaseException:
                self._to_send.set()
                raise
            # A link that took the loss upon itself: what is left waits for the next one.
            if await asyncio.to_thread(waiting):
                self._to_send.set()

        # What a run before has left.
        self._to_send.set()
        await keep_dialling("the hub's side for files", waited, outage, self._clock)

    async def _run_sync(self) -> None:
        while True:
            await asyncio.sleep(self._settings.sync)
            await self._keeper.sync()


async def _serve(site: Site, settings: Settings, copy: OwnCopy) -> None:
    ended = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, ended.set)
    await serve(site, settings, ended, copy)


async def serve(
    site: Site, settings: Settings, ended: asyncio.Event, copy: OwnCopy | None = None
) -> None:
    """Run gateways until ``ended``: one after the other as devices are found.

    With a ``copy`` the description follows its file; see `OwnCopy`.
    """
    if copy is not None:
        copy.counts(site, copy.text)
    following: Site | None = with_kept(settings.data, site)
    while following is not None and not ended.is_set():
        gateway = Gateway(following, settings, SystemClock(), copy)
        await gateway.run(ended)
        following = gateway.redescribed


def main(argv: Sequence[str]) -> int:
    """Run a gateway until SIGINT or SIGTERM; 0 after a clean end, 2 if it cannot start."""
    if argv and argv[0] == "enrol":
        return enrol.main(argv[1:])
    arguments = parsed(argv)
    logging.basicConfig(
        level=logging.DEBUG if arguments.verbose else logging.INFO,
        format="%(asctime)s %(levelname)s %(name)s: %(message)s",
    )
    logging.getLogger("websockets").setLevel(logging.WARNING)
    try:
        # A thread that decodes may hold the interpreter this long before a driving frame gets it;
        # Python's own 5 ms would be the largest part of the frame's way to the robot.
        sys.setswitchinterval(0.0005)
        copy = OwnCopy(arguments.site)
        site = raise_first(site_in(copy.text, arguments.site))
        settings = settings_of(arguments, site)
        with asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner:
            runner.run(_serve(site, settings, copy))
    except TalaiaError as error:
        sys.stderr.write(f"talaia gateway: {error}\n")
        return 2
    return 0
