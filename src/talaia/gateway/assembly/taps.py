"""Raw topics: what adapters hear of them, and its way to the hub."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.taps.outbox import TapOutbox
from talaia.gateway.taps.service import TapService

if TYPE_CHECKING:
    from talaia.gateway.assembly.foundation import FoundationPart

__all__ = ["TapsPart"]


class TapsPart(GatewayPart):
    """Nothing is heard before the hub wants it.

    Attributes:
        outbox: what waits for the connection for pictures.
        service: knows what the hub wants, and which topics there are.

    """

    def __init__(self, *, base: FoundationPart) -> None:
        """Want nothing yet."""
        self.outbox = TapOutbox(base.clock)
        self.service = TapService(clock=base.clock, outbox=self.outbox)
