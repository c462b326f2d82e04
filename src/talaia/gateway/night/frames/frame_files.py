"""Whether a frame that was read out came into the archive's outbox, and by which name."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.night.night_values import StepAnswer
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.gateway.fits.frame_arrivals import FrameArrivals
    from talaia.gateway.night.night_values import NightCommand
    from talaia.model.site import Site

__all__ = ["FrameFile", "FrameFiles"]

# A file comes about when the camera says that it is read out; a slow disk has so long (s).
FILE_S = 30.0
# Of a camera of which nobody described that it gives files.
MAYBE_S = 3.0


class FrameFile(NamedTuple):
    """What a frame's file is waited for by.

    Attributes:
        camera: which makes it.
        name: its SHA-256, once it is in the outbox.
        data: the file itself; none: nobody measures it.

    """

    camera: str
    name: asyncio.Future[str]
    data: asyncio.Future[bytes] | None


class FrameFiles:
    """Follows each frame of a request onto the disk. Event loop only.

    A frame counts when its file is there: one that a full disk did not take is taken again.

    Attributes:
        measure: gives a flat's median (counts), or none where it cannot be measured; none: nobody
            measures.

    """

    measure: Callable[[bytes], Awaitable[float | None]] | None = None

    def __init__(self, arrivals: FrameArrivals | None, site: Site) -> None:
        """Hear of files by ``arrivals``; none: nobody keeps pictures here."""
        self._arrivals = arrivals
        self._must = {name for name, device in site.devices.items() if device.frames is not None}
        # Those of the frames since the last change that the hub was told.
        self._names: list[str] = []

    def expect_file(self, command: NightCommand) -> FrameFile | None:
        """Listen for the file of a command; before it is asked for. None: it makes none."""
        if self._arrivals is None or not command.is_frame:
            return None
        camera = command.command.partition("/")[0]
        measured = command.wants_level and self.measure is not None
        return FrameFile(
            camera,
            self._arrivals.expect_name(camera),
            self._arrivals.expect_frame(camera) if measured else None,
        )

    async def follow_frame(self, answer: StepAnswer, file: FrameFile) -> StepAnswer:
        """Wait for a frame's file; gives how the frame ended then, with the level of a flat."""
        must = file.camera in self._must
        try:
            if answer.phase is not CommandPhase.SUCCEEDED:
                return answer
            async with asyncio.timeout(FILE_S if must else MAYBE_S):
                name = await file.name
                self._names.append(name)
                data = await file.data if file.data is not None else None
        except TimeoutError:
            if must:
                why = f"the exposure ended, but no file of it came within {FILE_S:g} s"
                return StepAnswer(answer.id, CommandPhase.FAILED, why)
            return answer
        finally:
            if file.data is not None and self._arrivals is not None:
                self._arrivals.forget_frame(file.camera)
        if data is None or self.measure is None:
            return answer
        return answer._replace(level=await self.measure(data))

    def take_names(self) -> list[str]:
        """Give the files since this was asked last."""
        names, self._names = self._names, []
        return names
