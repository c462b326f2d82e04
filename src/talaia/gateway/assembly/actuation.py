"""All that acts on devices: driving and STOP, interlocks, commands, and sequences of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.actuation import Actuation
from talaia.gateway.assembly.gateway_part import GatewayPart

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.adapters import AdaptersPart
    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.detection import DetectionPart
    from talaia.gateway.assembly.foundation import FoundationPart

__all__ = ["ActuationPart"]


class ActuationPart(GatewayPart):
    """See `Actuation`, which is what others use of it."""

    def __init__(
        self,
        *,
        base: FoundationPart,
        description: DescriptionPart,
        adapters: AdaptersPart,
        detection: DetectionPart,
    ) -> None:
        """Take up what an earlier run left in the data folder.

        Raises:
            SpoolError: the data folder cannot be used.

        """
        self.actuation = Actuation(
            site=description.site,
            boot=base.boot,
            clock=base.clock,
            output=adapters.output,
            target=adapters.adapter,
            readings=detection.readings,
            data=base.settings.data,
            # One thread for all of it, so that what is written first is on disk first.
            on_disk=base.run_on_disk,
        )
        # Who drove it loses the lease: nobody is to move it unawares when it comes back.
        adapters.adapter.subscribe_losses(
            lost=self.actuation.driving.robot_lost, back=self.actuation.driving.robot_back
        )

    def start(self) -> None:
        """Begin to keep time."""
        self.actuation.timer.reset_timer()

    def halt_all(self) -> None:
        """End every hold with a zero now, while there is still an adapter to carry it."""
        self.actuation.driving.halt_all()

    def stop_judging(self) -> None:
        """Keep no time any more.

        An adapter that ends has no readings any more: that is no unsafe weather.
        """
        self.actuation.timer.close()

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Write what the disk did not take at once."""
        return {"write again": self.actuation.keep_written}

    def is_busy(self) -> bool:
        """Tell whether anything moves, or is about to."""
        return self.actuation.busy

    async def close(self) -> None:
        """Finish what was begun; what still runs at the robot will read as unknown."""
        # Again, for `close` may be called without `run`.
        self.actuation.timer.close()
        # Sequences first: they give commands, which would come in while the others close.
        await self.actuation.sequences.close()
        await self.actuation.requests.close()
        await self.actuation.commands.close()
