"""From a site's channels to those a page asked for. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from talaia.hub.auth.permissions import sees_signal
from talaia.wire.columns import Columns, pick_samples

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from talaia.hub.auth.permissions import Grants
    from talaia.model.site import Channel, Site

__all__ = ["Selection", "select_channels"]


@dataclass(frozen=True, slots=True)
class Selection:
    """The channels of a site that a subscription gets.

    Attributes:
        key: equal for subscriptions that get the same, so that they can share the work.
        place: by the site's channel number: its place in the asker's list, or -1. (channels,)
        channels: the site's channel number by place, or -1 where it was refused. (asked,)
        refused: addresses that are not there, or not for the asker.

    """

    key: tuple[str, ...]
    place: NDArray[np.int32]
    channels: NDArray[np.int64]
    refused: tuple[str, ...]

    def of(self, columns: Columns) -> Columns:
        """Give the samples of a batch that belong to this, numbered as the asker did."""
        place = self.place[columns.channel]
        keep = place >= 0
        # Where all belong to it nothing is copied.
        if np.count_nonzero(keep) < len(keep):
            columns, place = pick_samples(columns, keep), place[keep]
        return Columns(place.astype(np.uint16), columns.time_us, columns.value, columns.texts)


def select_channels(
    addresses: Sequence[str], site: Site, channels: Sequence[Channel], grants: Grants
) -> Selection:
    """Find what may be sent of ``addresses``. An address that comes twice counts once."""
    number = {channel.address: at for at, channel in enumerate(channels)}
    place = np.full(len(channels), -1, np.int32)
    found = np.full(len(addresses), -1, np.int64)
    refused = []
    for at, address in enumerate(addresses):
        wanted = number.get(address)
        # What may not be seen is answered like what is not there.
        if wanted is None or not sees_signal(
            grants, site, channels[wanted].device, channels[wanted].signal
        ):
            refused.append(address)
        # Of an address that comes twice the second has no place of its own.
        elif place[wanted] < 0:
            place[wanted] = at
            found[at] = wanted
    # What was refused leaves a gap, so that places are the asker's own.
    key = tuple(address if found[at] >= 0 else "" for at, address in enumerate(addresses))
    return Selection(key, place, found, tuple(refused))
