"""The WebSocket API of the founding observatory, where it is asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.legacy.server import LegacyServer, keys_of

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.actuation import ActuationPart
    from talaia.gateway.assembly.adapters import AdaptersPart
    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.assembly.samples import SamplesPart

__all__ = ["LegacyPart"]


class LegacyPart(GatewayPart):
    """Attributes: server: none where the settings name no port for it."""

    def __init__(
        self,
        *,
        base: FoundationPart,
        description: DescriptionPart,
        samples: SamplesPart,
        adapters: AdaptersPart,
        actuation: ActuationPart,
    ) -> None:
        """Read or make its certificate and token.

        Raises:
            SettingsError: they cannot be had.

        """
        self.server: LegacyServer | None = None
        settings = base.settings
        # `newest_values` is made under the same condition; asked again for the types' sake.
        if settings.door is not None and samples.newest_values is not None:
            self.server = LegacyServer(
                settings=settings.door,
                keys=keys_of(settings.door, settings.data),
                site=description.site,
                clock=base.clock,
                commands=actuation.actuation.commands,
                newest=samples.newest_values,
                answers=adapters.answers,
                events=base.events,
            )

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Serve its clients."""
        return {} if self.server is None else {"serve": self.server.run}
