"""The night by itself, where the description says how (``night:``)."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.assembly.star_parts import make_star_parts
from talaia.gateway.night.night_service import NightService

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.actuation import ActuationPart
    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.foundation import FoundationPart

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
                star_parts=partial(
                    make_star_parts,
                    night=site.night,
                    clock=base.clock,
                    events=base.events,
                    arrivals=base.arrivals,
                    judge=actuation.actuation.interlocks.conditions,
                ),
                arrivals=base.arrivals,
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
