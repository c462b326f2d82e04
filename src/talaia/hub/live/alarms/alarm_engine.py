"""The alarms of all sites: samples and news in; states, messages and marks out.

Two halves. The first never waits (`SiteAlarms`): it holds each sample against the conditions that
look at it, and puts what begins or ceases to count into a queue. The second, here, takes the
queue, one thing after the other, what people ask for among it, and tells nobody of anything
before it is in the database. What cannot be written waits there, and is tried again.

Long, because all that comes of an alarm is told here, in its order.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.clock import SECOND
from talaia.hub.alarms.conditions import DetectedThing
from talaia.hub.alarms.state_machine import Event, NotNow, Phase, Retire, State, What, apply_event
from talaia.hub.errors import StoreDown
from talaia.hub.live.alarms.alarm_state import LiveAlarm, alarm_news, event_news, ghost_alarm
from talaia.hub.live.alarms.site_alarms import SiteAlarms
from talaia.hub.store.alarms.alarm_states import AlarmChange, MadeAlarm
from talaia.model.alarms.alarm import Alarm
from talaia.model.alarms.standard_alarms import standard_alarms
from talaia.wire.frames import RecordingRequest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    import numpy as np
    from numpy.typing import NDArray

    from talaia.clock import Clock
    from talaia.hub.alarms.state_machine import Happened
    from talaia.hub.live.pages.page_connections import Browser, Browsers
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.ports import AnomalyReport, SharedCause, SightingEvent
    from talaia.hub.store.alarms.alarm_states import AlarmStore
    from talaia.hub.store.alarms.notification_outbox import NotificationOutbox
    from talaia.model.site import Site
    from talaia.wire.columns import Columns

__all__ = ["AlarmEngine"]

_LOG = logging.getLogger(__name__)
# Conditions are looked at so often at least: values age, delays end (s).
_TICK_S = 0.5
_TICK_NS = round(_TICK_S * SECOND)
# Between two attempts to write while the database fails (s).
_RETRY_S = 1.0
# Without a look for so long something is wrong with whoever looks.
_LONGEST_LOOK_NS = 10 * SECOND
# A batch of what happened is one transaction of at most so many.
_MOST_A_COMMIT = 200


class _Ask(NamedTuple):
    """Something to be done to an alarm; ``done`` gets the outcome, where a person waits for it."""

    # The events of an alarm take effect in the order of the queue, those of people among them.
    live: LiveAlarm
    event: Event
    done: asyncio.Future[State] | None = None


class AlarmEngine:
    """Watches, decides, writes down, and tells."""

    def __init__(
        self,
        *,
        sites: Sites,
        browsers: Browsers,
        store: AlarmStore,
        notices: NotificationOutbox,
        clock: Clock,
    ) -> None:
        """Begin without any; `open` brings back what the database has."""
        # The sites as they are now; only read here.
        self._sites = sites
        # Pages; told of a state only once it is in the database.
        self._browsers = browsers
        # States, what happened, and alarms made in the page.
        self._store = store
        # Read for messages that could not be delivered.
        self._notices = notices
        # Monotonic for looks and delays, wall for what is written down.
        self._clock = clock
        # By site: what its description asks for, and what was made in the page.
        self._of: dict[str, SiteAlarms] = {}
        # As the database has them, by site and alarm; also of alarms that are described no more.
        self._states: dict[tuple[str, str], State] = {}
        # By site and alarm: those made in the page.
        self._made: dict[str, dict[str, MadeAlarm]] = {}
        # What was decided and is not in the database yet; nobody is told of it before.
        self._queue: deque[_Ask] = deque()
        # Set when there is something to write, or the end.
        self._news = asyncio.Event()
        # Set once: what waits is written, and `run` ends.
        self._stopping = False
        # When all conditions were evaluated last (monotonic).
        self._looked_ns = clock.monotonic_ns()
        # Wakes whoever delivers messages; does nothing until `on_notice` is called.
        self._wake_delivery: Callable[[], None] = lambda: None

    def on_notice(self, wake: Callable[[], None]) -> None:
        """Call ``wake`` when something may have been put into the outbox."""
        self._wake_delivery = wake

    async def open(self) -> None:
        """Bring back what the database has, for the sites that are known."""
        # Before any description is taken: `_initial_state` looks them up.
        self._states = await self._store.load_states()
        for made in await self._store.list_made():
            self._made.setdefault(made.site, {})[made.alarm] = made
        for live in self._sites:
            self.redescribe(live)
        await self.refresh_troubles()

    # ── what is watched ─────────────────────────────────────────────────────────────────────

    def redescribe(self, live: LiveSite) -> None:
        """Take a site's description, new or the same; alarms that stay keep their state."""
        known = self._of.get(live.name)
        if known is None:
            known = self._of[live.name] = SiteAlarms(
                self._clock, self._enqueue_event, self._publish_alarm
            )
        before = known.add_described(
            live,
            _alarm_definitions(live.description, self._made.get(live.name, {})),
            lambda name, was: self._initial_state(live.name, name, was),
        )
        for name, gone in before.items():
            if name not in known.alarms:
                self._retire_alarm(gone)
        # Of former descriptions, whose alarms are described no more.
        for site, name in [key for key in self._states if key[0] == live.name]:
            state = self._states[site, name]
            if name not in known.alarms and name not in before and _is_standing(state):
                self._retire_alarm(ghost_alarm(live, name, state))
        # Also those that stay: their names or units may be other ones now.
        for alarm in known.alarms.values():
            self._publish_alarm(alarm)
        self._news.set()

    def alarms_of(self, site: str) -> Iterator[LiveAlarm]:
        """Go through the alarms of a site."""
        known = self._of.get(site)
        return iter(list(known.alarms.values()) if known else [])

    def find_alarm(self, site: str, alarm: str) -> LiveAlarm | None:
        """Find one."""
        known = self._of.get(site)
        return known.alarms.get(alarm) if known else None

    def _initial_state(self, site: str, name: str, before: LiveAlarm | None) -> State:
        """Give how an alarm stands when it is described: as before, or as the database has it."""
        if before is None:
            return self._states.get((site, name), State())
        state = before.state
        # One whose former self is in the queue yet: the database will have it so.
        for ask in self._queue:
            if ask.live is before:
                # `settle_changes` refuses it too, and whoever asked is told there.
                with contextlib.suppress(NotNow):
                    state = apply_event(state, ask.event)[0]
        return state

    def _retire_alarm(self, gone: LiveAlarm) -> None:
        # Before it is published: pages are told that it is gone.
        gone.alarm = None
        self._enqueue_event(gone, Retire(self._now_us()))
        self._publish_alarm(gone)

    # ── what is true ────────────────────────────────────────────────────────────────────────

    def evaluate_samples(
        self, live: LiveSite, columns: Columns, heard_ns: NDArray[np.float64] | None = None
    ) -> None:
        """Hold live samples against the conditions that look at them; never waits.

        ``heard_ns`` is when each was heard (monotonic), at most one of a channel; none: just now.
        """
        known = self._of.get(live.name)
        if known is not None:
            known.evaluate_samples(live, columns, heard_ns)

    def report_anomaly(self, news: AnomalyReport) -> None:
        """Take what a detector of anomalies says; see `talaia.hub.ports.AnomalySink`."""
        seen = DetectedThing(score=news.score, why=news.why)
        which, over = (news.began_us, news.detector), news.ended_us is not None
        self._handle_happening(news.site, (news.channel, ""), which, seen, over=over)

    def report_cause(self, news: SharedCause) -> None:
        """Take what became unusual together; see `talaia.hub.ports.CauseSink`."""
        seen = DetectedThing(
            score=news.score, why=news.why, began_us=news.began_us, shares=news.shares
        )
        which, over = (news.began_us, ""), news.over
        self._handle_happening(news.site, (news.part, ""), which, seen, over=over)

    def report_sighting(self, news: SightingEvent) -> None:
        """Take what a detector of objects says; see `talaia.hub.ports.SightingSink`."""
        seen = DetectedThing(many=news.many, confidence=news.confidence)
        what = (news.camera, news.label)
        over = news.ended_us is not None
        self._handle_happening(news.site, what, (news.began_us, ""), seen, over=over)

    def evaluate_conditions(self) -> None:
        """Hold what is known against every condition: values age, and delays end."""
        for site, known in self._of.items():
            # Of thousands of sites most may have none.
            if known.alarms and (live := self._sites.find_site(site)) is not None:
                known.evaluate_conditions(live)

    def _handle_happening(
        self,
        site: str,
        what: tuple[str, str],
        which: tuple[int, str],
        seen: DetectedThing,
        *,
        over: bool,
    ) -> None:
        known, live = self._of.get(site), self._sites.find_site(site)
        if known is not None and live is not None:
            known.handle_happening(live, what, which, seen, over=over)

    # ── what comes of it ────────────────────────────────────────────────────────────────────

    async def apply_action(self, live: LiveAlarm, event: Event) -> State:
        """Do what a person asks; it is in the database when this comes back.

        Raises:
            NotNow: it makes no sense as the alarm stands.
            StoreDown: it cannot be written; nothing was done.

        """
        done: asyncio.Future[State] = asyncio.get_running_loop().create_future()
        self._enqueue_event(live, event, done)
        return await done

    async def define_alarm(self, live: LiveSite, made: MadeAlarm) -> None:
        """Keep an alarm that was made in the page, in place of the one of its name."""
        # First in the database: no page sees an alarm that a restart would lose.
        await self._store.save_made(made)
        self._made.setdefault(made.site, {})[made.alarm] = made
        self.redescribe(live)

    async def forget_alarm(self, live: LiveSite, alarm: str) -> bool:
        """Remove an alarm that was made in the page; False when there is none."""
        if not await self._store.delete_made(live.name, alarm):
            return False
        self._made.get(live.name, {}).pop(alarm, None)
        self.redescribe(live)
        return True

    async def run(self) -> None:
        """Look, write down and tell, until `stop`; what is decided by then is written first."""
        failing = False
        while not self._stopping or self._queue:
            # Time alone makes values too old and ends delays, so there is a look without news too.
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_TICK_S):
                    await self._news.wait()
            # Before the work: what comes meanwhile wakes it again.
            self._news.clear()
            try:
                self._look_again()
                await self.settle_changes()
            except StoreDown:
                # Logged when it begins to fail, not at each attempt.
                if not failing:
                    _LOG.exception("what happens to alarms cannot be written down; it waits")
                failing = True
                # The end of the hub does not wait for a database; the next start judges anew.
                if self._stopping:
                    return
                await asyncio.sleep(_RETRY_S)
                # There is work left, so the next turn does not wait for news.
                self._news.set()
            except Exception:  # noqa: BLE001 - logged, and tried again
                # Alarms that end without a word would be the worst of all.
                _LOG.exception("what happens to alarms cannot be dealt with; it is tried again")
                if self._stopping:
                    return
                await asyncio.sleep(_RETRY_S)
                self._news.set()
            else:
                failing = False

    def _look_again(self) -> None:
        now = self._clock.monotonic_ns()
        if now - self._looked_ns >= _TICK_NS:
            self._looked_ns = now
            self.evaluate_conditions()

    @property
    def judging(self) -> bool:
        """Whether conditions are being looked at; a database that is slow may hold that up."""
        waited = self._clock.monotonic_ns() - self._looked_ns
        return waited < _LONGEST_LOOK_NS or bool(self._queue)

    def stop(self) -> None:
        """Let `run` end."""
        self._stopping = True
        self._news.set()

    async def settle_changes(self) -> None:
        """Write down and tell all that was decided.

        Raises:
            StoreDown: nothing of the rest was done; it waits, but for what people asked for,
                who are told at once.

        """
        while self._queue:
            # A copy: after a failure all of it is still in the queue, in its order.
            batch = [self._queue[at] for at in range(min(len(self._queue), _MOST_A_COMMIT))]
            changes, states, refused = _worked_out(batch)
            try:
                if changes:
                    await self._store.commit_changes(
                        [change for _, change in changes], self._now_us()
                    )
            except StoreDown as error:
                self._put_back(batch, error)
                raise
            # Nothing is awaited from here on: who awaits `done` sees the new state when it wakes.
            for ask in batch:
                # Those of this batch are still in front: others were appended while the commit was
                # awaited.
                self._queue.popleft()
                if ask.done is not None and not ask.done.done():
                    if id(ask) in refused:
                        ask.done.set_exception(refused[id(ask)])
                    else:
                        ask.done.set_result(states[ask.live])
            # Only after the commit: `state` is what the database has.
            for live, state in states.items():
                live.state = state
                self._states[live.about.site, live.about.alarm] = state
            self._publish_changes(changes)

    def _put_back(self, batch: list[_Ask], error: StoreDown) -> None:
        # A person can ask again; what a condition has decided stays and is tried again.
        for ask in batch:
            if ask.done is not None:
                self._queue.remove(ask)
                if not ask.done.done():
                    ask.done.set_exception(error)

    def _publish_changes(self, changes: list[tuple[LiveAlarm, AlarmChange]]) -> None:
        """Tell of what is in the database now."""
        # Once for each alarm, with its last state, however often it changed in this batch.
        for live in dict.fromkeys(live for live, _ in changes):
            self._publish_alarm(live)
        for live, change in changes:
            for happened in change.happened:
                self._browsers.broadcast_message(event_news(live, happened))
                if happened.what is What.RAISED:
                    # A new episode: whether messages of the last one failed is of no interest any
                    # more.
                    live.undelivered = ""
                    _begin_recording(self._sites.find_site(live.about.site), live, happened)
        if changes:
            # The messages were put into the outbox by the same commit.
            self._wake_delivery()

    async def refresh_troubles(self) -> None:
        """Read anew which alarms could not be delivered, and tell."""
        troubles = await self._notices.failed_alarms()
        for site, known in self._of.items():
            for name, alarm in known.alarms.items():
                # Only what differs is told.
                problem = troubles.get((site, name), "")
                if problem != alarm.undelivered:
                    alarm.undelivered = problem
                    self._publish_alarm(alarm)

    def greet(self, browser: Browser) -> None:
        """Tell a page that has just come how all alarms stand that it may see."""
        for known in self._of.values():
            for alarm in known.alarms.values():
                browser.send_message(alarm_news(alarm))

    def _enqueue_event(
        self, live: LiveAlarm, event: Event, done: asyncio.Future[State] | None = None
    ) -> None:
        self._queue.append(_Ask(live, event, done))
        self._news.set()

    def _publish_alarm(self, live_alarm: LiveAlarm) -> None:
        self._browsers.broadcast_message(alarm_news(live_alarm))

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def _begin_recording(live: LiveSite | None, raised: LiveAlarm, happened: Happened) -> None:
    """Ask the site's gateway to record around an alarm, where its description wants that."""
    if raised.alarm is None or not raised.alarm.record or live is None or live.link is None:
        return
    # At most what a request may hold.
    why = f"alarm {raised.about.name}: {happened.message}"[:500]
    live.link.send(RecordingRequest(on=True, who="alarm", why=why, alarm=True))


def _alarm_definitions(
    site: Site, made_in_page: Mapping[str, MadeAlarm]
) -> Iterator[tuple[str, Alarm, bool]]:
    """Give each alarm with its name, and whether it was made in the page."""
    own = {**site.alarms, **standard_alarms(site)}
    for name, alarm in own.items():
        yield name, alarm, False
    for name, made in made_in_page.items():
        if name in own:
            continue
        try:
            yield name, msgspec.json.decode(made.definition, type=Alarm), True
        # One that cannot be read any more must not take the site's other alarms with it.
        except msgspec.MsgspecError:
            _LOG.exception("the alarm %s of %s cannot be read", name, site.site)


def _worked_out(
    batch: list[_Ask],
) -> tuple[list[tuple[LiveAlarm, AlarmChange]], dict[LiveAlarm, State], dict[int, NotNow]]:
    """Give the changes, the state after them of each alarm, and what is refused and why."""
    states: dict[LiveAlarm, State] = {}
    changes: list[tuple[LiveAlarm, AlarmChange]] = []
    refused: dict[int, NotNow] = {}
    for ask in batch:
        # Several events of an alarm in one batch build on each other.
        before = states.get(ask.live, ask.live.state)
        try:
            after, happened = apply_event(before, ask.event)
        except NotNow as error:
            refused[id(ask)] = error
            after, happened = before, ()
        states[ask.live] = after
        # A comment changes no state and is written all the same.
        if happened or after != before:
            changes.append((ask.live, AlarmChange(ask.live.about, after, happened)))
    return changes, states, refused


def _is_standing(state: State) -> bool:
    # A normal alarm may be shelved, and retiring ends that too.
    return state.phase is not Phase.NORMAL or bool(state.shelved_until_us)
