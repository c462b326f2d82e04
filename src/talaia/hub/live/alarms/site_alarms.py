"""The alarms of one site: samples and news of detectors in; what begins or ceases to count out.

Nothing here waits. Each sample is held against the conditions that look at it; what comes of it
is handed on, to be written down and told.

Long, because samples, detectors and time all lead to the same judgement.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from talaia.clock import SECOND
from talaia.hub.alarms.condition_watch import ConditionTurn, ConditionWatch
from talaia.hub.alarms.conditions import (
    AlarmCondition,
    ConditionReading,
    ConditionVerdict,
    DetectedThing,
    Truth,
)
from talaia.hub.alarms.reminders import first_told
from talaia.hub.alarms.state_machine import Clear, Grow, Raise, State, Unshelve
from talaia.hub.live.alarms.alarm_state import LiveAlarm, device_of
from talaia.hub.live.pages.conflate import conflate
from talaia.hub.store.alarms.notification_outbox import About
from talaia.model.checks.alarm_checks import Addresses, alarm_findings
from talaia.wire.columns import pick_samples

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from talaia.clock import Clock
    from talaia.hub.alarms.state_machine import Event
    from talaia.hub.live.sites import LiveSite
    from talaia.model.alarms.alarm import Alarm
    from talaia.wire.columns import Columns

__all__ = ["SiteAlarms"]

# A batch with more samples of what is watched is made fewer, its extremes kept.
_MOST_AT_ONCE = 256


class SiteAlarms:
    """What is known of one site for its alarms.

    Attributes:
        alarms: by their short names.

    """

    def __init__(
        self,
        clock: Clock,
        put: Callable[[LiveAlarm, Event], None],
        tell: Callable[[LiveAlarm], None],
    ) -> None:
        """Begin without any; ``put`` takes what is to happen, ``tell`` what is no longer known."""
        self.alarms: dict[str, LiveAlarm] = {}
        # Monotonic for ages and delays, wall for what is written down.
        self._clock = clock
        # Into the engine's queue; nothing is changed here before the database has it.
        self._enqueue = put
        self._publish = tell
        # For each channel of the wire's list, whether anybody looks at it, and who does.
        self._watched: NDArray[np.bool_] = np.zeros(0, bool)
        self._lookers: dict[int, list[LiveAlarm]] = {}
        # The addresses of that list, in its order.
        self._addresses: tuple[str, ...] = ()
        # The newest value, its text and when it came (monotonic ns), by address.
        self._values: dict[str, tuple[float, str, int]] = {}
        # What goes on now, as detectors say, by whom and of what.
        self._seen: dict[tuple[str, str], dict[tuple[int, str], DetectedThing]] = {}

    def add_described(
        self,
        live: LiveSite,
        definitions: Iterable[tuple[str, Alarm, bool]],
        state_of: Callable[[str, LiveAlarm | None], State],
    ) -> dict[str, LiveAlarm]:
        """Take what is described: name, alarm, and whether it was made in the page.

        ``state_of`` says how one begins, by what it was before; gives those before this one.
        """
        before, self.alarms = self.alarms, {}
        addresses = Addresses(live.description)
        for name, alarm, made in definitions:
            was = before.get(name)
            self.alarms[name] = _made_live(
                live,
                addresses,
                name=name,
                alarm=alarm,
                before=was,
                state=state_of(name, was),
                made=made,
            )
        self._index_channels(live)
        return before

    def evaluate_samples(
        self, live: LiveSite, columns: Columns, heard_ns: NDArray[np.float64] | None = None
    ) -> None:
        """Hold live samples against the conditions; see `AlarmEngine.evaluate_samples`."""
        # Between a new description and `add_described` the numbers would be of two lists.
        if not self._lookers or not len(columns) or len(self._watched) != len(live.channels):
            return
        keep = self._watched[columns.channel]
        if not np.count_nonzero(keep):
            return
        mine = pick_samples(columns, keep)
        now = self._clock.monotonic_ns()
        # Of what was held back at most one sample of a channel comes, so nothing is made fewer.
        if heard_ns is not None:
            heard = heard_ns[keep].astype(np.int64).tolist()
        else:
            mine = conflate(mine) if len(mine) > _MOST_AT_ONCE else mine
            heard = [now] * len(mine)
        values = mine.value.tolist()
        # Each sample by itself: one that is beyond a limit for a moment counts too.
        for place, at in enumerate(mine.channel.tolist()):
            text = mine.texts.get(place, "")
            self._values[self._addresses[at]] = (values[place], text, heard[place])
            for live_alarm in self._lookers[at]:
                self._judge_alarm(live, live_alarm, now)

    def handle_happening(
        self,
        live: LiveSite,
        what: tuple[str, str],
        which: tuple[int, str],
        seen: DetectedThing,
        *,
        over: bool,
    ) -> None:
        """Take what a detector says of ``what`` (camera or channel, label), ``which`` names it."""
        going = self._seen.setdefault(what, {})
        now = self._clock.monotonic_ns()
        # Told only when it was over, it has been there all the same.
        going[which] = seen
        mine = [
            live_alarm
            for live_alarm in self.alarms.values()
            if live_alarm.condition is not None and live_alarm.condition.happening == what
        ]
        for live_alarm in mine:
            self._judge_alarm(live, live_alarm, now)
        if over:
            del going[which]
            for live_alarm in mine:
                self._judge_alarm(live, live_alarm, now)

    def evaluate_conditions(self, live: LiveSite) -> None:
        """Hold what is known against every condition: values age, delays and shelves end."""
        now, now_us = self._clock.monotonic_ns(), self._now_us()
        for live_alarm in self.alarms.values():
            self._judge_alarm(live, live_alarm, now)
            until = live_alarm.state.shelved_until_us
            # Asked for again at each look until it is written; the state machine ignores repeats.
            if until and until <= now_us:
                self._enqueue(live_alarm, Unshelve(now_us))
            if live_alarm.alarm is not None:
                again = live_alarm.reminding.next_due(
                    live_alarm.alarm, live_alarm.state, now, now_us
                )
                if again is not None:
                    self._enqueue(live_alarm, again)

    def _index_channels(self, live: LiveSite) -> None:
        number = {channel.address: at for at, channel in enumerate(live.channels)}
        self._watched = np.zeros(len(live.channels), bool)
        self._addresses = tuple(channel.address for channel in live.channels)
        self._lookers = {}
        for live_alarm in self.alarms.values():
            for address in live_alarm.condition.inputs if live_alarm.condition else ():
                # Every address is in the list: a condition is made only where `alarm_findings`
                # finds nothing.
                at = number[address]
                self._watched[at] = True
                self._lookers.setdefault(at, []).append(live_alarm)
        latest = live.latest
        # Begun with the newest values, so that an alarm described now is judged at once.
        self._values = {
            self._addresses[at]: (
                float(latest.value[at]),
                latest.texts.get(at, ""),
                int(latest.arrived_ns[at]),
            )
            for at in self._lookers
            # Channels that were never heard of are unknown, not NaN.
            if latest.arrived_ns[at] != np.iinfo(np.int64).min
        }

    def _judge_alarm(self, live: LiveSite, live_alarm: LiveAlarm, now: int) -> None:
        edge = live_alarm.watch.update_verdict(self._condition_verdict(live, live_alarm, now), now)
        if edge is not None:
            event: Event = Clear(self._now_us(), edge.why)
            if edge.turn is ConditionTurn.RAISE:
                to = first_told(live_alarm.alarm) if live_alarm.alarm is not None else ()
                event = Raise(self._now_us(), edge.why, to)
            self._enqueue(live_alarm, event)
        self._follow_cause(live_alarm, raised=edge is not None)
        # Of what is not known, without its age, which grows by itself.
        unknown = "" if live_alarm.watch.known else live_alarm.watch.why.partition(" is ")[0]
        if unknown != live_alarm.shown_unknown:
            live_alarm.shown_unknown = unknown
            self._publish(live_alarm)

    def _follow_cause(self, live_alarm: LiveAlarm, *, raised: bool) -> None:
        """Let an alarm about several signals grow with what goes on; another cause is told anew."""
        condition = live_alarm.condition
        if condition is None or not condition.shared or condition.happening is None:
            return
        going = tuple(self._seen.get(condition.happening, {}).values())
        thing = condition.newest_thing(going)
        if thing is None or not live_alarm.watch.on:
            return
        before, now_us = live_alarm.cause_us, self._now_us()
        changed = live_alarm.shares != thing.shares
        live_alarm.cause_us, live_alarm.shares = thing.began_us, thing.shares
        if not raised and before and before != thing.began_us:
            to = first_told(live_alarm.alarm) if live_alarm.alarm is not None else ()
            self._enqueue(live_alarm, Raise(now_us, thing.why, to, anew=True))
        elif not raised and live_alarm.cause_why != thing.why:
            self._enqueue(live_alarm, Grow(now_us, thing.why))
        elif changed and not raised:
            self._publish(live_alarm)
        live_alarm.cause_why = thing.why

    def _condition_verdict(
        self, live: LiveSite, live_alarm: LiveAlarm, now: int
    ) -> ConditionVerdict:
        condition = live_alarm.condition
        if condition is None:
            return ConditionVerdict(Truth.UNKNOWN, live_alarm.problem)
        # Of a device out of reach no value counts, however young; the first test spares the split.
        readings = {
            address: ConditionReading(value, text, (now - arrived) / SECOND)
            for address in condition.inputs
            if (found := self._values.get(address)) is not None
            # A loop over one item: it binds names within a comprehension.
            for value, text, arrived in (found,)
            if not live.current.unreached or address.partition("/")[0] not in live.current.unreached
        }
        seen: tuple[DetectedThing, ...] = ()
        if condition.happening is not None:
            seen = tuple(self._seen.get(condition.happening, {}).values())
        return condition.judge_condition(
            readings,
            seen,
            held=live_alarm.watch.on,
            online=live.online,
            enclosures=live.retained.enclosures,
        )

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def _made_live(
    live: LiveSite,
    addresses: Addresses,
    *,
    name: str,
    alarm: Alarm,
    before: LiveAlarm | None,
    state: State,
    made: bool,
) -> LiveAlarm:
    """Make an alarm live; one that is what it was before goes on, with its delays."""
    finding = next(iter(alarm_findings(addresses, "$", alarm)), None)
    about = About(
        live.name,
        name,
        device_of(addresses, alarm),
        alarm.severity,
        alarm.name,
        live.description.name,
        alarm.advice,
    )
    # One that did not fit before (`condition` is None) begins anew.
    same = before is not None and before.alarm == alarm and before.condition is not None
    if before is not None and same and finding is None:
        before.about, before.made = about, made
        # The alarm is the same, but names and units that its condition reads may be others.
        before.condition = AlarmCondition(addresses, alarm)
        return before
    return LiveAlarm(
        about,
        alarm,
        made,
        state,
        # Delays begin anew; whether it is on is as the database has it.
        ConditionWatch(alarm, on=state.on),
        None if finding else AlarmCondition(addresses, alarm),
        # `$` is only the root of the path within the alarm: it says nothing to people.
        str(finding).removeprefix("$.") if finding else "",
        before.undelivered if before else "",
    )
