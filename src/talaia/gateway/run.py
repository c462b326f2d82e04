"""The gateway's process: builds every part, runs them in one task group, ends them in order."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import fcntl
import hashlib
import logging
import os
import random
import secrets
import signal
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import uvloop

from talaia import __version__
from talaia.clock import SystemClock
from talaia.errors import TalaiaError
from talaia.gateway.adapters.nobody import Nobody
from talaia.gateway.batching import Batcher
from talaia.gateway.commanding import Commanding, Journal
from talaia.gateway.control import Control
from talaia.gateway.desk import FrontDesk, Pacer, Voice
from talaia.gateway.errors import AdapterLost, KeyRefused, LinkLost, SettingsError, SpoolError
from talaia.gateway.keep import Epochs, KeptStops
from talaia.gateway.settings import HubAddress, Settings
from talaia.gateway.spool.journal import Head, Spool
from talaia.gateway.spool.keeper import Keeper
from talaia.gateway.uplink.backoff import Backoff
from talaia.gateway.uplink.catchup import CatchUp
from talaia.gateway.uplink.connection import LinkRun, run_media
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
        self._lock = _locked(data)
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
            self._boot, self._control, self._pacer, self._commanding, self._keeper, self._adapter
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
            began = self._clock.monotonic_ns()
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
            log.debug("adapter ran for %d ns", self._clock.monotonic_ns() - began)
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

        def beside(welcome: Welcome) -> asyncio.Task[None]:
            log.debug("the hub has %d samples of this run", welcome.acked)
            catchup = CatchUp(
                self._keeper,
                self._lanes,
                self._boot,
                self._catalogue,
                self._settings.backfill_bytes,
            )
            return asyncio.ensure_future(catchup.run(self._batcher.next))

        await self._keep_dialling("the hub", lambda: link.once(self._hello(), beside))

    async def _run_media(self) -> None:
        async def once() -> None:
            # After the link, so that what hinders both is said once and tried once.
            await self._desk.linked.wait()
            await run_media(self._settings, self._trust, self._clock, self._pictures)

        await self._keep_dialling("the hub's media side", once)

    async def _keep_dialling(self, what: str, once: Callable[[], Awaitable[None]]) -> None:
        backoff = Backoff(random.SystemRandom().random)
        said = ""
        while True:
            began = self._clock.monotonic_ns()
            refused = False
            try:
                await once()
            except KeyRefused as error:
                refused, problem = True, str(error)
            except LinkLost as error:
                problem = str(error)
            else:
                problem = "the link ended"
            lasted = (self._clock.monotonic_ns() - began) / 1e9
            # Said once for each reason, and anew after a link that stood.
            if problem != said or lasted >= Backoff.STABLE_S:
                said = problem
                log.warning("%s: %s; trying again", what, problem)
            await asyncio.sleep(backoff.after(lasted, refused=refused))

    async def _run_sync(self) -> None:
        while True:
            await asyncio.sleep(self._settings.sync)
            await self._keeper.sync()


def _locked(data: Path) -> int:
    """Make the data folder this process's own.

    Raises:
        SpoolError: another gateway uses it, or it cannot be made.

    """
    try:
        data.mkdir(parents=True, exist_ok=True, mode=0o700)
        lock = os.open(data / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    except OSError as error:
        raise SpoolError(f"the data folder {data} cannot be used: {error}") from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(lock)
        raise SpoolError(
            f"the data folder {data} is used by another gateway; give another --data"
        ) from error
    return lock


# ── command line ──


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(2, f"talaia gateway: {message}\n")


def _arguments(argv: Sequence[str]) -> argparse.Namespace:
    parser = _Parser(prog="talaia gateway", description="Run the gateway beside a robot.")
    parser.add_argument("site", type=Path, help="site description (YAML)")
    parser.add_argument("--hub", required=True, metavar="URL", help="wss://host:port")
    parser.add_argument("--key-file", required=True, type=Path, metavar="FILE")
    trust = parser.add_mutually_exclusive_group()
    trust.add_argument("--fingerprint", default="", metavar="HEX", help="SHA-256 of the hub's cert")
    trust.add_argument("--ca", type=Path, metavar="FILE", help="certificate authorities (PEM)")
    parser.add_argument("--allow-plain", action="store_true", help="permit ws:// on loopback")
    parser.add_argument("--data", type=Path, metavar="DIR", help="what must survive a restart")
    parser.add_argument("--ros-domain", type=int, metavar="N", help="overrides the description's")
    parser.add_argument("--verbose", action="store_true", help="log more")
    return parser.parse_args(argv)


def _settings(arguments: argparse.Namespace, site: Site) -> Settings:
    try:
        key = arguments.key_file.read_text().strip()
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"--key-file {arguments.key_file}: {error}") from error
    if not key or any(ord(each) <= 32 or ord(each) > 126 for each in key):
        raise SettingsError(f"--key-file {arguments.key_file}: expected the key on one line")
    state = os.environ.get("XDG_STATE_HOME") or str(Path.home() / ".local" / "state")
    return Settings(
        hub=HubAddress.checked(
            arguments.hub,
            fingerprint=arguments.fingerprint,
            ca=arguments.ca,
            allow_plain=arguments.allow_plain,
        ),
        key=key,
        data=arguments.data or Path(state) / "talaia" / "gateway" / site.site,
        domain=arguments.ros_domain,
    )


async def _serve(site: Site, settings: Settings) -> None:
    ended = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, ended.set)
    await Gateway(site, settings, SystemClock()).run(ended)


def main(argv: Sequence[str]) -> int:
    """Run a gateway until SIGINT or SIGTERM; 0 after a clean end, 2 if it cannot start."""
    arguments = _arguments(argv)
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
        settings = _settings(arguments, site)
        with asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner:
            runner.run(_serve(site, settings))
    except TalaiaError as error:
        sys.stderr.write(f"talaia gateway: {error}\n")
        return 2
    return 0
