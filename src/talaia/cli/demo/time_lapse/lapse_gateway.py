"""The link of a time lapse with its hub, in real time; what is decided is decided in its thread."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING

from talaia.cli.demo.time_lapse.lapse_thread import LapseThread
from talaia.cli.demo.time_lapse.simulated_gateway import HubSide
from talaia.clock import SystemClock
from talaia.gateway.assembly.description import DescriptionPart
from talaia.gateway.assembly.foundation import FoundationPart
from talaia.gateway.assembly.recording import RecordingPart
from talaia.gateway.assembly.samples import SamplesPart
from talaia.gateway.assembly.taps import TapsPart
from talaia.gateway.assembly.video import VideoPart
from talaia.gateway.uplink.files import FileLane
from talaia.gateway.uplink.key_prover import RESUME_FILE, KeyProver
from talaia.gateway.uplink.links import HubConnection, keep_files, keep_link
from talaia.gateway.uplink.tls import HubTrust
from talaia.wire.frames import Ack, ResendRequest

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.cli.demo.time_lapse.lapse_thread import LapseSettings
    from talaia.gateway.reload.current_description import PreparedDescription
    from talaia.gateway.settings import GatewaySettings
    from talaia.gateway.spool.spool_thread import SpoolThread
    from talaia.gateway.uplink.send_lanes import SendLanes
    from talaia.model.site import Site
    from talaia.wire.frames import FromHub, Welcome

__all__ = ["LapseGateway"]


class _Description:
    """A description that stays."""

    turn = 0

    def __init__(self, now: PreparedDescription) -> None:
        self.now = now

    def report_since(self, turn: int) -> None:
        """There is no other."""


class _Dispatcher:
    """A `HubDispatcher`: samples are acknowledged here, all else concerns the night."""

    def __init__(
        self,
        boot: str,
        spool: SpoolThread,
        lanes: SendLanes,
        tell: Callable[[FromHub | bool], None],
    ) -> None:
        self._boot, self._spool, self._lanes, self._tell = boot, spool, lanes, tell
        self.linked = asyncio.Event()
        self.links = 0

    def link_up(self, welcome: Welcome) -> None:
        self.linked.set()
        self.links += 1
        self._spool.rewind_acknowledged(welcome.acked)
        self._spool.acknowledge_samples(self._boot, welcome.acked)
        self._tell(True)  # noqa: FBT003 - the link stands

    def link_lost(self) -> None:
        self.linked.clear()
        self._tell(False)  # noqa: FBT003

    def handle(self, message: FromHub) -> None:
        match message:
            case Ack():
                self._spool.acknowledge_samples(message.boot, message.below)
                self._lanes.acks += 1
            case ResendRequest():
                self._lanes.owe(message.boot, message.first, message.below)
            case _:
                self._tell(message)


class LapseGateway:
    """Built for one event loop, which lives in real time."""

    def __init__(self, *, site: Site, settings: GatewaySettings, lapse: LapseSettings) -> None:
        """Take up what an earlier run left.

        Raises:
            SpoolError: the data folder cannot be used.
            ValueError: the site has no place.

        """
        clock = SystemClock()
        base = FoundationPart(settings=settings, clock=clock)
        description = DescriptionPart(base=base, site=site, file=None)
        samples = SamplesPart(base=base, description=description)
        recording = RecordingPart(base=base, description=description)
        taps = TapsPart(base=base)
        video = VideoPart(base=base, description=description, recording=recording, taps=taps)
        self._parts = base, description, samples, recording, taps, video
        self._failed = asyncio.Event()

        def note_failure() -> None:
            base.loop.call_soon_threadsafe(self._failed.set)

        self._thread = LapseThread(
            site=description.site,
            numbers=description.numbering.numbers_of(description.site),
            samples=samples.sink,
            hub=HubSide(base.send_threadsafe, video.outbox, base.arrivals),
            data=settings.data,
            settings=lapse,
            failed=note_failure,
        )
        dispatcher = _Dispatcher(base.boot, samples.spool, base.lanes, self._thread.take_message)
        prover = KeyProver(
            key=settings.key,
            site=site.site,
            path=settings.data / RESUME_FILE,
            on_disk=base.run_on_disk,
        )
        hub = HubConnection(settings, HubTrust(settings.hub), prover, clock, dispatcher)
        self._tasks: dict[str, Callable[[], Awaitable[None]]] = {
            **samples.tasks(),
            "link": partial(
                keep_link,
                hub=hub,
                boot=base.boot,
                reload=_Description(description.current.now),
                lanes=base.lanes,
                wake=base.frame_waiting,
                batcher=samples.batcher,
                spool=samples.spool,
            ),
            "files": partial(
                keep_files,
                hub=hub,
                files=[FileLane("pictures", video.outbox, settings.upload_bytes)],
                to_send=base.file_waiting,
                lanes=base.lanes,
                events=base.events,
            ),
        }

    async def run(self, ended: asyncio.Event) -> None:
        """Run until ``ended`` is set; a part that fails ends it, and is raised.

        Raises:
            RuntimeError: the thread failed; its log says why.

        """
        for part in self._parts:
            part.start()
        self._thread.start()
        tasks = [asyncio.create_task(_run(run), name=name) for name, run in self._tasks.items()]
        asked = asyncio.create_task(ended.wait())
        failed = asyncio.create_task(self._failed.wait())
        try:
            await asyncio.wait([asked, failed, *tasks], return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in (asked, failed, *tasks):
                task.cancel()
            results = await asyncio.gather(*tasks, return_exceptions=True)
            await asyncio.to_thread(self._thread.close)
            for part in reversed(self._parts):
                await part.close()
        for result in results:
            if isinstance(result, Exception):
                raise result
        if self._failed.is_set():
            raise RuntimeError("the time lapse failed")


async def _run(run: Callable[[], Awaitable[None]]) -> None:
    await run()
