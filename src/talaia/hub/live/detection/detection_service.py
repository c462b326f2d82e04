"""Looks at the cameras that are to be looked at by the hub: boxes, sightings and counts.

Each camera is a task of its own (`CameraDetection`) and a viewer like a page: its newest picture
is read on a thread, seen by a process beside this one (`talaia.objects.worker`), and what comes of
it goes where a gateway's own words go. Counts are samples under a run of the hub's. Nothing of it
holds up a link.

A description comes from a gateway, so it names no file of the hub's: a detector of one's own is
found by its name alone, in a folder where an admin has put it.

Long, because all sites' cameras share the detectors, and all that is seen goes out here.
"""

from __future__ import annotations

import asyncio
import logging
import secrets
from pathlib import PurePath
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from talaia.hub.live.detection.camera_detection import CameraDetection
from talaia.hub.live.detection.sightings import OWN
from talaia.hub.live.gateways.ingest import Batch, Ingest, StoringPace
from talaia.hub.live.pictures.jpeg_process import JpegProcess
from talaia.model.derived_signals import counts_of, detecting_cameras, detection_setup_of
from talaia.model.detection import DetectAt
from talaia.objects.camera_objects import least_of
from talaia.wire.columns import Columns
from talaia.wire.frames import (
    DetectedBoxes,
    DetectedObject,
    LineCrossing,
    PictureForm,
    SightingReport,
    ZoneStay,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from talaia.clock import Clock
    from talaia.hub.live.detection.sightings import SightingJournal
    from talaia.hub.live.gateways.live_samples import LiveSamples
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.pictures.picture_fanout import PictureFanout
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.ports import History
    from talaia.model.derived_signals import DetectionSetup
    from talaia.model.detection import Detect, ObjectModel
    from talaia.model.site import Signal
    from talaia.objects.camera_objects import SightingNews
    from talaia.objects.detection import Detection as Found
    from talaia.objects.worker import Worker
    from talaia.wire.frames import PictureFrame

__all__ = ["MODELS", "DetectionService"]

_LOG = logging.getLogger(__name__)
# In the data folder: detectors of one's own.
MODELS = "models"
# Small pictures do: a detector is shown a square of a few hundred pixels.
_FORM = PictureForm.JPEG_SMALL
# Of one site so many cameras at the most.
_MOST_CAMERAS = 16
# What is counted gathers for so long before it is stored (s).
_GATHER_S = 0.2
# So long what waits may take to be stored at the end (s).
_FINISH_S = 1.0


class _SiteEyes:
    """The cameras of one site, and its samples on their way to the history."""

    def __init__(self, live: LiveSite, ingest: Ingest) -> None:
        # As it is described now.
        self.live = live
        # By stream: what it is set up by, what looks, and the task in which it does.
        self.cameras: dict[str, tuple[DetectionSetup, CameraDetection, asyncio.Task[None]]] = {}
        # Stores what is counted, as a gateway's samples are.
        self.ingest = ingest
        self.storing = asyncio.create_task(ingest.run())
        # Of the next sample; the hub is a gateway of its own here.
        self.sequence = 0
        # People were told that some cameras are not looked at.
        self.too_many = False


class DetectionService:
    """All cameras that the hub looks at itself."""

    def __init__(
        self,
        *,
        media: PictureFanout,
        sightings: SightingJournal,
        reporting: RobotEvents,
        samples: LiveSamples,
        history: History,
        make_worker: Callable[[Callable[[str, str], None]], Worker],
        clock: Clock,
    ) -> None:
        """Look at nothing yet.

        Args:
            media: where pictures come from, and where boxes go.
            sightings: takes what is seen.
            reporting: takes that detection is lost or back.
            samples: takes what is counted, live.
            history: keeps what is counted.
            make_worker: makes the detectors, which report by its argument how they fare.
            clock: dates what is counted.

        """
        self._media = media
        self._sightings = sightings
        self._reporting = reporting
        self._samples = samples
        self._history = history
        self._make = make_worker
        # The process that detects; none before the first camera needs it.
        self._worker: Worker | None = None
        # Reads the pictures for it; begun with the first.
        self._jpeg = JpegProcess()
        self._clock = clock
        # Names this run, of which nothing was ever stored.
        self.boot = f"{OWN}{secrets.token_hex(8)}"
        # By site; kept while the hub runs, since its samples are numbered on.
        self._of: dict[str, _SiteEyes] = {}
        # Of all sites, by ``<site>/<model>``.
        self._models: dict[str, ObjectModel] = {}
        # By model: cameras look one after the other, or one would starve the rest.
        self._turns: dict[str, asyncio.Lock] = {}
        # Held, for the loop itself holds a task only weakly.
        self._ended: set[asyncio.Task[None]] = set()
        # When what they count is stored.
        self._pace = StoringPace(_GATHER_S)
        # Set once: no camera is begun any more.
        self._closing = False

    def redescribe(self, live: LiveSite) -> None:
        """Look at what a site's description says from here on; what is the same goes on."""
        wanted = {
            name: detect
            for name, detect in detecting_cameras(live.description)
            if detect.at is DetectAt.HUB
        }
        site = self._of.get(live.name)
        if self._closing or (site is None and not wanted):
            return
        if site is None:
            # Nobody is told what is stored: no gateway keeps what the hub itself counts.
            ingest = Ingest(self._history, live.name, lambda _: None, self._pace)
            site = self._of[live.name] = _SiteEyes(live, ingest)
        site.live = live
        self._say_too_many(live, site, wanted)
        wanted = dict(list(wanted.items())[:_MOST_CAMERAS])
        for name in list(site.cameras):
            # Set up in another way: it begins anew. Only what is counted may change in between.
            if name not in wanted or site.cameras[name][0] != _setup_of(live, name):
                self._end_camera(site, name)
        self._take_models(live, wanted)
        for name, detect in wanted.items():
            eye = _setup_of(live, name)
            if eye is None:
                continue
            if name in site.cameras:
                site.cameras[name][1].apply_counts(_counting_signals(live, name))
                continue
            camera = CameraDetection(
                self, live=live, name=name, detect=detect, counted=_counting_signals(live, name)
            )
            site.cameras[name] = (eye, camera, asyncio.create_task(camera.run()))
        self._stop_idle()

    async def close(self) -> None:
        """Look no more; what was in sight has ended, and what was counted is stored."""
        self._closing = True
        for site in self._of.values():
            for name in list(site.cameras):
                self._end_camera(site, name)
        # Each still tells the end of what was in sight.
        await asyncio.gather(*self._ended, return_exceptions=True)
        # After the cameras, which may still wait for its answer.
        if self._worker is not None:
            await self._worker.close()
        await self._jpeg.close()
        storing = {site.storing for site in self._of.values()}
        for site in self._of.values():
            site.ingest.finish_storing()
        if storing:
            await asyncio.wait(storing, timeout=_FINISH_S)
        for task in storing:
            task.cancel()
        await asyncio.gather(*storing, return_exceptions=True)

    def _say_too_many(self, live: LiveSite, site: _SiteEyes, wanted: Mapping[str, Detect]) -> None:
        too_many = len(wanted) > _MOST_CAMERAS
        if too_many and not site.too_many:
            self._reporting.report_event(
                live,
                "detection lost",
                message=f"the hub looks at {_MOST_CAMERAS} cameras of a site at the most; "
                f"{len(wanted)} are described: let the gateway look at the others",
                good=False,
            )
        site.too_many = too_many

    def _end_camera(self, site: _SiteEyes, name: str) -> None:
        _, _, task = site.cameras.pop(name)
        task.cancel()
        self._ended.add(task)
        task.add_done_callback(self._ended.discard)

    # ── detectors ───────────────────────────────────────────────────────────────────────────

    def _take_models(self, live: LiveSite, wanted: Mapping[str, Detect]) -> None:
        """Know the detectors of a site by names that no other site's have."""
        # Of a path only the name: a description must not reach into other folders.
        mine = {
            _model_of(live.name, detect.model): msgspec.structs.replace(
                about, file=PurePath(about.file).name or "model.onnx"
            )
            for detect in wanted.values()
            if detect.model
            and (about := live.description.object_models.get(detect.model)) is not None
        }
        # Other sites' models stay: the worker is told all of them at once.
        others = {
            name: about
            for name, about in self._models.items()
            if name.partition("/")[0] != live.name
        }
        self._models = {**others, **mine}
        if self._worker is None:
            self._worker = self._make(self._report_model)
        self._worker.redescribe(self._models)

    def _stop_idle(self) -> None:
        """End the detectors that no camera needs any more."""
        needed = {
            _model_of(name, eye.detect.model)
            for name, site in self._of.items()
            for eye, _, _ in site.cameras.values()
        }
        for model in [turn for turn in self._turns if turn not in needed]:
            del self._turns[model]
            if self._worker is not None:
                self._worker.stop_idle(model)

    def _report_model(self, model: str, why: str) -> None:
        """Tell, for each camera of a detector, that it cannot see, or does again."""
        for name, site in self._of.items():
            for camera, (eye, _, _) in site.cameras.items():
                if _model_of(name, eye.detect.model) == model:
                    self.tell_trouble(site.live, camera, why)

    def tell_trouble(self, live: LiveSite, camera: str, why: str) -> None:
        """Tell that nothing is seen on a camera, or (without a reason) that it is again."""
        device, _, stream = camera.partition("/")
        described = live.description.devices.get(device)
        found = described.streams.get(stream) if described else None
        called = found.name if found else camera
        if why:
            _LOG.warning("%s of %s: nothing can be detected: %s", camera, live.name, why)
            said = f"nothing is detected on {called}, at the hub: {why}"
            self._reporting.report_event(
                live, "detection lost", device=device, message=said[:500], good=False
            )
        else:
            _LOG.info("%s of %s: objects are detected again", camera, live.name)
            said = f"objects are detected on {called} again"
            self._reporting.report_event(live, "detection back", device=device, message=said)

    # ── for a camera ────────────────────────────────────────────────────────────────────────

    def watch_camera(
        self, live: LiveSite, camera: str, take: Callable[[PictureFrame], None]
    ) -> None:
        """Have pictures of a camera."""
        self._media.watch_stream(live.name, camera, _FORM, take)

    def unwatch_camera(self, live: LiveSite, camera: str) -> None:
        """Need no pictures for now."""
        self._media.unwatch_stream(live.name, camera)

    async def detect_objects(
        self, live: LiveSite, detect: Detect, newest: Callable[[], PictureFrame | None]
    ) -> tuple[PictureFrame, NDArray[np.uint8], list[Found]] | None:
        """See the newest picture when its detector's turn has come.

        Raises:
            DetectorError: it cannot be read or seen.

        """
        model = _model_of(live.name, detect.model)
        async with self._turns.setdefault(model, asyncio.Lock()):
            # Only when it is its turn: the newest, not the one that came when it began to wait.
            picture = newest()
            if picture is None or self._worker is None:
                return None
            # A gateway's picture: another process reads it.
            rgb = await self._jpeg.read_pixels(live.name, picture.data)
            return picture, rgb, await self._worker.detect_objects(model, rgb, least_of(detect))

    def show_boxes(
        self, live: LiveSite, camera: str, picture: PictureFrame, found: Sequence[Found]
    ) -> None:
        """Give what is on a picture to the pages that want to know."""
        # Boxes are written for nobody if no page asks for them.
        if self._media.looked_at(live.name, camera):
            things = [DetectedObject(**thing._asdict()) for thing in found]
            said = DetectedBoxes(
                stream=camera, seq=picture.seq, time_us=picture.time_us, things=things
            )
            self._media.boxes(live.name, said)

    def publish_sightings(self, live: LiveSite, camera: str, news: Sequence[SightingNews]) -> None:
        """Take news of sightings."""
        for sighting, thumbnail, story in news:
            seen = SightingReport(
                stream=camera,
                label=sighting.label,
                many=sighting.most,
                confidence=min(1.0, max(0.0, sighting.score)),
                began_us=sighting.began_us,
                ended_us=sighting.ended_us or 0,
                thumbnail=thumbnail,
                path=story.path_on_picture(),
                stays=[
                    ZoneStay(zone=zone, entries=visit.entries, dwell_s=visit.dwell_s)
                    for zone, visit in story.zones
                ],
                crossings=[
                    LineCrossing(line=line, left=left, right=right)
                    for line, left, right in story.crossings
                ],
                speed=story.speed,
            )
            self._sightings.record_sighting(live, seen, self.boot)

    def publish_counts(self, live: LiveSite, time_us: int, counts: Mapping[str, float]) -> None:
        """Take counts, by the addresses of their signals: to pages, alarms and the history."""
        site = self._of.get(live.name)
        number = {channel.address: at for at, channel in enumerate(live.channels)}
        known = {number[address]: value for address, value in counts.items() if address in number}
        if site is None or not known:
            return
        columns = Columns(
            np.array(list(known), np.uint16),
            np.full(len(known), time_us, np.int64),
            np.array(list(known.values()), np.float64),
            {},
        )
        self._samples.publish_batch(live, columns)
        addresses = tuple(live.channels[at].address for at in known)
        # Stored by their own short list, so that a new description does not renumber them.
        own = Columns(np.arange(len(known), dtype=np.uint16), columns.time_us, columns.value, {})
        site.ingest.enqueue_batch(Batch(self.boot, site.sequence, addresses, own))
        site.sequence += len(known)

    def now_us(self) -> int:
        """Give the wall time (µs)."""
        return self._clock.wall_ns() // 1000


def _model_of(site: str, model: str) -> str:
    """Name a detector so that no other site's has its name; NanoDet is everybody's."""
    return f"{site}/{model}" if model else ""


def _setup_of(live: LiveSite, name: str) -> DetectionSetup | None:
    device, _, stream = name.partition("/")
    return detection_setup_of(live.description, device, stream)


def _counting_signals(live: LiveSite, name: str) -> dict[str, Signal]:
    """Give the signals that count what a camera sees, by their addresses."""
    found = {}
    for address, (camera, _) in counts_of(live.description).items():
        if camera == name:
            device, _, signal = address.partition("/")
            found[address] = live.description.devices[device].signals[signal]
    return found
