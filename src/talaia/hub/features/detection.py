"""Object detection at the hub: it looks at the cameras that descriptions leave to it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.features.feature import Feature
from talaia.hub.live.detection.detection_service import MODELS, DetectionService
from talaia.hub.live.gateways.live_samples import LiveSamples
from talaia.objects.worker import Worker

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.hub.features.feature import Core
    from talaia.hub.live.alarms.alarm_engine import AlarmEngine
    from talaia.hub.live.detection.anomaly_service import AnomalyService
    from talaia.hub.live.detection.sightings import SightingJournal
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.pictures.picture_fanout import PictureFanout
    from talaia.hub.ports import History

__all__ = ["DetectionFeature"]


class DetectionFeature(Feature):
    """Detectors beside the hub, in processes of their own.

    Attributes:
        cameras: those that the hub looks at.
        samples: takes live samples, of gateways and of what is counted here.

    """

    name = "detection"

    def __init__(
        self,
        core: Core,
        *,
        media: PictureFanout,
        history: History,
        sightings: SightingJournal,
        reporting: RobotEvents,
        alarms: AlarmEngine,
        anomalies: AnomalyService,
    ) -> None:
        """Look at ``media``; what is counted goes to ``alarms``, ``anomalies`` and ``history``."""
        # For the sites that are known at the start, and the folder of models.
        self._core = core
        self.samples = LiveSamples(
            fanout=core.fanout, alarms=alarms, anomalies=anomalies, clock=core.clock
        )
        self.cameras = DetectionService(
            media=media,
            sightings=sightings,
            reporting=reporting,
            samples=self.samples,
            history=history,
            make_worker=self._make_worker,
            clock=core.clock,
        )

    async def open(self) -> None:
        """Look at the cameras of the sites that are known."""
        for live in self._core.sites:
            self.cameras.redescribe(live)

    async def close(self) -> None:
        """Look no more; what was in sight has ended."""
        await self.cameras.close()

    def _make_worker(self, report: Callable[[str, str], None]) -> Worker:
        # A process of its own: a model that fails, or takes all memory, ends that one.
        return Worker({}, self._core.settings.data / MODELS, report)
