"""What looks at stars for a night, made by what the description names."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.errors import SettingsError
from talaia.gateway.night.imaging.frame_reckoner import FrameReckoner
from talaia.gateway.night.imaging.part_runs import PartRuns
from talaia.gateway.night.imaging.phd2_guider import Phd2Guider

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.gateway.fits.frame_arrivals import FrameArrivals
    from talaia.gateway.night.imaging.night_star_devices import AskDevice
    from talaia.gateway.ports import EventSink
    from talaia.gateway.safety.condition_judge import ConditionJudge
    from talaia.model.night_section import NightSection

__all__ = ["make_star_parts"]


def make_star_parts(
    ask: AskDevice,
    *,
    night: NightSection,
    clock: Clock,
    events: EventSink,
    arrivals: FrameArrivals,
    judge: ConditionJudge,
) -> PartRuns:
    """Make focus, centring and guiding; ``ask`` gives devices commands, ``judge`` their readings.

    Raises:
        SettingsError: pictures are to be measured, and cannot be here.

    """
    guider = night.guider
    parts = PartRuns(
        clock=clock,
        events=events,
        reckoner=FrameReckoner(),
        guider=Phd2Guider(guider.host, guider.port) if guider is not None else None,
    )
    if night.focuser is None and night.centring is None and night.flats is None:
        return parts
    # Imported here: what it needs is an extra.
    try:
        from talaia.gateway.night.imaging.night_star_devices import NightStarDevices
        from talaia.gateway.night.imaging.star_work import CentringSolver, FocusRules, FocusRunner
        from talaia.imaging.frame_tasks import measure_level
    except ImportError as error:
        raise SettingsError(
            "the night focuses, centres or takes flats, and pictures cannot be measured here"
            f" ({error}); install talaia[observatory]"
        ) from error
    parts.add_level_meter(measure_level)

    def read(address: str) -> float | None:
        return judge.fresh_value(address, clock.monotonic_ns())

    devices = NightStarDevices(night=night, ask=ask, frames=arrivals, read=read)
    longer = night.filter.exposure_factor if night.filter is not None else lambda _name: 1.0
    if (focus := night.focuser) is not None:
        rules = FocusRules(focus.every, focus.degrees, focus.seconds, longer)
        runner = FocusRunner(devices, parts.reckoner, clock, rules)
        parts.add_focuser(runner, devices.tube_temperature)
    if (centring := night.centring) is not None:
        solver = CentringSolver(
            devices, parts.reckoner, clock, seconds=centring.seconds, longer=longer
        )
        parts.add_solver(solver)
    return parts
