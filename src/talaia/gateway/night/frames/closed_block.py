"""One try at a request of darks and biases, which are taken while the roof is closed. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.night.frames.frame_arguments import frame_arguments
from talaia.gateway.night.frames.frame_settings import FrameSettings
from talaia.gateway.night.frames.stepwise_block import StepwiseBlock
from talaia.gateway.night.simple_dispatch import frames_left
from talaia.gateway.night.step_runner import NightStep, StepsState

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.night.night_values import NightView
    from talaia.model.night_section import NightSection
    from talaia.model.observing.requests import Request

__all__ = ["ClosedBlock"]

# Beyond its exposure and readout (s).
MARGIN_S = 60.0


class ClosedBlock(StepwiseBlock):
    """See the module."""

    def __init__(
        self,
        request: Request,
        frames_done: tuple[int, ...],
        *,
        night: NightSection,
        next_id: Callable[[], str],
        now: float,
    ) -> None:
        """Begin a try; of ``frames_done`` no frame is taken again."""
        super().__init__(request, frames_done, next_id=next_id, now=now)
        self._night, self._settings = night, FrameSettings(night)

    def _next_steps(self, view: NightView) -> list[NightStep]:
        left = frames_left(self.request, tuple(self.frames_done))
        index = next((i for i, count in enumerate(left) if count), None)
        if index is None:
            return []
        configuration = self.request.configurations[index]
        frame = self._night.frame_for(configuration.type)
        if frame is None:
            self.state = StepsState.FAILED
            self.why = f"this site takes no {configuration.type} for requests"
            return []

        def read_out() -> None:
            self.frames_done[index] += 1

        number, kind = self.frames_done[index] + 1, configuration.type.lower()
        args = frame_arguments(
            frame,
            configuration.exposure,
            target=kind,
            binning=configuration.binning,
            gain=configuration.gain,
        )
        return [
            *self._settings.steps_for(configuration, frame),
            NightStep(
                words=f"{kind} {number} of {configuration.count}",
                command=frame.command,
                args=args,
                is_frame=True,
                within=configuration.exposure + self._night.times.readout + MARGIN_S,
                tries=self._night.step_tries,
                on_done=read_out,
            ),
        ]
