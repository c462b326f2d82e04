"""Looks at the cameras that detect: counts for signals, boxes for viewers, sightings for the hub.

Each camera is a task: a picture is waited for and read on a thread, seen by a process beside this
one (`talaia.objects.worker`), and what comes of it is put here. A camera looks no more often than
it may; cameras of one detector take turns, each with its newest picture.

Long, because a picture is followed here from its camera to all that comes of it.
"""

from __future__ import annotations

import asyncio
import logging
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from talaia.gateway.ports import ChannelReading
from talaia.gateway.samples.rate_limit import Sampler, SamplingRule
from talaia.model.connection import DetectionSource, source_as
from talaia.model.derived_signals import counts_of, detecting_cameras, detection_setup_of
from talaia.model.detection import DetectAt, Measured
from talaia.objects.camera_objects import CameraObjects, least_of
from talaia.objects.errors import DetectorError
from talaia.objects.steady_counts import SteadyCounts
from talaia.objects.tracker import colours_of
from talaia.wire.columns import Columns
from talaia.wire.frames import DetectedBoxes, DetectedObject

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from talaia.clock import Clock
    from talaia.gateway.ports import CameraFrame, CameraFrames, EventSink, ReadingSource, SampleSink
    from talaia.model.detection import Detect
    from talaia.model.site import Signal, Site
    from talaia.objects.camera_objects import SightingNews
    from talaia.objects.detection import Detection as Found
    from talaia.objects.worker import Worker

__all__ = ["DetectionOutputs", "ObjectDetection", "ReadingsWithDetections"]

log = logging.getLogger(__name__)
# For a picture is waited so long at a time; sightings end meanwhile.
WAIT_S = 0.5
# A detector that cannot see is asked again so much later, and needs no pictures until then.
FIRST_WAIT_S, LONGEST_WAIT_S = 1.0, 30.0
# So often a count that stays the same is said: who reads it knows that somebody looks.
SILENCE_US = 1_000_000
# Whole things are counted: a change by one is news.
STILL = 0.5
# Of a speed (m/s) less is.
STILL_SPEED = 0.05
# For decoding and waiting; more cameras than that take turns.
THREADS = 8
_T = TypeVar("_T")


class DetectionOutputs(NamedTuple):
    """Where goes what is seen.

    Attributes:
        samples: takes counts.
        boxes: takes boxes for viewers.
        sightings: takes news of sightings, with the stream's address.
        events: takes what is worth writing down.

    """

    samples: SampleSink
    boxes: Callable[[DetectedBoxes], None]
    sightings: Callable[[str, SightingNews], None]
    events: EventSink


class _Counted(NamedTuple):
    """A signal that counts, and the number of its channel."""

    signal: Signal
    channel: int


class ObjectDetection:
    """All cameras that detect at this gateway. Event loop only, but for `latest`."""

    def __init__(
        self,
        *,
        site: Site,
        numbers: Mapping[str, int],
        pictures: CameraFrames,
        worker: Callable[[Callable[[str, str], None]], Worker],
        outlet: DetectionOutputs,
        clock: Clock,
    ) -> None:
        """Look at nothing yet.

        Args:
            site: the description, with the signals that its cameras imply.
            numbers: of channels, by address; see `ChannelNumbering.numbers_of`.
            pictures: of the cameras.
            worker: makes the detectors, which tell this how they fare.
            outlet: see `DetectionOutputs`.
            clock: for when nothing is seen.

        """
        # Replaced by `redescribe`; numbers are of channels, by address.
        self._site, self._numbers = site, numbers
        self._pictures = pictures  # Pixels of cameras, kept only while somebody holds them.
        self._worker = worker(self._report_model)  # The detectors' processes, one for each model.
        self._outlet = outlet  # Where everything goes that comes of a picture.
        self._clock = clock  # Wall time, for sightings that end without a picture.
        # Pictures are read here: decoding would hold the loop.
        self._threads = ThreadPoolExecutor(THREADS, "talaia-eyes")
        # By model: who waits for its detector; fair, first come first served.
        self._turns: dict[str, asyncio.Lock] = {}
        # By stream's address: a camera and the task that looks at it.
        self._cameras: dict[str, tuple[_Camera, asyncio.Task[None]]] = {}
        # By signal's address; replaced as a whole, for threads read it.
        self._latest: dict[str, ChannelReading] = {}
        self._running = False  # Cameras are looked at only while `run` runs.

    def is_counted(self, address: str) -> bool:
        """Tell whether a signal counts what a camera sees."""
        device, _, name = address.partition("/")
        described = self._site.devices.get(device)
        signal = None if described is None else described.signals.get(name)
        return signal is not None and isinstance(signal.source, DetectionSource)

    def latest(self, address: str) -> ChannelReading | None:
        """See `talaia.gateway.ports.ReadingSource.latest`."""
        return self._latest.get(address)

    async def run(self) -> None:
        """Look until cancelled, and end all detectors then."""
        self._running = True
        self._begin_cameras(self._site)
        try:
            await asyncio.Event().wait()
        finally:
            self._running = False
            tasks = [task for _, task in self._cameras.values()]
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            # After the cameras: one of them may still wait for its answer.
            await self._worker.close()
            self._threads.shutdown(wait=False, cancel_futures=True)

    def redescribe(self, site: Site, numbers: Mapping[str, int]) -> None:
        """Look at what this description says from here on; a camera that is the same goes on."""
        before, self._site, self._numbers = self._site, site, numbers
        self._worker.redescribe(site.object_models)
        for name in list(self._cameras):
            if _setup_of(before, name) != _setup_of(site, name):
                self._end(name)
        counted = counts_of(site)
        self._latest = {
            address: reading
            for address, reading in self._latest.items()
            if _source_of(before, address) == _source_of(site, address) is not None
            # What is told by another look at pictures grows old by itself.
            and (address not in counted or counted[address][0] in self._cameras)
        }
        if self._running:
            self._begin_cameras(site)
        needed = {
            detect.model for _, detect in detecting_cameras(site) if detect.at is DetectAt.GATEWAY
        }
        # No camera needs this detector any more: its process takes memory for nothing.
        for model in [turn for turn in self._turns if turn not in needed]:
            del self._turns[model]
            self._worker.stop_idle(model)

    def _begin_cameras(self, site: Site) -> None:
        """Begin with cameras that nobody looks at yet; tell the others for what they count."""
        counted: dict[str, dict[str, _Counted]] = {}
        for address, (stream, _) in counts_of(site).items():
            device, _, name = address.partition("/")
            signal = site.devices[device].signals[name]
            counted.setdefault(stream, {})[address] = _Counted(signal, self._numbers[address])
        for name, detect in detecting_cameras(site):
            if detect.at is not DetectAt.GATEWAY:
                continue
            known = self._cameras.get(name)
            if known is not None:
                known[0].apply_counts(counted.get(name, {}))
                continue
            camera = _Camera(name, detect, counted.get(name, {}), self)
            self._cameras[name] = (camera, asyncio.ensure_future(camera.run()))

    def _end(self, name: str) -> None:
        _, task = self._cameras.pop(name)
        task.cancel()

    def _report_model(self, model: str, why: str) -> None:
        """Tell, for each camera of a detector, that it cannot see, or does again."""
        for name, detect in detecting_cameras(self._site):
            if detect.model != model or detect.at is not DetectAt.GATEWAY:
                continue
            device, _, stream = name.partition("/")
            called = self._site.devices[device].streams[stream].name
            if why:
                log.warning("%s: nothing can be detected: %s", name, why)
                said = f"nothing is detected on {called}: {why}"
                self._outlet.events.report_event("detection lost", said, device=device)
            else:
                log.info("%s: objects are detected again", name)
                said = f"objects are detected on {called} again"
                self._outlet.events.report_event("detection back", said, device=device, good=True)

    # ── for a camera ──

    def hold(self, name: str) -> Callable[[], None]:
        """Have pictures of a camera; see `Pictures.hold`."""
        return self._pictures.hold(name)

    async def arrived(self, name: str, since_us: int) -> int:
        """Wait a while for a picture; see `Pictures.arrived`."""
        return await self.on_thread(partial(self._pictures.arrived, name, since_us, WAIT_S))

    async def detect_objects(
        self, name: str, detect: Detect
    ) -> tuple[CameraFrame, list[Found]] | None:
        """See the newest picture of a camera, when its turn has come.

        Raises:
            DetectorError: its detector cannot see.

        """
        async with self._turns.setdefault(detect.model, asyncio.Lock()):
            # Only now, so that the picture is the newest when the detector is free, and not when it
            # was asked for.
            look = await self.on_thread(partial(self._pictures.newest, name))
            if look is None:
                return None
            return look, await self._worker.detect_objects(detect.model, look.rgb, least_of(detect))

    async def on_thread(self, work: Callable[[], _T]) -> _T:
        """Do what blocks elsewhere."""
        return await asyncio.get_running_loop().run_in_executor(self._threads, work)

    def now_us(self) -> int:
        """Give the wall time (µs)."""
        return self._clock.wall_ns() // 1000

    def publish_counts(self, columns: Columns, readings: Mapping[str, ChannelReading]) -> None:
        """Take counts."""
        # One step: it is read by other threads.
        self._latest = {**self._latest, **readings}
        if len(columns):
            self._outlet.samples.put_samples(columns)

    def record_boxes(self, look: CameraFrame, things: Sequence[Found]) -> None:
        """Take what is on a picture."""
        told = [DetectedObject(**thing._asdict()) for thing in things]
        self._outlet.boxes(
            DetectedBoxes(stream=look.stream, seq=look.seq, time_us=look.time_us, things=told)
        )

    def report_sightings(self, name: str, news: Sequence[SightingNews]) -> None:
        """Take news of sightings."""
        for sighting in news:
            self._outlet.sightings(name, sighting)


class _Camera:
    """One camera's task, and what it has seen."""

    def __init__(
        self, name: str, detect: Detect, counted: Mapping[str, _Counted], seeing: ObjectDetection
    ) -> None:
        # Of the description; another makes another camera.
        self._name, self._detect = name, detect
        self._seeing = seeing  # The site's; it has the detectors and the outlets.
        # By address: signals that count here; changed by `apply_counts`.
        self._counted: Mapping[str, _Counted] = {}
        self._samplers: dict[str, Sampler] = {}  # By address: what of a count is news.
        self._eyes = CameraObjects(detect, {})  # Sightings and plain counts.
        self._steady = SteadyCounts(detect)  # Counts for interlocks, with hysteresis.
        # Until the detector is asked again (s); doubles while it cannot see.
        self._wait_s = FIRST_WAIT_S
        self.apply_counts(counted)

    def apply_counts(self, counted: Mapping[str, _Counted]) -> None:
        """Count for these signals from here on."""
        before, self._counted = self._counted, counted
        # A signal that is the same goes on with its sampler, so that nothing is said twice.
        self._samplers = {
            address: self._samplers[address]
            if address in before and before[address].signal == count.signal
            else _make_sampler(count.signal)
            for address, count in counted.items()
        }
        self._eyes.apply_counts(_detection_sources(counted))

    async def run(self) -> None:
        """Look until cancelled; what is in sight then has ended."""
        try:
            while True:
                release = self._seeing.hold(self._name)
                try:
                    await self._watch_pictures()
                except DetectorError as error:
                    log.debug("%s: %s", self._name, error)
                except Exception:
                    # Whatever one camera brings, the others are looked at, and the robot is driven.
                    log.exception("%s: what is seen cannot be told", self._name)
                finally:
                    # While the detector is away nobody needs the camera's pixels.
                    release()
                wait_s, self._wait_s = self._wait_s, min(LONGEST_WAIT_S, self._wait_s * 2)
                await asyncio.sleep(wait_s)
                self._pass_time()
        finally:
            self._seeing.report_sightings(self._name, self._eyes.end_sightings())

    async def _watch_pictures(self) -> None:
        """Look at one picture after the other.

        Raises:
            DetectorError: the detector cannot see.

        """
        loop, period_s = asyncio.get_running_loop(), 1 / self._detect.max_rate
        due_s, since_us = loop.time(), 0
        while True:
            await asyncio.sleep(due_s - loop.time())
            came_us = await self._seeing.arrived(self._name, since_us)
            if not came_us:
                self._pass_time()
                continue
            since_us, now_s = came_us, loop.time()
            # From the due time, so that the rate is kept in spite of waiting for pictures.
            due_s = (due_s if now_s - due_s < period_s else now_s) + period_s
            seen = await self._seeing.detect_objects(self._name, self._detect)
            if seen is not None:
                look, things = seen
                since_us, self._wait_s = max(since_us, look.mono_us), FIRST_WAIT_S
                # A page is shown no more of it than of the picture; and none without a thing.
                shown = await self._seeing.on_thread(look.may_leave) if things else None
                # Of the picture itself: a blurred one has other colours, and only numbers leave.
                colours = [colours_of(look.rgb, thing) for thing in things]
                self._publish_detections(look, things, shown, colours)

    def _publish_detections(
        self,
        look: CameraFrame,
        things: Sequence[Found],
        shown: NDArray[np.uint8] | None,
        colours: Sequence[NDArray[np.float64] | None],
    ) -> None:
        gathered = []
        readings = {}
        # First: what signals tell of zones and lines is by whose each thing is.
        news = self._eyes.add_picture(things, shown, look.time_us, colours)
        sources = _detection_sources(self._counted)
        steady = self._steady.count_things(things, sources, look.mono_us)
        for address, count in self._eyes.count_things(things).items():
            counted = self._counted[address]
            value = count * counted.signal.scale
            # Interlocks are told the steady count, pages the plain one. Times, speeds and crossings
            # are of tracks, which a miss in one picture does not end.
            counts = sources[address].measure is Measured.COUNT
            held = (steady[address] if counts else count) * counted.signal.scale
            readings[address] = ChannelReading(held, look.mono_us * 1000)
            if self._samplers[address].accept_sample(look.time_us, (value,)):
                gathered.append((counted.channel, value))
        columns = Columns(
            np.array([channel for channel, _ in gathered], np.uint16),
            np.full(len(gathered), look.time_us, np.int64),
            np.array([value for _, value in gathered], np.float64),
            {},
        )
        self._seeing.publish_counts(columns, readings)
        self._seeing.record_boxes(look, things)
        self._seeing.report_sightings(self._name, news)

    def _pass_time(self) -> None:
        self._seeing.report_sightings(self._name, self._eyes.pass_time(self._seeing.now_us()))


class ReadingsWithDetections:
    """A `ReadingSource`: of the robot, and of what is seen on its cameras."""

    def __init__(self, robot: ReadingSource, seeing: ObjectDetection) -> None:
        """Join the two."""
        self._robot, self._seeing = robot, seeing

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        if self._seeing.is_counted(address):
            return self._seeing.latest(address)
        return self._robot.latest(address)


def _make_sampler(signal: Signal) -> Sampler:
    """Keep what changes, and what does not once a second, or as seldom as the signal says."""
    interval_us = round(1e6 / signal.max_rate) if signal.max_rate > 0 else 0
    fast = source_as(signal.source, DetectionSource).measure is Measured.SPEED
    still = max(signal.deadband, (STILL_SPEED if fast else STILL) * abs(signal.scale))
    return Sampler(SamplingRule(interval_us, still, max(SILENCE_US, interval_us)))


def _setup_of(site: Site, name: str) -> object:
    """Give all that decides what is seen on a camera; none where nothing is."""
    device_id, _, stream_id = name.partition("/")
    device = site.devices.get(device_id)
    if device is None or stream_id not in device.streams:
        return None
    eye = detection_setup_of(site, device_id, stream_id)
    return None if eye is None or eye.detect.at is not DetectAt.GATEWAY else eye


def _detection_sources(counted: Mapping[str, _Counted]) -> dict[str, DetectionSource]:
    return {
        address: source_as(count.signal.source, DetectionSource)
        for address, count in counted.items()
    }


def _source_of(site: Site, address: str) -> object:
    device, _, name = address.partition("/")
    described = site.devices.get(device)
    signal = None if described is None else described.signals.get(name)
    return None if signal is None else signal.source
