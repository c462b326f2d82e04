"""What focus and centring ask of a site's devices: its own commands, in the name of the night."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.gateway.night.block_run import FRAME_MARGIN_S
from talaia.gateway.night.frames.frame_arguments import frame_arguments
from talaia.gateway.night.imaging.star_parts import DeviceFailed
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.fits.frame_arrivals import FrameArrivals
    from talaia.gateway.night.night_values import StepAnswer
    from talaia.model.night_section import NightSection
    from talaia.wire.frames import Scalar

    AskDevice = Callable[[str, Mapping[str, Scalar], float], Awaitable[StepAnswer]]

__all__ = ["NightStarDevices"]

# After the camera's word that a frame is read out its file comes within so long (s).
FILE_S = 30.0
FOCUSER_S = 120.0


class NightStarDevices:
    """A `StarDevices`. Event loop only."""

    def __init__(
        self,
        *,
        night: NightSection,
        ask: AskDevice,
        frames: FrameArrivals,
        read: Callable[[str], float | None],
    ) -> None:
        """Ask by commands.

        Args:
            night: which commands.
            ask: gives a command (its address, its arguments, its bound in s); tells how it ended.
            frames: where the camera's files are seen.
            read: gives a signal's value by its address; none when it is unknown or too old.

        """
        self._night, self._ask, self._frames, self._read = night, ask, frames, read

    async def slew_to(self, ra: float, dec: float) -> None:
        """See `StarDevices.slew_to`."""
        slew, times = self._night.slew, self._night.times
        # To correct, never across the sky; a flip is the longest of it.
        within = 180.0 / times.slew_rate + times.meridian_flip + 120.0
        await self._command(slew.command, {slew.ra: ra, slew.dec: dec}, within)
        await asyncio.sleep(times.settle)

    async def take_frame(self, seconds: float) -> bytes:
        """See `StarDevices.take_frame`."""
        rule = self._night.light
        camera = rule.command.partition("/")[0]
        args = frame_arguments(rule, seconds, target="focus or centring", gain=None)
        # Before it is asked for: a file may be there before the command's end is.
        came = self._frames.expect_frame(camera)
        try:
            within = seconds + self._night.times.readout + FRAME_MARGIN_S
            await self._command(rule.command, args, within)
            async with asyncio.timeout(FILE_S):
                return await came
        except TimeoutError as error:
            raise DeviceFailed(f"no file of {camera} came within {FILE_S:g} s") from error
        finally:
            self._frames.forget_frame(camera)

    async def move_focuser(self, position: float) -> None:
        """See `StarDevices.move_focuser`."""
        focuser = self._night.focuser
        if focuser is None:
            raise DeviceFailed("there is no focuser")
        await self._command(focuser.command, {focuser.argument: round(position)}, FOCUSER_S)

    def focuser_position(self) -> float | None:
        """See `StarDevices.focuser_position`."""
        focuser = self._night.focuser
        return None if focuser is None else self._read(focuser.position)

    def tube_temperature(self) -> float | None:
        """See `StarDevices.tube_temperature`."""
        focuser = self._night.focuser
        if focuser is None or not focuser.temperature:
            return None
        return self._read(focuser.temperature)

    async def _command(self, command: str, args: Mapping[str, Scalar], within: float) -> None:
        answer = await self._ask(command, args, within)
        if answer.phase is not CommandPhase.SUCCEEDED:
            raise DeviceFailed(f"{command}: {answer.message or answer.phase}")
