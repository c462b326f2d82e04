"""The gateway put together: builds every part, runs them at once, ends them in order.

Long, because the parts are joined here and nowhere else.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import logging
import os
import secrets
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.actuation import Actuation
from talaia.gateway.adapters.catalog import adapter_of
from talaia.gateway.adapters.connection_scope import shares_of
from talaia.gateway.adapters.connectivity import DeviceReachability
from talaia.gateway.adapters.multi_adapter import ConnectionStatus, MultiAdapter
from talaia.gateway.assembly.recorder_setup import RecorderCallbacks, taping_of
from talaia.gateway.detection.camera_detection import (
    DetectionOutputs,
    ObjectDetection,
    ReadingsWithDetections,
)
from talaia.gateway.detection.sighting_reports import DetectionReporter
from talaia.gateway.fits.frame_taker import FrameTaker
from talaia.gateway.fits.outbox import ArchiveOutbox
from talaia.gateway.fits.whole_files import WholeFiles
from talaia.gateway.freeze_watchdog import watch_stalls
from talaia.gateway.legacy.messages import NewestValues
from talaia.gateway.legacy.server import LegacyServer, keys_of
from talaia.gateway.notices.own_notices import OwnNotices
from talaia.gateway.persistence import locked
from talaia.gateway.ports import AdapterContext
from talaia.gateway.reload.apply import DescriptionReload, ReloadTargets, prepared
from talaia.gateway.reload.requests import ChangeRequests
from talaia.gateway.reload.restart import GatewayRestart
from talaia.gateway.safety.supervision import Heartbeats, Supervision
from talaia.gateway.samples.absence_gaps import NOT_HEARD, NOT_RUNNING, absence, watch_first_heard
from talaia.gateway.samples.batching import Batcher
from talaia.gateway.samples.channel_numbering import ChannelNumbering
from talaia.gateway.spool.journal import SegmentHead, Spool
from talaia.gateway.spool.progress_mark import machine_run
from talaia.gateway.spool.spool_thread import SpoolThread
from talaia.gateway.uplink.files import FileLane
from talaia.gateway.uplink.lanes import SendLanes
from talaia.gateway.uplink.links import HubConnection, keep_files, keep_link, keep_media
from talaia.gateway.uplink.message_dispatcher import MessageDispatcher, OutputRouter
from talaia.gateway.uplink.pictures import PictureUplink
from talaia.gateway.uplink.tls import HubTrust
from talaia.gateway.video.frame_source import FrameSource
from talaia.gateway.watchdog.feeding import Watchdog
from talaia.model.derived_signals import with_counts
from talaia.model.interlocks.unguarded import unguarded_notice
from talaia.model.yaml_text.load import dump_site
from talaia.objects.worker import Worker
from talaia.service_manager import ServiceManager
from talaia.wire.frames import Event

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.clock import Clock
    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import Adapter
    from talaia.gateway.reload.apply import PreparedDescription
    from talaia.gateway.reload.description_file import DescriptionFile
    from talaia.gateway.settings import GatewaySettings
    from talaia.gateway.spool.segment import SampleRecord as SpoolRecord
    from talaia.gateway.watchdog.closing import Record
    from talaia.model.site import Site
    from talaia.wire.frames import RecorderState

__all__ = ["Gateway"]

log = logging.getLogger(__name__)


class Gateway:
    """All parts of one gateway, built for one event loop.

    Attributes:
        looks: whoever looks at cameras here (a detector) takes pictures from it.
        taping: what records.
        door: for founding clients, where it is asked for.

    """

    def __init__(
        self,
        site: Site,
        settings: GatewaySettings,
        clock: Clock,
        copy: DescriptionFile | None = None,
        manager: ServiceManager | None = None,
    ) -> None:
        """Build every part and take up what an earlier run left in the data folder.

        Args:
            site: the description, with the devices that were found.
            settings: see `GatewaySettings`.
            clock: every part's.
            copy: the description's file; none leaves it as it is until the end.
            manager: told that the gateway runs and supervises; none where there is none.

        Raises:
            SpoolError: the data folder cannot be used.
            SettingsError: the description names a connection that cannot be used here.

        """
        self._settings, self._clock = settings, clock
        site = with_counts(site)
        begun = prepared(site, copy.text if copy is not None and copy.editable else "")
        self._boot = _new_boot()
        self._renewal = GatewayRestart(settings.data, lambda: self._exchange.now.site)
        self._roster = roster = ChannelNumbering(site)
        self._loop = loop = asyncio.get_running_loop()
        self._lock = locked(settings.data)
        # One thread for the small files: their writes keep their order.
        self._disk = ThreadPoolExecutor(1, "talaia-disk")
        # Pictures and recordings are large: their disk work has a thread of its own.
        self._files = ThreadPoolExecutor(1, "talaia-files")
        self._wake, self._to_send = asyncio.Event(), asyncio.Event()
        self._lanes = SendLanes(self._wake.set)
        self._voice = OutputRouter(loop, clock, self._lanes)
        self.looks = FrameSource()
        self._keeper = self._make_keeper(begun)
        self._batcher = Batcher(
            loop, self._boot, begun.catalogue, settings.flush, self._on_batch, self._keeper.lose
        )
        self._tell_absence()
        if notice := unguarded_notice(site):
            log.warning("%s", notice)
            self._voice.tell("nothing_closes", notice)
        of = {device: site.connection_of(device) for device in site.devices}
        self._reach = DeviceReachability(of, clock, self._lanes.send)
        self._outbox = ArchiveOutbox(settings.data / "outbox", settings.outbox_bytes, self._on_file)
        ear = RecorderCallbacks(self._voice, self._on_recording, self._on_file, self._on_watched)
        self.taping = taping_of(site, settings, clock, ear)
        self._pictures = PictureUplink(loop, clock, self.looks, self.taping.films)
        self._answers: dict[str, str] = {}
        self._newest: NewestValues | None = None
        if settings.door is not None:
            self._newest = NewestValues(roster.numbers(site), self._batcher, clock.monotonic_ns)
        make = partial(self._make_adapter, self._make_outlets(site))
        adapters = {each.name: make(each) for each in shares_of(site, roster)}
        self._adapter = MultiAdapter(
            of,
            dict(adapters),
            self._reach,
            self._voice,
            lambda devices: self._acting.control.robot_lost(devices),
            lambda devices: self._acting.control.robot_back(devices),
        )
        self._voice.adapter = self._adapter
        self._voice.tapes = self.taping.tapes
        self._telling = DetectionReporter(settings.data / "sightings", self._lanes, self._files)
        self._seeing = self._make_seeing(site)
        self._acting = Actuation(
            site, self._boot, clock, self._voice, self._adapter,
            ReadingsWithDetections(self._adapter, self._seeing), settings.data, self._on_disk,
        )  # fmt: skip
        self.door = self._make_door(site)
        self._manager = manager or ServiceManager()
        self._watchdog = Watchdog(
            settings.data, settings.folder, settings.domain,
            lambda why: self._voice.note("watchdog_missing", "", why, "", good=False),
            notices=settings.notices,
        )  # fmt: skip
        self._watchdog.describe(begun.site, begun.said)
        interlocks = self._acting.interlocks
        self._heartbeats = Heartbeats(site, interlocks, self._adapter, self._voice)
        self._supervision = Supervision(
            clock, lambda: interlocks.judged_ns,
            (self._manager.feed_watchdog, self._watchdog.beat), self._heartbeats,
        )  # fmt: skip
        self._exchange = self._make_exchange(begun, adapters, make)
        self._changing = ChangeRequests(
            copy, settings.accepts, hashlib.sha256(settings.key.encode()).hexdigest(),
            settings.data, self._exchange, self._lanes.send, self._voice, self._on_disk,
        )  # fmt: skip
        self._desk = MessageDispatcher(
            self._boot, self._acting, self._keeper, self._adapter, self._voice, self._lanes,
            self._reach, self.taping.tapes, self._changing, self._pictures, self._telling,
        )  # fmt: skip
        self.looks.on_held = self._on_watched
        self._way = HubConnection(settings, HubTrust(settings.hub), clock, self._desk)

    @property
    def redescribed(self) -> Site | None:
        """The description to begin again with, after `run`; none at the end."""
        return self._renewal.site

    def _make_keeper(self, begun: PreparedDescription) -> SpoolThread:
        """Make the spool ready, with what an earlier run left in it.

        Raises:
            SpoolError: the data folder cannot be used.

        """
        settings, clock = self._settings, self._clock
        spool = Spool(
            settings.data / "spool",
            SegmentHead(self._boot, begun.catalogue, begun.addresses),
            settings.spool_bytes,
            age_s=settings.spool_age_s,
            spare=settings.spare_bytes,
            now=lambda: clock.monotonic_ns() / SECOND,
            wall_us=self._wall_us,
            machine=machine_run(),
        )
        return SpoolThread(spool)

    def _wall_us(self) -> int:
        return self._clock.wall_ns() // 1000

    def _tell_absence(self) -> None:
        """Record the time since the run before heard anything as a gap, if there was one."""
        former = self._keeper.former
        if former is not None:
            mono_s = self._clock.monotonic_ns() / SECOND
            span = absence(former, self._wall_us(), mono_s, machine_run())
            self._batcher.missed(*span, NOT_RUNNING)
            if 0 < former.deaf_us <= former.heard_us:
                # It ended before it could tell since when it heard all.
                self._batcher.missed(former.deaf_us, former.heard_us, NOT_HEARD)

    def _make_outlets(self, site: Site) -> AdapterContext:
        settings, clock = self._settings, self._clock
        taken = settings.data / "taking", self._outbox, self._voice, clock, self._files
        return AdapterContext(
            clock,
            self._newest or self._batcher,
            self._pictures,
            self._voice,
            settings.folder,
            settings.domain,
            self._answers,
            raw=self.taping.recorder,
            frames=FrameTaker(*taken),
            files=WholeFiles(*taken, site.name, site.place),
            site=site.name,
        )

    def _make_adapter(
        self, outlets: AdapterContext, share: ConnectionScope
    ) -> tuple[Adapter, ConnectionStatus]:
        post = ConnectionStatus(share.name, self._loop, self._reach)
        post.on_found = partial(self._renewal.found, share.name)
        return adapter_of(share, outlets, post), post

    def _make_seeing(self, site: Site) -> ObjectDetection:
        outlet = DetectionOutputs(
            self._newest or self._batcher, self._pictures.boxes, self._telling.take, self._voice
        )
        return ObjectDetection(
            site, self._roster.numbers(site), self.looks,
            lambda told: Worker(site.object_models, self._settings.folder, told),
            outlet, self._clock,
        )  # fmt: skip

    def _make_door(self, site: Site) -> LegacyServer | None:
        """Make the door for founding clients, where it is asked for.

        Raises:
            SettingsError: its certificate or token cannot be had.

        """
        settings = self._settings
        if settings.door is None or self._newest is None:
            return None
        keys = keys_of(settings.door, settings.data)
        return LegacyServer(
            settings.door, keys, site, self._clock, self._acting.commanding, self._newest,
            self._answers, self._voice,
        )  # fmt: skip

    def _make_exchange(
        self,
        begun: PreparedDescription,
        adapters: dict[str, tuple[Adapter, ConnectionStatus]],
        make: Callable[[ConnectionScope], tuple[Adapter, ConnectionStatus]],
    ) -> DescriptionReload:
        followers: list[Callable[[Site], None]] = [
            lambda after: self._seeing.redescribe(after, self._roster.numbers(after)),
            self._heartbeats.redescribe,
            lambda after: self._watchdog.describe(after, dump_site(after)),
        ]
        if self.door is not None:
            followers.append(self.door.redescribe)
        parts = ReloadTargets(
            self._boot, self._clock, self._roster, self._batcher, self._keeper, self._reach,
            self._adapter, adapters, make, self._acting, self._newest, self.taping.tapes,
            tuple(followers),
        )  # fmt: skip
        return DescriptionReload(begun, parts, self._lanes.send, self._renewal.begin)

    # ── what parts tell one another ──

    def _on_batch(self, record: SpoolRecord) -> None:
        self._lanes.live(record.body, record.first, record.end)
        self._keeper.append(record)

    def _on_file(self) -> None:
        """Tell that a file waits; from any thread."""
        self._loop.call_soon_threadsafe(self._to_send.set)

    def _on_recording(self, state: RecorderState) -> None:
        """Tell the hub how recording stands; from any thread."""
        self._loop.call_soon_threadsafe(self._lanes.send, state)

    def _on_watched(self) -> None:
        """Look at other cameras than before; from any thread."""
        self._loop.call_soon_threadsafe(self._desk.look)

    async def _on_disk(self, work: Callable[[], None]) -> None:
        await self._loop.run_in_executor(self._disk, work)

    # ── running ──

    async def run(self, ended: asyncio.Event) -> None:
        """Run until ``ended`` is set, or there is a new description; then stop and close all."""
        acting, lanes, settings = self._acting, self._lanes, self._settings
        # Before anything here moves: two must never move a roof.
        self._report_watchdog(await self._watchdog.take_over())
        acting.pacer.touch()
        if self.taping.tapes is not None:
            self.taping.tapes.start()
            # Cameras of which the last seconds are held.
            self._desk.look()
        pictures = FileLane("pictures", self._outbox, self._settings.upload_bytes)
        files = [pictures, *self.taping.lanes]
        parts: list[Callable[[], Awaitable[None]]] = [
            self._adapter.run,
            partial(
                keep_link, self._way, self._boot, self._exchange, lanes, self._wake,
                self._batcher, self._keeper,
            ),
            partial(keep_media, self._way, self._pictures),
            partial(keep_files, self._way, files, self._to_send, lanes, self._voice),
            partial(self._keeper.keep_syncing, self._settings.sync, self._wall_us),
            self._seeing.run,
            self._telling.run,
            partial(watch_stalls, self._clock, self._batcher.missed),
            self._supervision.run,
            self._keep_watchdog,
            self._changing.watch,
            acting.keep_written,
        ]  # fmt: skip
        if self._keeper.former is not None:
            heard, told = self._batcher.first_heard, (self._batcher.missed, self._keeper.all_heard)
            parts.append(partial(watch_first_heard, heard, self._clock, *told))
        if self.door is not None:
            parts.append(self.door.run)
        if settings.notices is not None:
            notices = OwnNotices(
                settings.notices, self._exchange.now.site.name, self._clock,
                self._desk.linked.is_set, self._voice,
            )  # fmt: skip
            self._voice.on_enclosure = notices.hear_enclosure
            parts.append(notices.run)
        tasks = [asyncio.ensure_future(_until_cancelled(part)) for part in parts]
        self._manager.report_ready()
        waiting = asyncio.ensure_future(ended.wait())
        again = asyncio.ensure_future(self._renewal.due(lambda: acting.busy))
        try:
            await asyncio.wait([waiting, again, *tasks], return_when=asyncio.FIRST_COMPLETED)
        finally:
            waiting.cancel()
            again.cancel()
            # The zero goes out while there is still an adapter to carry it.
            acting.control.halt()
            await asyncio.sleep(0.05)
            # An adapter that ends has no readings any more: that is no unsafe weather.
            acting.pacer.close()
            for task in reversed(tasks):
                task.cancel()
            results = await asyncio.gather(*tasks, return_exceptions=True)
            if not any(isinstance(result, Exception) for result in results):
                # One that ends by a fault of its own says no goodbye: its roof is closed. Nor does
                # one that begins anew: dead before it has, it leaves a watchdog behind.
                if ended.is_set():
                    await self._watchdog.goodbye()
                else:
                    self._watchdog.let_go()
            await self.close()
        for result in results:
            if isinstance(result, Exception):
                raise result

    async def _keep_watchdog(self) -> None:
        """Have a watchdog, and report what it did while this gateway stood still."""
        while True:
            await self._watchdog.keep(self._clock.monotonic_ns() / SECOND)
            self._report_watchdog(self._watchdog.records())
            await asyncio.sleep(1.0)

    def _report_watchdog(self, records: list[Record]) -> None:
        for each in records:
            log.warning("%s %s", each.kind, each.message)
            said, time_us = each.message[:2000], each.time_us
            self._lanes.send(Event(kind=each.kind, message=said, time_us=time_us, good=each.good))

    async def close(self) -> None:
        """Release everything; what waits is on disk then."""
        self._acting.pacer.close()
        await self._acting.sequences.close()
        if self.taping.tapes is not None:
            await asyncio.to_thread(self.taping.tapes.close)
        self._batcher.flush()
        await self._desk.close()
        await self._keeper.close()
        self._disk.shutdown(wait=True)
        self._files.shutdown(wait=True)
        os.close(self._lock)


async def _until_cancelled(part: Callable[[], Awaitable[None]]) -> None:
    with contextlib.suppress(asyncio.CancelledError):
        await part()


def _new_boot() -> str:
    """Name this run of the gateway; later runs sort behind while the clock is right."""
    return f"{time.time_ns() // 1_000_000:012x}-{secrets.token_hex(4)}"
