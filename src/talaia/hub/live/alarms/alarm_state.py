"""One alarm of a site as the hub has it now, and how pages are told of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from talaia.hub.alarms.condition_watch import ConditionWatch
from talaia.hub.alarms.reminders import Reminding
from talaia.hub.alarms.state_machine import Phase, State, What
from talaia.hub.store.alarms.notification_outbox import About
from talaia.model.alarms.alarm import Alarm, AlarmKind
from talaia.model.checks.alarm_checks import signals_of
from talaia.wire import browser as page

if TYPE_CHECKING:
    from talaia.hub.alarms.conditions import AlarmCondition
    from talaia.hub.alarms.state_machine import Happened
    from talaia.hub.live.sites import LiveSite
    from talaia.model.checks.alarm_checks import Addresses

__all__ = ["LiveAlarm", "alarm_news", "device_of", "event_news", "ghost_alarm"]


# The rest has so little of it that nobody looks for it here.
_MOST_SHARES = 100


# Compared by identity: it is a key of dicts, and a queue may hold two of one name.
@dataclass(slots=True, eq=False)
class LiveAlarm:
    """One alarm, now.

    Attributes:
        alarm: what it is; None once it is described no more.
        made: made in the page, not by the description.
        state: as the database has it.
        condition: None when the description does not fit it, and then ``problem`` says why.
        undelivered: why a message of it did not reach somebody; empty: none failed.

    """

    # Names, device and severity in the words of the description; a new description replaces it.
    about: About
    alarm: Alarm | None
    made: bool
    state: State
    # Its delays and whether it can be judged now; not kept in the database.
    watch: ConditionWatch
    condition: AlarmCondition | None = None
    problem: str = ""
    undelivered: str = ""
    # Of several signals together: which episode it was raised for, and what each has of it.
    cause_us: int = 0
    cause_why: str = ""
    shares: tuple[tuple[str, float, bool], ...] = ()
    # Why it cannot be judged, as pages were last told; empty: they know it as judged.
    shown_unknown: str = ""
    # When people were last told; the first look sets the time, so it may begin with 0.
    reminding: Reminding = field(default_factory=lambda: Reminding(0))


def device_of(addresses: Addresses, alarm: Alarm) -> str:
    """Name the one device that an alarm is about; empty when it is about more: the whole site."""
    devices = {address.partition("/")[0] for address in signals_of(addresses, alarm)}
    # A camera's stream is no signal, so its device is not among those above.
    if alarm.stream:
        devices = {alarm.stream.partition("/")[0]}
    return next(iter(devices)) if len(devices) == 1 else ""


def alarm_news(live_alarm: LiveAlarm) -> page.AlarmUpdate:
    """Say how an alarm stands."""
    about, state, alarm = live_alarm.about, live_alarm.state, live_alarm.alarm
    return page.AlarmUpdate(
        site=about.site,
        alarm=about.alarm,
        device=about.device,
        name=about.name,
        kind=alarm.kind.value if alarm else "",
        severity=about.severity.value,
        phase=state.phase.value,
        why=state.why[:500] if state.phase is not Phase.NORMAL else "",
        known=live_alarm.watch.known,
        unknown_why="" if live_alarm.watch.known else live_alarm.watch.why[:500],
        raised_us=state.raised_us,
        cleared_us=state.cleared_us,
        acked_us=state.acked_us,
        acked_by=state.acked_by,
        assigned=state.assigned,
        shelved_until_us=state.shelved_until_us,
        shelved_by=state.shelved_by,
        shelved_why=state.shelved_why[:500],
        undelivered=live_alarm.undelivered[:500],
        advice=about.advice[:500],
        signals=list(live_alarm.condition.channels) if live_alarm.condition else [],
        shares=[
            page.AlarmShare(signal=address, name=_name_of(live_alarm, address), share=share, on=on)
            for address, share, on in live_alarm.shares[:_MOST_SHARES]
        ],
        made=live_alarm.made,
        gone=alarm is None,
    )


def _name_of(live_alarm: LiveAlarm, address: str) -> str:
    return live_alarm.condition.name_signal(address) if live_alarm.condition else address


def event_news(live_alarm: LiveAlarm, happened: Happened) -> page.EventUpdate:
    """Say what happened to an alarm."""
    about = live_alarm.about
    return page.EventUpdate(
        site=about.site,
        kind=f"alarm {happened.what}",
        device=about.device,
        # Without a message no colon is left at the end.
        message=f"{about.name}: {happened.message}".rstrip(": ")[:500],
        who=happened.who,
        time_us=happened.time_us,
        # What wants somebody's attention is marked; a routine entry is not.
        good=happened.what not in {What.RAISED, What.REMINDED, What.UNSHELVED},
    )


def ghost_alarm(live: LiveSite, name: str, state: State) -> LiveAlarm:
    """Give an alarm of which nothing is known any more but how it stood."""
    # Any kind does: it is never judged, and pages are told that it is gone.
    alarm = Alarm(name=name, kind=AlarmKind.LIMIT)
    about = About(live.name, name, "", alarm.severity, name, live.description.name, "")
    return LiveAlarm(about, None, made=True, state=state, watch=ConditionWatch(alarm, on=state.on))
