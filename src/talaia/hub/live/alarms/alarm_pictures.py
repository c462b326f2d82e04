"""The picture that goes with a message about what a camera has seen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.alarms.state_machine import What
from talaia.hub.notify.message import AlarmPicture
from talaia.hub.store.sites.sightings import SightingsAsked
from talaia.model.alarms.alarm import AlarmKind

if TYPE_CHECKING:
    from talaia.hub.ports import DescribedSites
    from talaia.hub.store.alarms.notification_outbox import OutboxMessage, OutboxNotice
    from talaia.hub.store.sites.sightings import SightingStore

__all__ = ["AlarmPictures"]

# What rang an alarm was in sight at most so long before it was told of (µs): `for` of an alarm may
# be minutes, and the thing goes on being in sight then.
_BEFORE_US = 60_000_000
# So many of the newest are looked through for one with a picture.
_MOST = 5


class AlarmPictures:
    """Finds pictures of sightings: small ones, blurred at the gateway where a camera is blurred."""

    def __init__(self, sites: DescribedSites, store: SightingStore) -> None:
        """Read alarms from ``sites`` and pictures from ``store``."""
        self._sites = sites
        self._store = store

    async def find_picture(self, message: OutboxMessage) -> AlarmPicture | None:
        """Find the picture of what the newest line of a message is about.

        The outbox has just seen to it that the person may view the device of each line.

        Raises:
            StoreDown: the database does not answer.

        """
        for notice in reversed(message.notices):
            if notice.what is What.CLEARED:
                continue
            picture = await self._picture_of(notice)
            if picture is not None:
                return picture
        return None

    async def _picture_of(self, notice: OutboxNotice) -> AlarmPicture | None:
        live = self._sites.find_site(notice.site)
        alarm = None if live is None else live.description.alarms.get(notice.alarm)
        if alarm is None or alarm.kind is not AlarmKind.DETECTION:
            return None
        # The right was checked for the line's device, and so for no camera of another one.
        if alarm.stream.partition("/")[0] != notice.device:
            return None
        asked = SightingsAsked(
            from_us=notice.time_us - _BEFORE_US,
            to_us=notice.time_us,
            cameras=(alarm.stream,),
            label=alarm.label,
        )
        found, _ = await self._store.find_sightings(notice.site, asked, _MOST)
        for kept in found:
            if not kept.pictured:
                continue
            read = await self._store.sighting_picture(notice.site, kept.id)
            if read is not None and read[1]:
                path = f"/api/sites/{notice.site}/sightings/{kept.id}/picture"
                return AlarmPicture(read[1], path)
        return None
