"""The outbox's run: takes what is due, sends it, and writes down what became of it."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING, Protocol

from talaia.hub.errors import StoreDown
from talaia.hub.notify.message import compose_message
from talaia.hub.notify.senders import DeliveryResult, Outcome
from talaia.hub.store.alarms.notification_channels import WayKind

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping, Sequence

    from talaia.clock import Clock
    from talaia.hub.notify.message import AlarmMessage, AlarmPicture
    from talaia.hub.store.alarms.notification_channels import NotifyStore, PushBrowser, Way
    from talaia.hub.store.alarms.notification_outbox import NotificationOutbox, OutboxMessage

__all__ = ["LONGEST_NAP_S", "DeliveryWorker", "PictureSource", "Sends"]

_LOG = logging.getLogger(__name__)
_SECOND_US = 1_000_000
# After the first try that did not do, after the second, …; then it has failed (s).
_AGAIN_S = (10, 60, 300, 900, 3600)
# Each is a process of its own.
_AT_ONCE = 4
# What is due is said by the wall's clock, which may be set during a nap.
LONGEST_NAP_S = 30.0
# A hub that ends waits so long for messages that are under way (s).
_FAREWELL_S = 5.0
# Until the database is asked again after it did not answer.
_RETRY_S = 1.0


class Sends(Protocol):
    """Whoever can send a message."""

    async def send_message(
        self,
        way: Way,
        secrets: Mapping[str, str],
        *,
        target: str,
        message: AlarmMessage,
        browsers: Sequence[PushBrowser] = (),
    ) -> DeliveryResult:
        """Send it; what goes wrong is in the answer."""
        ...


class PictureSource(Protocol):
    """Whoever has pictures of what messages are about."""

    async def find_picture(self, message: OutboxMessage) -> AlarmPicture | None:
        """Find one that the person may see."""
        ...


class DeliveryWorker:
    """Delivers what waits in the outbox, some at once, each by itself."""

    def __init__(
        self,
        *,
        notices: NotificationOutbox,
        store: NotifyStore,
        sender: Sends,
        clock: Clock,
        told: Callable[[], Awaitable[None]],
        pictures: PictureSource | None = None,
        look_s: float = LONGEST_NAP_S,
    ) -> None:
        """Call ``told`` whenever it has changed which alarms could not be delivered.

        ``look_s``: how often it is looked for what others have put into the outbox, who cannot
        wake this one (s).
        """
        self._look_s = look_s
        # Without it messages are words alone.
        self._pictures = pictures
        # What waits, and what became of it; the database is the only queue.
        self._notices = notices
        # The ways, their secrets and the browsers of people, read anew for each message.
        self._store = store
        self._sender = sender
        self._clock = clock
        # Called when a message was delivered, or could not be.
        self._told = told
        # Set when there may be something in the outbox before the next look.
        self._news = asyncio.Event()
        self._underway: set[asyncio.Task[None]] = set()
        # A slow server of one channel takes one turn, never all of them.
        self._turns = asyncio.Semaphore(_AT_ONCE)

    def wake_up(self) -> None:
        """Look again: something was put into the outbox."""
        self._news.set()

    async def recover_unsent(self) -> None:
        """See to what was under way when the hub ended last."""
        # Sent twice these do no harm; of the others nobody knows, and people are told so.
        again = [way.id for way in await self._store.list_ways() if _is_repeatable(way.kind)]
        unsure = await self._notices.recover_unsent(again, self._now_us())
        if unsure:
            _LOG.warning("%s messages about alarms may or may not have been delivered", unsure)

    async def run(self) -> None:
        """Deliver until cancelled; what is under way then may still arrive."""
        async with asyncio.TaskGroup() as group:
            try:
                await self._deliver_all(group)
            finally:
                # Broken off, nobody would know whether it arrived: it would count as unsure.
                if self._underway:
                    await asyncio.wait(self._underway, timeout=_FAREWELL_S)

    async def _deliver_all(self, group: asyncio.TaskGroup) -> None:
        while True:
            try:
                nap = await self._take_all(group)
            except StoreDown:
                # Nothing is lost: what waits is in the database, which is asked again soon.
                nap = _RETRY_S
            await self._wait_for_due(nap)
            # Before the look: what is put in during it wakes the next wait.
            self._news.clear()

    async def _wait_for_due(self, left_s: float) -> None:
        """Wait until something was put into the outbox, or so long."""
        while left_s > 0:
            step_s = min(left_s, self._look_s)
            try:
                async with asyncio.timeout(step_s):
                    await self._news.wait()
            except TimeoutError:
                left_s -= step_s
            else:
                return
            if left_s > 0:
                # Read only: to claim takes a turn to write. A database that is away is told of
                # by who claims.
                with contextlib.suppress(StoreDown):
                    due = await self._notices.next_due_us()
                    if due is not None:
                        left_s = min(left_s, (due - self._now_us()) / _SECOND_US)

    async def deliver_due(self) -> None:
        """Deliver all that is due now, and come back when that is done."""
        async with asyncio.TaskGroup() as group:
            await self._take_all(group)

    async def _take_all(self, group: asyncio.TaskGroup) -> float:
        """Begin with all that is due; give how long to sleep then (s)."""
        while True:
            # First the turn: what is claimed counts as being sent, and must not wait after that.
            await self._turns.acquire()
            try:
                parcel = await self._notices.claim_due(self._now_us())
            except BaseException:
                # A cancellation, too: a turn that is not given back is lost for good.
                self._turns.release()
                raise
            if parcel is None:
                self._turns.release()
                break
            task = group.create_task(self._deliver_message(parcel))
            self._underway.add(task)
            task.add_done_callback(self._underway.discard)
        due = await self._notices.next_due_us()
        if due is None:
            return LONGEST_NAP_S
        # Not at once again, even if something is due: else a loop that claims nothing would spin.
        return min(LONGEST_NAP_S, max(0.05, (due - self._now_us()) / _SECOND_US))

    async def _deliver_message(self, parcel: OutboxMessage) -> None:
        try:
            if parcel.notices:
                found = await self._store.find_way(parcel.way)
                # Asked before: while it is under way its rule may change and the way be removed.
                same = found is not None and _is_repeatable(found[0].kind)
                went = await self._send_once(parcel, found)
                await self._record_result(parcel, went, same=same)
                # After it was written down: alarms look there for what could not be delivered.
                await self._told()
        except StoreDown:
            # It stays as being sent: the next start finds it so, and says so.
            _LOG.exception("what became of a message about an alarm cannot be written down")
        except Exception:  # noqa: BLE001 - logged; see below
            # One message must not end the others; it too is found as being sent.
            _LOG.exception("a message about an alarm could not be dealt with")
        finally:
            self._turns.release()
            # There is a turn now, and perhaps something was put back.
            self._news.set()

    async def _send_once(
        self, parcel: OutboxMessage, found: tuple[Way, dict[str, str]] | None
    ) -> DeliveryResult:
        if found is None:
            return DeliveryResult(Outcome.FAILED, "the way it was to go is there no more")
        way, secrets = found
        push = way.kind is WayKind.PUSH
        browsers = await self._store.browsers_of(parcel.user) if push else []
        message = compose_message(parcel.key, parcel.notices, parcel.zone)
        if self._pictures is not None:
            message = message.with_picture(await self._pictures.find_picture(parcel))
        went = await self._sender.send_message(
            way, secrets, target=parcel.target, message=message, browsers=browsers
        )
        # A subscription that ended never comes back; the browser makes a new one.
        for number in went.gone:
            await self._store.remove_browser(parcel.user, number)
        # The other side knows it by its key: it may have it twice.
        if went.outcome is Outcome.UNSURE and _is_repeatable(way.kind):
            return DeliveryResult(Outcome.AGAIN, went.problem)
        return went

    async def _record_result(
        self, parcel: OutboxMessage, went: DeliveryResult, *, same: bool
    ) -> None:
        now = self._now_us()
        match went.outcome:
            case Outcome.SENT:
                await self._notices.mark_sent(parcel, now)
                if parcel.tries > 1:
                    _LOG.info("a message about an alarm was delivered at try %s", parcel.tries)
                return
            case Outcome.FAILED:
                await self._notices.mark_failed(parcel, now, went.problem)
            case Outcome.UNSURE:
                problem = f"it may have been delivered: {went.problem}"
                await self._notices.mark_unsure(parcel, now, problem)
            case Outcome.AGAIN if parcel.tries > len(_AGAIN_S):
                await self._notices.mark_failed(parcel, now, went.problem)
            case Outcome.AGAIN:
                # ``tries`` counts the one that was just made.
                due = now + _AGAIN_S[parcel.tries - 1] * _SECOND_US
                await self._notices.retry_later(parcel, due, went.problem, same=same)
                if parcel.tries > 1:
                    # It was said at the first try, and is said once more when it has failed.
                    return
        _LOG.warning("a message about an alarm was not delivered: %s", went.problem)

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def _is_repeatable(kind: WayKind) -> bool:
    """Tell whether the other side can see that a message is the same one once more."""
    return kind is WayKind.WEBHOOK
