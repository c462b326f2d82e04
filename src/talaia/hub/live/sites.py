"""The sites the hub knows, and what is true of each now."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from talaia.hub.anomaly.selection import score_channels
from talaia.hub.live.gateways.frame_limits import FrameLimits
from talaia.hub.live.gateways.handed_down import HandedDown
from talaia.hub.live.last_values import Latest
from talaia.hub.live.site_state import (
    CurrentState,
    LinkedGateway,
    RetainedState,
    RivalGateways,
    SitePresence,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from talaia.hub.live.site_state import SiteLink
    from talaia.model.site import Channel, Site

__all__ = ["LiveSite", "Sites"]


@dataclass(slots=True)
class LiveSite:
    """One site, now: what is described, and what is known, in parts by how long each holds.

    Attributes:
        description: the site as it is described; written by `Sites.describe_site` alone, as are the
            next four, so that they always fit each other.
        catalogue: the name of its list of channels.
        channels: the description's own, in the order by which batches number them.
        every: what a page may subscribe to: ``channels``, and after them those of the scores of
            its detectors.
        latest: the newest sample of each of ``every``; kept while the gateway is away.
        renamed: channels that have another address now, by former ones; kept over links, for a
            gateway's spool may be older than the change.
        presence: whether its gateway is connected.
        gateway: what the gateway that is or was linked has said of itself.
        rivals: other gateways with this identity.
        current: what holds only while a link stands.
        retained: what is shown until the next link, even while the gateway is away.
        frame_limits: how much its gateways may say yet; kept over links.
        handed_down: in whose names the hub has asked something of it; kept over links.

    """

    description: Site
    catalogue: str
    channels: tuple[Channel, ...]
    every: tuple[Channel, ...]
    latest: Latest
    renamed: dict[str, str] = field(default_factory=dict)
    presence: SitePresence = field(default_factory=SitePresence)
    gateway: LinkedGateway = field(default_factory=LinkedGateway)
    rivals: RivalGateways = field(default_factory=RivalGateways)
    current: CurrentState = field(default_factory=CurrentState)
    retained: RetainedState = field(default_factory=RetainedState)
    frame_limits: FrameLimits = field(default_factory=FrameLimits)
    handed_down: HandedDown = field(default_factory=HandedDown)

    @property
    def edition(self) -> str:
        """A name for the description as it is now: another one has another."""
        # 64 bits of the hash: enough to tell the descriptions of one site apart.
        said, catalogue = self.gateway.fingerprint
        return said.hex()[:16] if said else catalogue or self.catalogue

    @property
    def described(self) -> int:
        """How many things are described of which a gateway reports states."""
        site = self.description
        return len(site.devices) + len(site.interlocks) + len(site.enclosures)

    @property
    def name(self) -> str:
        """The site's short name."""
        return self.description.site

    @property
    def online(self) -> bool:
        """Whether its gateway is connected."""
        return self.presence.link is not None

    @property
    def link(self) -> SiteLink | None:
        """The way down to its gateway; None while it is away."""
        return self.presence.link

    def attach_link(self, link: SiteLink, gateway: LinkedGateway, now_us: int) -> None:
        """Begin a link from ``now_us`` on (UTC); nothing said over an earlier one counts."""
        self.presence.mark_online(link, now_us)
        self.gateway = gateway
        # It is no rival any more, so people are told again if it is kept out later.
        self.rivals.boots.discard(gateway.boot)
        self.rivals.settled.discard(gateway.boot)
        self.rivals.chosen = None
        self.retained = RetainedState()

    def detach_link(self, now_us: int) -> None:
        """End the link at ``now_us`` (UTC)."""
        self.presence.mark_offline(now_us)
        # Nobody is kept out while no link stands.
        self.rivals.seen_us = 0
        self.rivals.wake_held()

    def forget_current(self) -> None:
        """Drop what holds only while a link stands, once pages were told of its end."""
        self.current = CurrentState()

    def drop_undescribed(self) -> None:
        """Forget what was known of devices, interlocks and enclosures no longer described."""
        self.current.drop_undescribed(self.description)
        self.retained.drop_undescribed(self.description)


class Sites:
    """The sites by name; those that are away are known from the database."""

    def __init__(self) -> None:
        """Start with none."""
        self._sites: dict[str, LiveSite] = {}
        # The same in the order of their names; made when it is asked for.
        self._in_order: tuple[LiveSite, ...] | None = None

    def __iter__(self) -> Iterator[LiveSite]:
        """Go through the sites in the order of their names."""
        if self._in_order is None:
            self._in_order = tuple(self._sites[name] for name in sorted(self._sites))
        # A site may be added meanwhile: that makes another one.
        return iter(self._in_order)

    def find_site(self, name: str) -> LiveSite | None:
        """Find a site by its short name."""
        return self._sites.get(name)

    def describe_site(
        self, description: Site, catalogue: str, renamed: Mapping[str, str] | None = None
    ) -> LiveSite:
        """Add a site or take its new description; newest values stay if the channels do.

        ``renamed`` are channels that have another address now, by the one before.
        """
        live = self._sites.get(description.site)
        channels = description.channels()
        # Scores behind the rest: a gateway numbers its batches by `channels` alone.
        every = (*channels, *score_channels(description, len(channels)))
        if live is None:
            live = LiveSite(description, catalogue, channels, every, Latest(len(every)))
            self._sites[description.site] = live
            self._in_order = None
            return live
        # Most descriptions leave the list as it is, and values in their places.
        if every != live.every:
            live.latest = _carry_values(live.latest, live.every, every, renamed or {})
        live.description, live.catalogue = description, catalogue
        live.channels, live.every = channels, every
        return live


def _carry_values(
    latest: Latest,
    before: tuple[Channel, ...],
    channels: tuple[Channel, ...],
    renamed: Mapping[str, str],
) -> Latest:
    """Carry the newest values over to another list of channels."""
    moved = Latest(len(channels))
    # By the addresses that they have now.
    number = {
        renamed.get(channel.address, channel.address): at for at, channel in enumerate(before)
    }
    for at, channel in enumerate(channels):
        was = number.get(channel.address)
        if was is not None:
            latest.moved_to(moved, was, at)
    return moved
