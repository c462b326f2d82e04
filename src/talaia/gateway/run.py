"""The gateway, in one place: builds every part, runs them in one task group, ends them in order."""

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
from typing import TYPE_CHECKING

import uvloop

from talaia import __version__
from talaia.clock import SystemClock
from talaia.errors import TalaiaError
from talaia.gateway import enrol
from talaia.gateway.adapters.nobody import Nobody
from talaia.gateway.arguments import parsed, settings_of
from talaia.gateway.batching import Batcher
from talaia.gateway.commanding import Commanding, Journal
from talaia.gateway.control import Control
from talaia.gateway.desk import FrontDesk, Pacer, Voice
from talaia.gateway.errors import AdapterLost, SettingsError
from talaia.gateway.keep import Epochs, KeptStops, locked
from talaia.gateway.spool.journal import Head, Spool
from talaia.gateway.spool.keeper import Keeper
from talaia.gateway.uplink.catchup import CatchUp
from talaia.gateway.uplink.connection import LinkRun, run_media
from talaia.gateway.uplink.dialling import Outage, beside_link, keep_dialling
from talaia.gateway.uplink.lanes import Lanes
from talaia.gateway.uplink.pictures import Pictures
from talaia.gateway.uplink.tls import Trust
from talaia.model.check import raise_first
from talaia.model.load import dump_site, read_site
from talaia.wire.frames import Hello

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from talaia.clock import Clock
    from talaia.gateway.ports import Adapter
    from talaia.gateway.settings import Settings
    from talaia.gateway.spool.segment import Record
    from talaia.model.site import Site
    from talaia.wire.frames import Welcome

__all__ = ["Gateway", "catalogue_of", "main", "new_boot"]

log = logging.getLogger(__name__)
ADAPTER_AGAIN_S = 5.0
END_S = 1.5


def catalogue_of(site: Site) -> str:
    """Name the channel list: the same list has the same name, in every run."""
    listed = "\n".join(f"{each.address} {each.text:d}" for each in site.channels())
    return hashlib.sha256(listed.encode()).hexdigest()[:16]


def new_boot() -> str:
    """Name this run of the gateway; later runs sort behind while the clock is right."""
    return f"{time.time_ns() // 1_000_000:012x}-{secrets.token_hex(4)}"


class Gateway:
    """All parts of one gateway, built for one event loop."""

    def __init__(self, site: Site, settings: Settings, clock: Clock) -> None:
        """Build every part and take up what an earlier run left in the data folder.

        Raises:
            SpoolError: the data folder cannot be used.
            SettingsError: the description needs ROS 2 and there is none.

        """
        self._site, self._settings, self._clock = site, settings, clock
        self._boot, self._catalogue = new_boot(), catalogue_of(site)
        loop = asyncio.get_running_loop()
        data = settings.data
        self._lock = locked(data)
        # One thread for the small files: their writes keep their order.
        self._disk = ThreadPoolExecutor(1, "talaia-disk")
        self._wake = asyncio.Event()
        self._lanes = Lanes(self._wake.set)
        self._voice = Voice(loop, clock, self._lanes)
        self._pictures = Pictures(loop)
        head = Head(self._boot, self._catalogue, [each.address for each in site.channels()])
        self._keeper = Keeper(Spool(data / "spool", head, settings.spool_bytes))
        self._batcher = Batcher(
            loop, self._boot, self._catalogue, settings.flush, self._on_batch, self._keeper.lose
        )
        self._adapter = self._make_adapter()
        self._voice.adapter = self._adapter
        self._control = Control(
            site,
            clock,
            self._voice,
            self._adapter,
            Epochs(data / "epochs.json").next,
            KeptStops(data / "stops.json"),
            self._on_disk,
        )
        self._pacer = Pacer(loop, clock, self._control)
        self._commanding = Commanding(
            site,
            clock,
            self._adapter,
            Journal(data / "commands.jsonl"),
            self._on_disk,
            self._lanes.send,
        )
        self._desk = FrontDesk(
            self._boot,
            self._control,
            self._pacer,
            self._commanding,
            self._keeper,
            self._adapter,
            self._voice,
        )
        self._trust = Trust(settings.hub)

    def _make_adapter(self) -> Adapter:
        if self._site.ros2 is None:
            return Nobody()
        try:
            from talaia.gateway.adapters.ros2 import Ros2
        except ImportError as error:
            raise SettingsError(
                f"the description names ROS 2, and it cannot be used here ({error}); "
                "install talaia[ros2], or source the ROS installation's setup file"
            ) from error
        return Ros2(
            self._site,
            self._clock,
            self._batcher,
            self._pictures,
            self._voice,
            self._settings.domain,
        )

    def _on_batch(self, record: Record) -> None:
        self._lanes.live(record.body, record.first, record.end)
        self._keeper.append(record)

    async def _on_disk(self, work: Callable[[], None]) -> None:
        await asyncio.get_running_loop().run_in_executor(self._disk, work)

    # ── running ──

    async def run(self, ended: asyncio.Event) -> None:
        """Run until ``ended`` is set, then stop the robot and close all."""
        self._pacer.touch()
        tasks = [
            asyncio.ensure_future(self._until_cancelled(part))
            for part in (self._run_adapter, self._run_link, self._run_media, self._run_sync)
        ]
        waiting = asyncio.ensure_future(ended.wait())
        try:
            await asyncio.wait([waiting, *tasks], return_when=asyncio.FIRST_COMPLETED)
        finally:
            waiting.cancel()
            # The zero goes out while there is still an adapter to carry it.
            self._control.halt()
            await asyncio.sleep(0.05)
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
        self._batcher.flush()
        await self._desk.close()
        await self._keeper.close()
        self._disk.shutdown(wait=True)
        os.close(self._lock)

    async def _until_cancelled(self, part: Callable[[], Awaitable[None]]) -> None:
        with contextlib.suppress(asyncio.CancelledError):
            await part()

    async def _run_adapter(self) -> None:
        lost = False
        while True:
            run = asyncio.ensure_future(self._adapter.run())
            try:
                if lost:
                    done, _ = await asyncio.wait([run], timeout=1.0)
                    if not done:
                        lost = False
                        log.info("ROS 2 is back")
                        self._voice.tell("adapter_back", "ROS 2", good=True)
                await run
            except AdapterLost as error:
                if not lost:
                    log.warning("%s; trying again every %g s", error, ADAPTER_AGAIN_S)
                    self._voice.tell("adapter_lost", str(error))
                lost = True
            finally:
                run.cancel()
                await asyncio.gather(run, return_exceptions=True)
            await asyncio.sleep(ADAPTER_AGAIN_S)

    def _hello(self) -> Hello:
        return Hello(
            version=__version__,
            site=self._site.site,
            boot=self._boot,
            description=dump_site(self._site),
            catalogue=self._catalogue,
            time_us=self._clock.wall_ns() // 1000,
        )

    async def _run_link(self) -> None:
        link = LinkRun(
            self._settings, self._trust, self._clock, self._lanes, self._wake, self._desk
        )

        outage = Outage()

        def beside(welcome: Welcome) -> asyncio.Task[None]:
            outage.back()
            log.debug("the hub has %d samples of this run", welcome.acked)
            catchup = CatchUp(
                self._keeper,
                self._lanes,
                self._boot,
                self._catalogue,
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

    async def _run_sync(self) -> None:
        while True:
            await asyncio.sleep(self._settings.sync)
            await self._keeper.sync()


async def _serve(site: Site, settings: Settings) -> None:
    ended = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, ended.set)
    await Gateway(site, settings, SystemClock()).run(ended)


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
        site = raise_first(read_site(arguments.site))
        settings = settings_of(arguments, site)
        with asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner:
            runner.run(_serve(site, settings))
    except TalaiaError as error:
        sys.stderr.write(f"talaia gateway: {error}\n")
        return 2
    return 0
