"""Whether a frame that was read out came into the archive's outbox, and by which name."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.gateway.night.night_values import StepAnswer
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from talaia.gateway.fits.frame_arrivals import FrameArrivals
    from talaia.model.night_section import NightSection
    from talaia.model.site import Site

__all__ = ["FrameFiles"]

# A file comes about when the camera says that it is read out; a slow disk has so long (s).
FILE_S = 30.0
# Of a camera of which nobody described that it gives files.
MAYBE_S = 3.0


class FrameFiles:
    """Follows each frame of the night's camera onto the disk. Event loop only.

    A frame counts when its file is there: one that a full disk did not take is taken again.
    """

    def __init__(self, arrivals: FrameArrivals | None, site: Site, night: NightSection) -> None:
        """Hear of files by ``arrivals``; none: nobody keeps pictures here."""
        self._arrivals, self._light = arrivals, night.light.command
        self._camera = self._light.partition("/")[0]
        self._must = site.devices[self._camera].frames is not None
        # Those of the frames since the last change that the hub was told.
        self._names: list[str] = []

    def expect_file(self, command: str) -> asyncio.Future[str] | None:
        """Listen for the file of a command; before it is asked for. None: it makes none."""
        if self._arrivals is None or command != self._light:
            return None
        return self._arrivals.expect_name(self._camera)

    async def follow_frame(self, answer: StepAnswer, file: asyncio.Future[str]) -> StepAnswer:
        """Wait for a frame's file; gives how the frame ended then."""
        if answer.phase is not CommandPhase.SUCCEEDED:
            return answer
        try:
            async with asyncio.timeout(FILE_S if self._must else MAYBE_S):
                self._names.append(await file)
        except TimeoutError:
            if self._must:
                why = f"the exposure ended, but no file of it came within {FILE_S:g} s"
                return StepAnswer(answer.id, CommandPhase.FAILED, why)
        return answer

    def take_names(self) -> list[str]:
        """Give the files since this was asked last."""
        names, self._names = self._names, []
        return names
