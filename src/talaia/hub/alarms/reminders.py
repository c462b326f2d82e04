"""When an alarm that stands is told again, and to whom. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.hub.alarms.state_machine import Phase, Remind

if TYPE_CHECKING:
    from talaia.hub.alarms.state_machine import State
    from talaia.model.alarms.alarm import Alarm

__all__ = ["Reminding", "first_told"]

_SECOND_US = 1_000_000


def first_told(alarm: Alarm) -> tuple[str, ...]:
    """Name the accounts that are told as soon as it is raised; none: everybody."""
    if not alarm.escalate:
        return ()
    soonest = alarm.escalate[0].after
    # Stages of the same delay as the first are told with it.
    return tuple(stage.who for stage in alarm.escalate if stage.after <= max(0.0, soonest))


class Reminding:
    """Keeps the time of one alarm's reminders.

    Acknowledging ends the repeats and the escalation, and begins the reminders at their own, longer
    interval. After a restart of the hub the interval begins anew.
    """

    def __init__(self, now_ns: int) -> None:
        """Begin at a moment (monotonic, ns)."""
        # When people were last told (monotonic).
        self._told_ns = now_ns
        # Episode and phase at the last look; None before it. Another one: people were just told.
        self._seen: tuple[int, Phase] | None = None
        # How many of the accounts in `escalate` were told by then.
        self._steps = 0

    def next_due(self, alarm: Alarm, state: State, now_ns: int, now_us: int) -> Remind | None:
        """Give what is due, if anything."""
        stands = (state.episode, state.phase)
        if stands != self._seen:
            # Raised or acknowledged just now; all of the steps that are due then were told.
            # After a restart nothing was seen yet: what is due by now was told before it.
            fresh = self._seen is not None and self._seen[0] != state.episode
            self._seen, self._told_ns = stands, now_ns
            self._steps = (
                len(first_told(alarm)) if fresh else len(self._due_people(alarm, state, now_us))
            )
        if not state.on or state.shelved_until_us > now_us:
            return None
        active = state.phase is Phase.ACTIVE
        due = self._due_people(alarm, state, now_us)
        if active and len(due) > self._steps:
            return self._make_reminder(due, now_ns, now_us)
        every = alarm.repeat if active else alarm.remind
        # Monotonic: a clock that is set neither hastens nor delays a reminder.
        if every is None or now_ns - self._told_ns < round(every * SECOND):
            return None
        return self._make_reminder(due, now_ns, now_us)

    def _make_reminder(self, due: tuple[str, ...], now_ns: int, now_us: int) -> Remind:
        self._told_ns, self._steps = now_ns, len(due)
        return Remind(now_us, due)

    @staticmethod
    def _due_people(alarm: Alarm, state: State, now_us: int) -> tuple[str, ...]:
        """Name who has been told by now, of those that are listed."""
        if not alarm.escalate:
            return ()
        # By the wall clock since it was raised: stages go on over a restart.
        passed = (now_us - state.raised_us) / _SECOND_US
        soonest = alarm.escalate[0].after
        return tuple(stage.who for stage in alarm.escalate if stage.after <= max(passed, soonest))
