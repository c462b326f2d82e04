"""Objects on pictures of cameras: what is detected, and how the hub is told of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.detection.camera_detection import (
    DetectionOutputs,
    ObjectDetection,
    ReadingsWithDetections,
)
from talaia.gateway.detection.clip_films import ClipFilms
from talaia.gateway.detection.lane_watch import LaneWatch
from talaia.gateway.detection.model_watch import ModelWatch, OverlayOutlet
from talaia.gateway.detection.sighting_reports import DetectionReporter
from talaia.gateway.detection.sky_watch import SkyWatch
from talaia.objects.worker import Worker

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.adapters import AdaptersPart
    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.assembly.samples import SamplesPart
    from talaia.gateway.assembly.video import VideoPart
    from talaia.model.site import Site

__all__ = ["DetectionPart"]


class DetectionPart(GatewayPart):
    """Object detection on the cameras that are described so.

    Attributes:
        reporter: keeps sightings until the hub has them.
        detection: looks at the cameras.
        readings: the newest of the robot, and of what is detected on its cameras.

    """

    def __init__(
        self,
        *,
        base: FoundationPart,
        description: DescriptionPart,
        samples: SamplesPart,
        video: VideoPart,
        adapters: AdaptersPart,
    ) -> None:
        """Take up the sightings that an earlier run left."""
        site, settings = description.site, base.settings
        self.reporter = DetectionReporter(settings.data / "sightings", base.lanes, base.file_thread)
        self._clips = ClipFilms(site, video.films, self.reporter.report_sighting)

        def make_worker(on_status: Callable[[str, str], None]) -> Worker:
            return Worker(
                site.object_models,
                settings.folder,
                on_status,
                provider=settings.detector_provider,
            )

        self.detection = ObjectDetection(
            site=site,
            numbers=description.numbering.numbers_of(site),
            pictures=video.frames,
            worker=make_worker,
            outlet=DetectionOutputs(
                samples=samples.sink,
                boxes=video.pictures.boxes,
                sightings=self._clips.report_sighting,
                events=base.events,
            ),
            clock=base.clock,
        )
        self._watches: dict[str, SkyWatch | LaneWatch | ModelWatch] = {
            name: watch(
                site=site,
                numbers=description.numbering.numbers_of(site),
                pictures=video.frames,
                publish=self.detection.publish_counts,
                clock=base.clock,
            )
            for name, watch in (("sky", SkyWatch), ("lane", LaneWatch))
        }
        self._watches["models"] = ModelWatch(
            site=site,
            numbers=description.numbering.numbers_of(site),
            pictures=video.frames,
            publish=self.detection.publish_counts,
            clock=base.clock,
            worker=make_worker,
            overlays=OverlayOutlet(video.pictures.wants_overlay, video.pictures.send_overlay),
            events=base.events,
        )
        self._blur_detectors = video.blur_detectors
        self._numbering = description.numbering
        self.readings = ReadingsWithDetections(adapters.adapter, self.detection)

    def redescribe(self, site: Site) -> None:
        """Look at the cameras of another description."""
        numbers = self._numbering.numbers_of(site)
        self._blur_detectors.redescribe(site)
        self._clips.redescribe(site)
        self.detection.redescribe(site, numbers)
        for watch in self._watches.values():
            watch.redescribe(site, numbers)

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Look at cameras, and tell the hub."""
        return {
            "detect": self.detection.run,
            "report": self.reporter.run,
            **{name: watch.run for name, watch in self._watches.items()},
        }
