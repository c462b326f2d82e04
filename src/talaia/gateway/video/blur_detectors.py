"""Asks the detectors beside this process for what is to be blurred; see `objects.worker`."""

from __future__ import annotations

import asyncio
import logging
from concurrent.futures import CancelledError
from typing import TYPE_CHECKING

from talaia.objects.errors import DetectorError
from talaia.objects.face_detector import MOST_FACES
from talaia.objects.worker import face_model

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from talaia.model.detection import Blur
    from talaia.model.site import Site
    from talaia.objects.detection import Detection
    from talaia.objects.worker import Worker

__all__ = ["BlurDetectors"]

log = logging.getLogger(__name__)
# A picture that is not looked at within this (s) stays here; the next one is tried.
LONGEST_S = 3.0
# A detector of one's own gives no more than this, and may have left out others.
MOST_PLATES = 100


class BlurDetectors:
    """What finds faces and plates, for all cameras of a gateway."""

    def __init__(
        self, worker: Callable[[Callable[[str, str], None]], Worker], longest_s: float = LONGEST_S
    ) -> None:
        """Begin no detector yet; a look that takes longer (s) is given up.

        ``worker`` makes them, and tells a function how they fare.
        """
        self._longest_s = longest_s
        self._worker = worker(_log_status)
        self._loop: asyncio.AbstractEventLoop | None = None

    def start(self) -> None:
        """Run detectors on this event loop from here on."""
        self._loop = asyncio.get_running_loop()

    def redescribe(self, site: Site) -> None:
        """Use the detectors of another description. On the event loop."""
        self._worker.redescribe(site.object_models)

    def find_private(self, blur: Blur, rgb: NDArray[np.uint8]) -> list[Detection]:
        """Find what is to be blurred on a picture (rows × columns × 3). Blocks; not on the loop.

        Raises:
            DetectorError: the picture could not be looked at, or holds more than can be told.

        """
        loop = self._loop
        if loop is None or loop.is_closed():
            raise DetectorError("the detectors do not run")
        asked = asyncio.run_coroutine_threadsafe(self._find_all(blur, rgb), loop)
        try:
            return asked.result(self._longest_s)
        except TimeoutError as error:
            asked.cancel()
            late = f"a picture was not looked at within {self._longest_s:g} s"
            raise DetectorError(late) from error
        except CancelledError as error:
            raise DetectorError("the detectors have ended") from error

    async def _find_all(self, blur: Blur, rgb: NDArray[np.uint8]) -> list[Detection]:
        found: list[Detection] = []
        for model, most in _models_of(blur):
            things = await self._worker.detect_objects(model, rgb, blur.confidence)
            if len(things) >= most:
                raise DetectorError(f"there are {most} or more on it, and not all may be known")
            found += things
        return found

    async def close(self) -> None:
        """End all detectors."""
        self._loop = None
        await self._worker.close()


def _models_of(blur: Blur) -> list[tuple[str, int]]:
    models = [(face_model(blur.side), MOST_FACES)] if blur.faces else []
    return [*models, (blur.plates, MOST_PLATES)] if blur.plates else models


def _log_status(model: str, why: str) -> None:
    # Viewers are told, and so is the logbook, by each camera whose picture does not leave.
    if why:
        log.warning("what is to be blurred is not found (%s): %s", model, why)
    else:
        log.info("what is to be blurred is found again (%s)", model)
