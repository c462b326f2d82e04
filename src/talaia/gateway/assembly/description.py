"""The description that counts, the numbers of its channels, and a restart with another one."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.reload.current_description import CurrentDescription, prepare_description
from talaia.gateway.reload.restart import GatewayRestart
from talaia.gateway.samples.channel_numbering import ChannelNumbering
from talaia.model.derived_signals import with_counts
from talaia.model.interlocks.unguarded import unguarded_notice

if TYPE_CHECKING:
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.reload.description_file import DescriptionFile
    from talaia.model.site import Site

__all__ = ["DescriptionPart"]

log = logging.getLogger(__name__)


class DescriptionPart(GatewayPart):
    """What the gateway was started with, and what counts now.

    Attributes:
        file: the description's; none leaves it as it is until the end.
        current: what counts now.
        numbering: of channels, which stays while the gateway runs.
        restart: ends this gateway in favour of another, with a new description.

    """

    def __init__(self, *, base: FoundationPart, site: Site, file: DescriptionFile | None) -> None:
        """Make ready what takes long."""
        # The signals that cameras imply are in everything that is made of it.
        site = with_counts(site)
        self.file = file
        # Without a text that can be written anew the hub may send no changes.
        text = file.text if file is not None and file.editable else ""
        self.current = CurrentDescription(prepare_description(site, text))
        self.numbering = ChannelNumbering(site)
        self.restart = GatewayRestart(base.settings.data, self.current)
        # Told at each start, for as long as it is so.
        if notice := unguarded_notice(site):
            log.warning("%s", notice)
            base.events.report_event("nothing_closes", notice)

    @property
    def site(self) -> Site:
        """What counts now, with the signals that its cameras imply."""
        return self.current.now.site
