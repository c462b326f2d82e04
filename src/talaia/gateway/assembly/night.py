"""The night by itself, where the description says how (``night:``)."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.errors import SettingsError
from talaia.gateway.night.imaging.frame_reckoner import FrameReckoner
from talaia.gateway.night.imaging.part_runs import PartRuns
from talaia.gateway.night.imaging.phd2_guider import Phd2Guider
from talaia.gateway.night.night_service import NightService

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.actuation import ActuationPart
    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.night.imaging.night_star_devices import AskDevice
    from talaia.model.night_section import NightSection

__all__ = ["NightPart"]


class NightPart(GatewayPart):
    """Attributes: service: runs the night; none where the description says nothing of one."""

    def __init__(
        self, *, base: FoundationPart, description: DescriptionPart, actuation: ActuationPart
    ) -> None:
        """Take up what an earlier run left in the data folder.

        Raises:
            SpoolError: a file of the night is damaged.
            SettingsError: it measures pictures, and cannot here.

        """
        self._base, self._actuation = base, actuation.actuation
        self.service: NightService | None = None
        site = description.site
        if site.night is not None and site.place is not None:
            self.service = NightService(
                site=site,
                night=site.night,
                place=site.place,
                clock=base.clock,
                boot=base.boot,
                folder=base.settings.data / "night",
                actuation=actuation.actuation,
                send=base.lanes.send,
                events=base.events,
                on_disk=base.run_on_disk,
                star_parts=partial(self._make_star_parts, site.night),
                arrivals=base.arrivals,
            )

    def _make_star_parts(self, night: NightSection, ask: AskDevice) -> PartRuns:
        focus, centring, guider = night.focuser, night.centring, night.guider
        parts = PartRuns(
            clock=self._base.clock,
            events=self._base.events,
            reckoner=FrameReckoner(),
            guider=Phd2Guider(guider.host, guider.port) if guider is not None else None,
        )
        if focus is not None or centring is not None or night.flats is not None:
            self._add_picture_parts(night, ask, parts)
        return parts

    def _add_picture_parts(self, night: NightSection, ask: AskDevice, parts: PartRuns) -> None:
        # Imported here: what it needs is an extra.
        try:
            from talaia.gateway.night.imaging.night_star_devices import NightStarDevices
            from talaia.gateway.night.imaging.star_work import (
                CentringSolver,
                FocusRules,
                FocusRunner,
            )
            from talaia.imaging.frame_tasks import measure_level
        except ImportError as error:
            raise SettingsError(
                "the night focuses, centres or takes flats, and pictures cannot be measured here"
                f" ({error}); install talaia[observatory]"
            ) from error
        parts.add_level_meter(measure_level)
        clock, judge = self._base.clock, self._actuation.interlocks.conditions

        def read(address: str) -> float | None:
            return judge.fresh_value(address, clock.monotonic_ns())

        devices = NightStarDevices(night=night, ask=ask, frames=self._base.arrivals, read=read)
        if (focus := night.focuser) is not None:
            rules = FocusRules(focus.every, focus.degrees, focus.seconds)
            runner = FocusRunner(devices, parts.reckoner, clock, rules)
            parts.add_focuser(runner, devices.tube_temperature)
        if (centring := night.centring) is not None:
            parts.add_solver(
                CentringSolver(devices, parts.reckoner, clock, seconds=centring.seconds)
            )

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Run the night, and keep its planner."""
        if self.service is None:
            return {}
        return {"run": self.service.run, "plan": self.service.planner.run}

    async def close(self) -> None:
        """End what the night has under way; what still runs will read as unknown."""
        if self.service is not None:
            await self.service.close()
