"""Notices that the gateway sends to people by itself while the hub is away."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.notices.own_notices import OwnNotices

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.adapters import AdaptersPart
    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.assembly.uplink import UplinkPart

__all__ = ["NoticesPart"]


class NoticesPart(GatewayPart):
    """Where the settings say how people are told."""

    def __init__(
        self,
        *,
        base: FoundationPart,
        description: DescriptionPart,
        adapters: AdaptersPart,
        uplink: UplinkPart,
    ) -> None:
        """Hear of every enclosure, and of what calls somebody by night."""
        self._notices: OwnNotices | None = None
        if base.settings.notices is not None:
            self._notices = OwnNotices(
                settings=base.settings.notices,
                site=description.site.name,
                clock=base.clock,
                # Asked at each look, and not told: a link may come and go in between.
                linked=uplink.dispatcher.linked.is_set,
                events=base.events,
            )
            # Of every enclosure, whatever the hub of this link takes.
            adapters.output.subscribe_enclosures(self._notices.hear_enclosure)
            if (service := uplink.night.service) is not None:
                service.calls.subscribe_calls(
                    self._notices.raise_notice, self._notices.clear_notice
                )

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Send what is due."""
        return {} if self._notices is None else {"send": self._notices.run}
