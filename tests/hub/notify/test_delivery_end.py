"""A hub that ends while a message about an alarm is on its way: it is not left in doubt."""

# ruff: noqa: D107
import asyncio
from contextlib import suppress

from talaia.clock import HandClock
from talaia.hub.auth.secret_box import Seal
from talaia.hub.notify.delivery_worker import DeliveryWorker
from talaia.hub.notify.senders import DeliveryResult, Outcome
from talaia.hub.store.alarms.notification_channels import NotifyStore, WayKind
from talaia.hub.store.alarms.notification_outbox import NotificationOutbox

from .raised_alarm import raise_alarm


class SlowServer:
    """Takes a message when it is let."""

    def __init__(self) -> None:
        self.asked, self.let = asyncio.Event(), asyncio.Event()

    async def send_message(self, _way, _secrets, **_more) -> DeliveryResult:
        self.asked.set()
        await self.let.wait()
        return DeliveryResult(Outcome.SENT)


async def test_a_message_under_way_is_brought_to_its_end_before_the_hub_ends(database) -> None:
    clock, server = HandClock(), SlowServer()
    store, outbox = NotifyStore(database, lambda: Seal(bytes(32))), NotificationOutbox(database)
    # By mail: nobody at the other end could tell that it comes a second time.
    await raise_alarm(database, clock, store, WayKind.MAIL, secrets={})

    async def told() -> None: ...

    delivering = DeliveryWorker(notices=outbox, store=store, sender=server, clock=clock, told=told)
    running = asyncio.create_task(delivering.run())
    await server.asked.wait()
    running.cancel()
    await asyncio.sleep(0)
    server.let.set()
    with suppress(asyncio.CancelledError):
        await running
    # The next hub finds nothing of which nobody knows whether it arrived.
    await delivering.recover_unsent()
    assert await outbox.failed_alarms() == {}
