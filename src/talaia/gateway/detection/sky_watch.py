"""Looks at the cameras that see all of the sky, and tells how much of it is covered.

A picture is looked at every half minute or so, on a thread: a tenth of a second of numbers. Where
nothing can be told (by day, or of a camera that sends nothing) nothing is said, and what was said
grows old: for interlocks it is unknown then.
"""

from __future__ import annotations

import asyncio
import logging
import math
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from talaia.clock import SECOND
from talaia.gateway.detection.camera_watch import CameraWatch
from talaia.gateway.ports import ChannelReading
from talaia.imaging.sky_clouds import SkyMoment, measure_clouds
from talaia.model.derived_signals import sky_cameras
from talaia.model.detection import SkyLens
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.gateway.ports import CameraFrame
    from talaia.imaging.sky_clouds import CloudMeasure
    from talaia.model.interlocks.enclosure import Place
    from talaia.model.site import Site

__all__ = ["SkyWatch"]

log = logging.getLogger(__name__)
# A lens that gets dusty is no cloud for ever: so much less is expected of each next picture (mag).
FADE_MAG = 0.0005


class SkyWatch(CameraWatch[tuple[str, SkyLens]]):
    """All cameras of a site that look at the sky. Event loop only."""

    def _list_wanted(self, site: Site) -> Mapping[str, tuple[str, SkyLens]]:
        return sky_cameras(site)

    async def _watch_camera(self, name: str, wanted: tuple[str, SkyLens]) -> None:
        address, (stream, lens) = name, wanted
        release = self._pictures.hold(stream)
        since_us, zero = 0, math.nan
        try:
            while True:
                came_us, look = await self._next_picture(stream, since_us)
                since_us = came_us or since_us
                place = self._site.place
                if look is None or place is None:
                    continue
                try:
                    seen = await asyncio.to_thread(partial(_measure, look, lens, place, zero))
                except Exception:
                    # Whatever one picture brings, the next is looked at, and the roof is guarded.
                    log.exception("%s: a picture of the sky cannot be measured", address)
                    continue
                if not math.isnan(seen.zero):
                    # Of the clearest sky so far: one that is covered all over does not tell it.
                    zero = seen.zero if math.isnan(zero) else max(seen.zero, zero - FADE_MAG)
                self._report_clouds(address, look, seen)
                await asyncio.sleep(lens.every)
        finally:
            release()

    def _report_clouds(self, address: str, look: CameraFrame, seen: CloudMeasure) -> None:
        if seen.problem != self._problems.get(address, ""):
            self._problems[address] = seen.problem
            log.info("%s: %s", address, seen.problem or "clouds are measured again")
        if seen.problem or address not in self._numbers:
            return
        columns = Columns(
            np.array([self._numbers[address]], np.uint16),
            np.array([look.time_us], np.int64),
            np.array([seen.cover], np.float64),
            {},
        )
        self._publish(columns, {address: ChannelReading(seen.cover, look.mono_us * 1000)})


def _measure(look: CameraFrame, lens: SkyLens, place: Place, zero: float) -> CloudMeasure:
    # One colour: the eye's weights matter little for stars.
    pixels = look.rgb.mean(axis=2)
    moment = SkyMoment(place.latitude, place.longitude, look.time_us * 1000 / SECOND)
    return measure_clouds(pixels, lens, moment, zero)
