"""How long each signal's history is kept, as the sites' descriptions say. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.anomaly.episode_runner import signal_of
from talaia.hub.history.forecast import DAY_US
from talaia.model.alarms.signal_groups import groups_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.site import Site

__all__ = ["RetentionPeriods"]


class RetentionPeriods:
    """The periods of all sites that were described since the hub began.

    What no description names is kept for good: a signal that is taken out of a description, or a
    site that has not come yet, must never lose its history by that.
    """

    def __init__(self) -> None:
        """Keep everything, until a description says otherwise."""
        # Microseconds by site and address of a channel; no 0 is in it.
        self._kept_us: dict[tuple[str, str], int] = {}

    def describe_site(self, site: Site) -> None:
        """Put a description's periods in the place of those that the site had."""
        for key in [key for key in self._kept_us if key[0] == site.site]:
            del self._kept_us[key]
        for channel in site.channels():
            days = site.devices[channel.device].signals[channel.signal].keep
            if days > 0:
                self._kept_us[site.site, channel.address] = round(days * DAY_US)
        # Scores of a group as long as the longest of its signals; for good if one of them is.
        for group in groups_of(site)[0]:
            kept = [self._kept_us.get((site.site, address), 0) for address in group.signals]
            if all(kept):
                self._kept_us[site.site, group.address] = max(kept)

    def kept_us(self, site: str, address: str) -> int:
        """Give how long a channel is kept (µs), scores as long as their signal; 0 is for good."""
        return self._kept_us.get((site, signal_of(address)), 0)

    def oldest_kept(self, channels: Mapping[tuple[str, str], int], now_us: int) -> dict[int, int]:
        """Give the time (µs) before which a channel's samples may go, by its number.

        Args:
            channels: their numbers by site and address; those that are kept for good are left out.
            now_us: now (µs, UTC).

        """
        return {
            channel: now_us - kept_us
            for (site, address), channel in channels.items()
            if (kept_us := self.kept_us(site, address))
        }
