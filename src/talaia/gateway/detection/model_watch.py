"""Lets models that tell no boxes look at cameras: signals, and overlays for those who look.

Each model at each camera is a task. A picture is seen by the model's own process
(`talaia.objects.worker`); cameras of one model take turns, each with its newest picture. Where
nothing can be told nothing is said, and what was said grows old: for interlocks it is unknown then.
"""

from __future__ import annotations

import asyncio
import logging
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.gateway.detection.camera_watch import WAIT_S, CameraWatch
from talaia.gateway.detection.overlay_layers import layer_of
from talaia.gateway.ports import ChannelReading
from talaia.gateway.samples.rate_limit import Sampler, SamplingRule
from talaia.model.closed_lists import SignalType
from talaia.model.connection import DetectionSource, source_as
from talaia.model.detection import Measured, ModelKind
from talaia.model.picture_models.model_signals import ModelCamera, model_cameras
from talaia.model.picture_models.picture_model import measured_unit
from talaia.objects.errors import DetectorError
from talaia.objects.kinds.catalog import KINDS
from talaia.objects.kinds.keypoints import Poses, detect_like, pose_things
from talaia.objects.steady_counts import SteadyCounts
from talaia.wire.columns import Columns
from talaia.wire.frames import ModelOverlay

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.clock import Clock
    from talaia.gateway.ports import CameraFrame, CameraFrames, EventSink
    from talaia.model.detection import ObjectModel
    from talaia.model.site import Signal, Site
    from talaia.objects.kinds.catalog import Scene
    from talaia.objects.worker import Worker

__all__ = ["ModelWatch", "OverlayOutlet"]

log = logging.getLogger(__name__)
# A model that cannot see is asked again so much later, and needs no pictures until then.
FIRST_WAIT_S, LONGEST_WAIT_S = 1.0, 30.0
# Of things that are counted weaker ones are asked for, too: a steady count goes on with them.
_LESS_SURE = 0.7
# So often a value that stays the same is said: who reads it knows that somebody looks.
SILENCE_US = 1_000_000
# A change by less is no news: of %, of metres, and of what is counted or numbered.
STILL_PERCENT, STILL_METRES, STILL_WHOLE = 0.5, 0.02, 0.5


class OverlayOutlet(NamedTuple):
    """Where overlays go.

    Attributes:
        is_wanted: whether anybody looks at those of a camera.
        send: takes one.

    """

    is_wanted: Callable[[str], bool]
    send: Callable[[ModelOverlay], None]


class ModelWatch(CameraWatch[ModelCamera]):
    """All models of a site that tell no boxes. Event loop only."""

    def __init__(
        self,
        *,
        site: Site,
        numbers: Mapping[str, int],
        pictures: CameraFrames,
        publish: Callable[[Columns, Mapping[str, ChannelReading]], None],
        clock: Clock,
        worker: Callable[[Callable[[str, str], None]], Worker],
        overlays: OverlayOutlet,
        events: EventSink,
    ) -> None:
        """Look at nothing yet; see `CameraWatch`.

        ``worker`` makes the models' processes, which tell this how they fare, and ``events`` takes
        what of that is worth writing down.
        """
        super().__init__(
            site=site, numbers=numbers, pictures=pictures, publish=publish, clock=clock
        )
        self._worker = worker(self._report_model)
        self._overlays, self._events = overlays, events
        # By model: who waits for its process; fair, first come first served.
        self._turns: dict[str, asyncio.Lock] = {}

    def _list_wanted(self, site: Site) -> Mapping[str, ModelCamera]:
        return {f"{camera.camera} {camera.name}": camera for camera in model_cameras(site)}

    async def run(self) -> None:
        """Look until cancelled, and end all processes then."""
        try:
            await super().run()
        finally:
            await self._worker.close()

    def redescribe(self, site: Site, numbers: Mapping[str, int]) -> None:
        """Look at what another description says; what is the same goes on."""
        self._worker.redescribe(site.object_models)
        super().redescribe(site, numbers)
        needed = {camera.name for camera in model_cameras(site)}
        # No camera needs this model any more: its process takes memory for nothing.
        for model in [turn for turn in self._turns if turn not in needed]:
            del self._turns[model]
            self._worker.stop_idle(model)

    async def _watch_camera(self, name: str, wanted: ModelCamera) -> None:
        signals = {
            address: _Told(signal, self._numbers[address])
            for address, signal in wanted.signals.items()
            if address in self._numbers
        }
        measures = _Measures(wanted, signals)
        while True:
            release = self._pictures.hold(wanted.camera)
            try:
                await self._watch_pictures(wanted, measures)
            except DetectorError as error:
                log.debug("%s: %s", name, error)
            except Exception:
                # Whatever one model brings, the others look, and the robot is driven.
                log.exception("%s: what a model sees cannot be told", name)
            finally:
                # While the model is away nobody needs the camera's pixels.
                release()
            wait_s, measures.wait_s = measures.wait_s, min(LONGEST_WAIT_S, measures.wait_s * 2)
            await asyncio.sleep(wait_s)

    async def _watch_pictures(self, wanted: ModelCamera, measures: _Measures) -> None:
        """Look at one picture after the other.

        Raises:
            DetectorError: the model cannot see.

        """
        loop, period_s = asyncio.get_running_loop(), 1 / wanted.use.max_rate
        due_s, since_us = loop.time(), 0
        while True:
            await asyncio.sleep(due_s - loop.time())
            arrived = await asyncio.to_thread(
                self._pictures.arrived, wanted.camera, since_us, WAIT_S
            )
            if not arrived:
                continue
            since_us, now_s = arrived, loop.time()
            # From the due time, so that the rate is kept in spite of waiting for pictures.
            due_s = (due_s if now_s - due_s < period_s else now_s) + period_s
            async with self._turns.setdefault(wanted.name, asyncio.Lock()):
                # Only now, so that the picture is the newest when the model is free.
                look = await asyncio.to_thread(self._pictures.newest, wanted.camera)
                if look is None:
                    continue
                scene = await self._worker.read_scene(wanted.name, look.rgb, _least_of(wanted))
            since_us, measures.wait_s = max(since_us, look.mono_us), FIRST_WAIT_S
            self._publish(*measures.measure_scene(scene, look))
            if self._overlays.is_wanted(wanted.camera):
                layer = layer_of(scene, wanted.model, wanted.use)
                self._overlays.send(
                    ModelOverlay(
                        stream=wanted.camera,
                        seq=look.seq,
                        time_us=look.time_us,
                        model=wanted.name,
                        layer=layer,
                    )
                )

    def _report_model(self, model: str, why: str) -> None:
        """Tell, for each camera of a model, that it cannot see, or does again."""
        for camera in model_cameras(self._site):
            if camera.name != model:
                continue
            device, _, stream = camera.camera.partition("/")
            called = self._site.devices[device].streams[stream].name
            if why:
                log.warning("%s: %s tells nothing: %s", camera.camera, model, why)
                said = f"{model} tells nothing of {called}: {why}"
                self._events.report_event("detection lost", said, device=device)
            else:
                log.info("%s: %s tells what it sees again", camera.camera, model)
                said = f"{model} tells what it sees on {called} again"
                self._events.report_event("detection back", said, device=device, good=True)


class _Told(NamedTuple):
    """A signal that tells of a model, and the number of its channel."""

    signal: Signal
    channel: int


class _Measures:
    """What signals tell of one model at one camera, from picture to picture."""

    def __init__(self, wanted: ModelCamera, signals: Mapping[str, _Told]) -> None:
        self._wanted, self._signals = wanted, signals
        self._measure = KINDS[wanted.model.kind].measure
        self._sources = {
            address: source_as(told.signal.source, DetectionSource)
            for address, told in signals.items()
        }
        # By address: what of a value is news.
        self._samplers = {
            address: _make_sampler(told.signal, self._sources[address], wanted.model)
            for address, told in signals.items()
        }
        # Counts for interlocks, with hysteresis, as of a detector's boxes.
        self._steady = SteadyCounts(detect_like(wanted.use))
        # Until the model is asked again (s); doubles while it cannot see.
        self.wait_s = FIRST_WAIT_S

    def measure_scene(
        self, scene: Scene, look: CameraFrame
    ) -> tuple[Columns, dict[str, ChannelReading]]:
        """Give what is news to the hub, and all newest readings."""
        gathered: list[tuple[int, float]] = []
        texts: dict[int, str] = {}
        readings = {}
        held = self._hold_counts(scene, look)
        for address, told in self._signals.items():
            source, model = self._sources[address], self._wanted.model
            measured = self._measure(scene, source, model, self._wanted.use)
            value = measured * told.signal.scale
            if math.isnan(value):
                # The value before it grows old.
                continue
            steady = held.get(address, measured) * told.signal.scale
            readings[address] = ChannelReading(steady, look.mono_us * 1000)
            if not self._samplers[address].accept_sample(look.time_us, (value,)):
                continue
            if told.signal.type is SignalType.TEXT:
                texts[len(gathered)] = model.classes[round(measured)]
                value = math.nan
            gathered.append((told.channel, value))
        columns = Columns(
            np.array([channel for channel, _ in gathered], np.uint16),
            np.full(len(gathered), look.time_us, np.int64),
            np.array([value for _, value in gathered], np.float64),
            texts,
        )
        return columns, readings

    def _hold_counts(self, scene: Scene, look: CameraFrame) -> Mapping[str, float]:
        if not isinstance(scene, Poses):
            return {}
        things = pose_things(scene, self._wanted.model)
        return self._steady.count_things(things, self._sources, look.mono_us)


def _least_of(wanted: ModelCamera) -> float:
    counts = wanted.model.kind is ModelKind.KEYPOINTS
    return wanted.use.confidence * (_LESS_SURE if counts else 1.0)


def _make_sampler(signal: Signal, source: DetectionSource, model: ObjectModel) -> Sampler:
    """Keep what changes, and what does not once a second, or as seldom as the signal says."""
    interval_us = round(1e6 / signal.max_rate) if signal.max_rate > 0 else 0
    if source.measure in (Measured.COUNT, Measured.SUREST):
        still = STILL_WHOLE
    else:
        still = STILL_METRES if measured_unit(model, source.measure) == "m" else STILL_PERCENT
    deadband = max(signal.deadband, still * abs(signal.scale))
    return Sampler(SamplingRule(interval_us, deadband, max(SILENCE_US, interval_us)))
