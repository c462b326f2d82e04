"""Messages about alarms, to where people want them."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

from talaia.hub.api.sites.notifications import NotifyPages
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.alarms.alarm_pictures import AlarmPictures
from talaia.hub.live.alarms.trouble_watch import follow_troubles
from talaia.hub.notify.delivery_worker import LONGEST_NAP_S, DeliveryWorker
from talaia.hub.notify.senders import Sender
from talaia.hub.store.alarms.notification_channels import NotifyStore
from talaia.hub.store.sites.sightings import SightingStore

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.live.alarms.alarm_engine import AlarmEngine
    from talaia.hub.store.alarms.notification_outbox import NotificationOutbox
    from talaia.hub.store.audit import Audit

__all__ = ["NotificationsFeature"]

# So soon a message of another shard is noticed (s).
_LOOK_S = 0.5


class NotificationsFeature(Feature):
    """Delivers what waits in the outbox of alarms.

    Attributes:
        sender: sends a message by mail, chat, webhook or push.
        wake_up: lets it look into the outbox at once.

    """

    name = "notifications"

    def __init__(
        self, core: Core, *, alarms: AlarmEngine, outbox: NotificationOutbox, audit: Audit
    ) -> None:
        """Deliver what ``alarms`` puts into ``outbox``, and show there what cannot be."""
        # The seal as a function: it is read when the core opens, which is later.
        store = NotifyStore(core.database, core.secret_box)
        self._alarms = alarms
        self.sender = Sender(core.settings.notify_networks)
        self._delivering = DeliveryWorker(
            notices=outbox,
            store=store,
            sender=self.sender,
            clock=core.clock,
            told=alarms.refresh_troubles,
            # Where sites are divided, alarms of others are put into the outbox elsewhere.
            look_s=LONGEST_NAP_S if core.shard.is_whole else _LOOK_S,
            pictures=AlarmPictures(core.known_sites, SightingStore(core.database)),
        )
        # So a message goes out at once, and not at the next look at the outbox.
        self.wake_up = self._delivering.wake_up
        alarms.on_notice(self.wake_up)
        pages = NotifyPages(store=store, sender=self.sender, audit=audit, clock=core.clock)
        self.routers = [pages.make_router()]
        # One delivers for all, or each message would go out from every hub.
        self._delivers = core.shard.is_main
        if self._delivers:
            self.tasks = [BackgroundTask(name="deliver", run=self._delivering.run)]
        else:
            follow = functools.partial(follow_troubles, outbox, alarms.refresh_troubles)
            self.tasks = [BackgroundTask(name="undelivered", run=follow)]

    async def open(self) -> None:
        """See what became of messages that were under way; the alarms show it."""
        # What another hub sends now is none of those.
        if self._delivers:
            await self._delivering.recover_unsent()
        await self._alarms.refresh_troubles()
