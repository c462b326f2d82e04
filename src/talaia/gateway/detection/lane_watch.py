"""Looks at cameras that see the lane before a vehicle, and tells where the vehicle is in it.

Where no lane can be seen nothing is said, and what was said grows old: for interlocks it is
unknown then.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.gateway.detection.camera_watch import CameraWatch
from talaia.gateway.ports import ChannelReading
from talaia.model.derived_signals import lane_signals
from talaia.model.detection import LANE_HEADING, LANE_OFFSET, LANE_WIDTH, LaneView
from talaia.objects.floor_lines import FloorMapping
from talaia.objects.lane_finder import LaneFinder
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.gateway.ports import CameraFrame
    from talaia.model.site import Site
    from talaia.objects.lane_finder import LanePlace

__all__ = ["LaneWatch"]

log = logging.getLogger(__name__)


class _LaneCamera(NamedTuple):
    """A camera's lane, and the address of each signal by what it tells."""

    view: LaneView
    signals: tuple[tuple[str, str], ...]


class LaneWatch(CameraWatch[_LaneCamera]):
    """All cameras of a site that look at a lane. Event loop only."""

    def _list_wanted(self, site: Site) -> Mapping[str, _LaneCamera]:
        cameras: dict[str, _LaneCamera] = {}
        for address, told in lane_signals(site).items():
            before = cameras.get(told.camera, _LaneCamera(told.view, ()))
            cameras[told.camera] = before._replace(signals=(*before.signals, (told.sees, address)))
        return cameras

    async def _watch_camera(self, name: str, wanted: _LaneCamera) -> None:
        release = self._pictures.hold(name)
        floor = wanted.view.floor
        since_us, size = 0, (0, 0)
        finder: LaneFinder | None = None
        try:
            mapping = FloorMapping(floor.picture, floor.metres)
            while True:
                came_us, look = await self._next_picture(name, since_us)
                since_us = came_us or since_us
                if look is None:
                    continue
                if finder is None or look.rgb.shape[:2] != size:
                    size = (look.rgb.shape[0], look.rgb.shape[1])
                    finder = await asyncio.to_thread(LaneFinder, wanted.view, mapping, size)
                try:
                    place = await asyncio.to_thread(finder.find_lane, look.rgb)
                except Exception:
                    # Whatever one picture brings, the next is looked at.
                    log.exception("%s: the lane cannot be looked for on a picture", name)
                    continue
                if place is not None:
                    self._report_place(wanted, look, place)
                await asyncio.sleep(wanted.view.every)
        finally:
            release()

    def _report_place(self, camera: _LaneCamera, look: CameraFrame, place: LanePlace) -> None:
        values = {
            LANE_OFFSET: place.offset,
            LANE_HEADING: place.heading,
            LANE_WIDTH: place.width,
        }
        told = [
            (address, values[sees]) for sees, address in camera.signals if address in self._numbers
        ]
        columns = Columns(
            np.array([self._numbers[address] for address, _ in told], np.uint16),
            np.full(len(told), look.time_us, np.int64),
            np.array([value for _, value in told], np.float64),
            {},
        )
        readings = {address: ChannelReading(value, look.mono_us * 1000) for address, value in told}
        self._publish(columns, readings)
