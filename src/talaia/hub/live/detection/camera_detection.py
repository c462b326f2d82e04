"""One camera that the hub looks at: when, how often, and what of it is news."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
from typing import TYPE_CHECKING, Protocol

from talaia.hub.live.pictures.jpeg_decoder import Unreadable
from talaia.model.connection import DetectionSource, source_as
from talaia.objects.camera_objects import CameraObjects
from talaia.objects.errors import DetectorError
from talaia.wire.frames import PictureForm

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from talaia.hub.live.sites import LiveSite
    from talaia.model.detection import Detect
    from talaia.model.site import Signal
    from talaia.objects.camera_objects import SightingNews
    from talaia.objects.detection import Detection as Found
    from talaia.wire.frames import PictureFrame

__all__ = ["CameraDetection", "DetectionHost"]

_LOG = logging.getLogger(__name__)
# Without a picture for so long, what is in sight may be gone (s).
_WAIT_S = 0.5
# Between two attempts of a camera that fails; doubles each time.
_FIRST_WAIT_S, _LONGEST_WAIT_S = 1.0, 30.0
# So often a count that stays the same is said: who reads it knows that somebody looks.
_SILENCE_US = 1_000_000
# Later times are no times (µs): the year 2255.
_LAST_US = 2**53


class DetectionHost(Protocol):
    """Where a camera's pictures come from, and where goes what is seen on them."""

    def watch_camera(
        self, live: LiveSite, camera: str, take: Callable[[PictureFrame], None]
    ) -> None:
        """Have pictures of a camera."""
        ...

    def unwatch_camera(self, live: LiveSite, camera: str) -> None:
        """Need no pictures for now."""
        ...

    async def detect_objects(
        self, live: LiveSite, detect: Detect, newest: Callable[[], PictureFrame | None]
    ) -> tuple[PictureFrame, NDArray[np.uint8], list[Found]] | None:
        """See the newest picture when its detector's turn has come.

        Raises:
            DetectorError: it cannot be read or seen.

        """
        ...

    def show_boxes(
        self, live: LiveSite, camera: str, picture: PictureFrame, found: Sequence[Found]
    ) -> None:
        """Give what is on a picture to the pages that want to know."""
        ...

    def publish_sightings(self, live: LiveSite, camera: str, news: Sequence[SightingNews]) -> None:
        """Take news of sightings."""
        ...

    def publish_counts(self, live: LiveSite, time_us: int, counts: Mapping[str, float]) -> None:
        """Take counts, by the addresses of their signals."""
        ...

    def tell_trouble(self, live: LiveSite, camera: str, why: str) -> None:
        """Tell that nothing is seen on a camera, or (without a reason) that it is again."""
        ...

    def now_us(self) -> int:
        """Give the wall time (µs)."""
        ...


class CameraDetection:
    """One camera's task, and what it has seen."""

    def __init__(
        self,
        around: DetectionHost,
        *,
        live: LiveSite,
        name: str,
        detect: Detect,
        counted: Mapping[str, Signal],
    ) -> None:
        """Look at the camera ``name`` of a site as ``detect`` says, and count for signals.

        Args:
            around: takes what is seen.
            live: the site.
            name: the camera's, ``device/stream``.
            detect: what is looked for.
            counted: the signals, by their addresses.

        """
        self._around, self._live, self._name, self._detect = around, live, name, detect
        # Follows things from picture to picture.
        self._eyes = CameraObjects(detect, {})
        # Signals that count things on this camera, by their addresses.
        self._counted: Mapping[str, Signal] = {}
        # What was said of each signal last: when, and the count.
        self._said: dict[str, tuple[int, float]] = {}
        # The newest picture that nobody has looked at yet; others are left out.
        self._picture: PictureFrame | None = None
        # There is one.
        self._news = asyncio.Event()
        # Before the next attempt (s); a picture that was looked at sets it back.
        self._wait_s = _FIRST_WAIT_S
        # People were told that pictures cannot be read.
        self._unreadable = False
        # By the camera's clock: the newest picture's, and how far ours was ahead of it then.
        self._last_us, self._ahead_us = 0, 0
        self.apply_counts(counted)

    def apply_counts(self, counted: Mapping[str, Signal]) -> None:
        """Count for these signals from here on."""
        self._counted = counted
        self._said = {address: said for address, said in self._said.items() if address in counted}
        sources = {
            address: source_as(of.source, DetectionSource) for address, of in counted.items()
        }
        self._eyes.apply_counts(sources)

    async def run(self) -> None:
        """Look until cancelled; what is in sight then has ended."""
        try:
            while True:
                self._around.watch_camera(self._live, self._name, self._keep_picture)
                try:
                    await self._examine_pictures()
                except DetectorError as error:
                    _LOG.debug("%s of %s: %s", self._name, self._live.name, error)
                except Exception:  # noqa: BLE001 - logged, and begun anew
                    _LOG.exception("%s of %s is looked at anew", self._name, self._live.name)
                finally:
                    self._around.unwatch_camera(self._live, self._name)
                wait_s, self._wait_s = self._wait_s, min(_LONGEST_WAIT_S, self._wait_s * 2)
                await asyncio.sleep(wait_s)
                self._pass_time()
        finally:
            # What was in sight ends when nobody looks any more.
            self._around.publish_sightings(self._live, self._name, self._eyes.end_sightings())

    def _keep_picture(self, picture: PictureFrame) -> None:
        # Single pictures only: a film is not decoded here.
        if picture.format == PictureForm.JPEG and 0 < picture.time_us < _LAST_US:
            self._picture = picture
            self._news.set()

    def _take_picture(self) -> PictureFrame | None:
        picture, self._picture = self._picture, None
        self._news.clear()
        return picture

    async def _examine_pictures(self) -> None:
        """Look at one picture after the other.

        Raises:
            DetectorError: the detector cannot see.

        """
        loop, period_s = asyncio.get_running_loop(), 1 / self._detect.max_rate
        due_s = loop.time()
        while True:
            await asyncio.sleep(due_s - loop.time())
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_WAIT_S):
                    await self._news.wait()
            # Nothing has come for a while: what is in sight may be gone.
            if self._picture is None:
                self._pass_time()
                continue
            # From the due time, so that the rate is kept in spite of waiting for pictures.
            now_s = loop.time()
            due_s = (due_s if now_s - due_s < period_s else now_s) + period_s
            try:
                seen = await self._around.detect_objects(
                    self._live, self._detect, self._take_picture
                )
            except Unreadable as error:
                self._say_unreadable(str(error))
                raise
            if seen is not None:
                self._say_unreadable("")
                self._wait_s = _FIRST_WAIT_S
                self._publish_found(*seen)

    def _say_unreadable(self, why: str) -> None:
        if bool(why) != self._unreadable:
            self._unreadable = bool(why)
            self._around.tell_trouble(self._live, self._name, why)

    def _publish_found(
        self, picture: PictureFrame, rgb: NDArray[np.uint8], found: Sequence[Found]
    ) -> None:
        self._last_us = picture.time_us
        self._ahead_us = self._around.now_us() - picture.time_us
        # First: what signals tell of zones and lines is by whose each thing is.
        news = self._eyes.add_picture(found, rgb, picture.time_us)
        counts = {}
        for address, count in self._eyes.count_things(found).items():
            value = count * self._counted[address].scale
            # A count that was never said counts as another: NaN equals nothing.
            said_us, said = self._said.get(address, (-_SILENCE_US, math.nan))
            if value != said or not 0 <= picture.time_us - said_us < _SILENCE_US:
                self._said[address] = (picture.time_us, value)
                counts[address] = value
        self._around.publish_counts(self._live, picture.time_us, counts)
        self._around.show_boxes(self._live, self._name, picture, found)
        self._around.publish_sightings(self._live, self._name, news)

    def _pass_time(self) -> None:
        """Let what is in sight end, by the camera's clock, when no picture has come for a while."""
        if self._last_us:
            # By the camera's clock, as if it had gone on since its last picture.
            at_us = self._around.now_us() - self._ahead_us
            self._around.publish_sightings(self._live, self._name, self._eyes.pass_time(at_us))
