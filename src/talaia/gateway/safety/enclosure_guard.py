"""Keeps a roof closed for as long as it must be: asks again until its sensors say so. Pure.

Level-triggered: what counts at each look is how things stand, not what was asked before. A roof
that somebody opens again is asked to close again; a park that is refused ends nothing; success is
what the end switches say, never the answer to a command.

Long, because stopping, parking and closing one roof lean on the same few times and tries.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.clock import SECOND
from talaia.model.interlocks.enclosure import ClosingOrder, PastDeadline
from talaia.model.interlocks.interlock import Step

if TYPE_CHECKING:
    from talaia.model.interlocks.enclosure import Enclosure

__all__ = [
    "EnclosureAction",
    "EnclosureEvent",
    "EnclosureGuard",
    "EnclosureReadings",
]

# A command is asked again no sooner, however the sensors stand: first this, then ever longer.
# A motor that is told "close" every second may begin anew each time; 30 s at the most keep the roof
# asked.
FIRST_AGAIN_NS = 2 * SECOND
LONGEST_AGAIN_NS = 30 * SECOND
# Parking takes longer than a close to be accepted, and a park asked twice aborts the first at some
# mounts.
PARK_AGAIN_NS = 10 * SECOND
# Before anything moves the exposure is asked to end; a camera that does not answer delays nothing
# for longer than this.
ABORT_NS = SECOND


class EnclosureReadings(NamedTuple):
    """What the sensors say.

    Attributes:
        closed: none when they say nothing.
        moving: the roof moves.
        parked: the telescope is certainly parked.
        opening: the roof certainly moves towards open.
        disagree: what the sensors say where they disagree; ``closed`` is none then.
        open_parts: segments and flap that are not certainly closed, by name.

    """

    closed: bool | None
    moving: bool
    parked: bool
    opening: bool = False
    disagree: str = ""
    open_parts: tuple[str, ...] = ()


class EnclosureAction(NamedTuple):
    """A command to be given; ``label`` is its own, so that none waits for another."""

    label: str
    step: Step


class EnclosureEvent(NamedTuple):
    """Something to write down."""

    kind: str
    message: str
    good: bool


class EnclosureGuard:
    """One enclosure over time."""

    def __init__(self, name: str, rule: Enclosure) -> None:
        """Want nothing yet."""
        self._name = name  # For people and labels; the key in the description.
        self._rule = rule  # Sensors, commands and times; a changed rule makes a new guard.
        # How many commands were asked: part of each label, so that none waits for another.
        self._asked = 0
        # What the last alarm said.
        self._problem = ""
        self._reset_state()

    def _reset_state(self) -> None:
        # Since when it has to be closed (monotonic, as all times here); none while it may be open.
        self._began_ns: int | None = None
        # Its sensors have said so since then. Only they decide, never the answer to a command.
        self._closed = False
        # How often it was asked to close, and when last.
        self._tries = 0
        self._close_ns: int | None = None
        # When the telescope was last asked to park.
        self._park_ns: int | None = None
        # When people were last alarmed; none while there is no alarm.
        self._alarm_ns: int | None = None
        # Who has stopped the closing by hand: it is theirs to resume.
        self._stopped_by = ""
        # The exposure was asked to end, once.
        self._aborted = False
        # How often a roof that opens was stopped or turned, in a row, and when last.
        self._turns = 0
        self._turn_ns: int | None = None

    @property
    def problem(self) -> str:
        """Say why it should be closed and cannot be shown to be; empty: it is, or need not be."""
        return f"{self._rule.name}: {self._problem}" if self.alarmed else ""

    @property
    def alarmed(self) -> bool:
        """Tell whether it should be closed and cannot be shown to be."""
        return self._alarm_ns is not None

    def handle_command(self, address: str, who: str) -> list[EnclosureAction | EnclosureEvent]:
        """Take in a person's command: STOP holds a closing, the closing command resumes it."""
        if self._began_ns is None or self._closed:
            return []
        if address == self._rule.stop and not self._stopped_by:
            self._stopped_by = who or "somebody"
            # Who stopped it stands beside it; the alarm is for a roof that nobody attends to.
            self._alarm_ns = None
        elif address == self._rule.close.command and self._stopped_by:
            # Resumed as if it had just begun: at once, and with short waits again.
            self._stopped_by, self._tries, self._close_ns = "", 0, None
            return [self._make_event("enclosure_resumed", f"closing resumed by {who}", good=True)]
        return []

    def update_enclosure(
        self, why: str, seen: EnclosureReadings, now_ns: int
    ) -> list[EnclosureAction | EnclosureEvent]:
        """Say what is to be done now.

        Args:
            why: what is not safe; empty when it may be open.
            seen: what the sensors say.
            now_ns: monotonic.

        """
        if not why:
            if self._began_ns is None:
                return []
            over = self.alarmed
            self._reset_state()
            return [self._make_event("alarm_over", "safe again", good=True)] if over else []
        acts: list[EnclosureAction | EnclosureEvent] = []
        if self._began_ns is None:
            self._began_ns = now_ns
            acts.append(self._make_event("enclosure_closes", why, good=False))
        # Once for a closing: an exposure that a person begins afterwards is refused by interlocks.
        if seen.closed is not True and not self._aborted:
            # With the roof closed there is nothing to protect: darks may go on.
            self._aborted = True
            acts += [self._make_action("abort", step) for step in self._rule.abort]
        if seen.closed is True:
            acts += self._on_closed(now_ns)
        elif self._closed:
            # Somebody opened it, or a switch let go: begin anew, with the first short waits.
            self._closed, self._tries, self._close_ns = False, 0, None
            self._began_ns = now_ns
            acts.append(self._make_event("enclosure_reopened", f"open while {why}", good=False))
        # Who stopped the closing by hand may open it as well.
        if not self._closed and not self._stopped_by:
            acts += self._turn_back(seen, now_ns)
        acts += self._park_roof(seen, now_ns)
        if not self._closed:
            acts += self._close_roof(why, seen, now_ns)
        return acts

    def _turn_back(
        self, seen: EnclosureReadings, now_ns: int
    ) -> list[EnclosureAction | EnclosureEvent]:
        """Stop or turn a roof that opens, at once, whatever the order of closing is.

        With a telescope that may stand in the way it is stopped first, and closes in its order.
        One that does not stop is turned: what the shutter has just passed it may pass again.
        """
        rule = self._rule
        if not seen.opening:
            self._turns, self._turn_ns = 0, None
            return []
        again = min(LONGEST_AGAIN_NS, FIRST_AGAIN_NS << max(0, min(self._turns - 1, 10)))
        if self._turn_ns is not None and now_ns - self._turn_ns < again:
            return []
        stops = bool(rule.stop) and (self._turns + self._must_wait(seen)) % 2 == 1
        acts: list[EnclosureAction | EnclosureEvent] = []
        if self._turns == 0:
            did = "stopped" if stops else "turned"
            acts.append(self._make_event("enclosure_turned", f"it was opening: {did}", good=False))
        self._turns += 1
        self._turn_ns = now_ns
        if stops:
            return [*acts, self._make_action("stop", Step(command=rule.stop))]
        self._tries += 1
        self._close_ns = now_ns
        return [*acts, self._make_action("close", rule.close)]

    def _must_wait(self, seen: EnclosureReadings) -> bool:
        """Tell whether the telescope has to be parked before the roof closes."""
        waits = self._rule.order is ClosingOrder.MOUNT_FIRST and self._rule.park is not None
        return waits and not seen.parked

    def _on_closed(self, now_ns: int) -> list[EnclosureAction | EnclosureEvent]:
        if self._closed:
            return []
        took = (now_ns - (self._began_ns or now_ns)) / SECOND
        said = [self._make_event("enclosure_closed", f"closed after {took:.0f} s", good=True)]
        if self.alarmed:
            said.append(self._make_event("alarm_over", "closed", good=True))
        self._closed, self._tries, self._stopped_by = True, 0, ""
        self._close_ns = self._alarm_ns = None
        return [*said]

    def _park_roof(
        self, seen: EnclosureReadings, now_ns: int
    ) -> list[EnclosureAction | EnclosureEvent]:
        rule = self._rule
        if rule.park is None or seen.parked or self._stopped_by:
            return []
        began = self._began_ns or now_ns
        if self._aborted and rule.abort and now_ns - began < ABORT_NS:
            return []
        closing = rule.order is ClosingOrder.CLOSE_FIRST and not self._closed
        if closing and now_ns - began < round(rule.move_within * SECOND):
            return []
        again = PARK_AGAIN_NS if self._in_time(now_ns) else LONGEST_AGAIN_NS
        if self._park_ns is not None and now_ns - self._park_ns < again:
            return []
        self._park_ns = now_ns
        return [self._make_action("park", rule.park)]

    def _in_time(self, now_ns: int) -> bool:
        """Tell whether the roof may still wait for the telescope."""
        began = self._began_ns or now_ns
        return now_ns - began < round(self._rule.mount_within * SECOND)

    def _close_roof(
        self, why: str, seen: EnclosureReadings, now_ns: int
    ) -> list[EnclosureAction | EnclosureEvent]:
        rule = self._rule
        if self._stopped_by:
            said = f"closing was stopped by {self._stopped_by}; close it by hand to resume ({why})"
            return self._raise_alarm(said, now_ns)
        if self._must_wait(seen) and self._close_ns is None:
            if self._in_time(now_ns):
                return []
            if rule.past_deadline is PastDeadline.ALARM:
                return self._raise_alarm(
                    f"the telescope is not parked, so it stays open ({why})", now_ns
                )
        acts: list[EnclosureAction | EnclosureEvent] = []
        # A roof that opens is seen to by `_turn_back`, more often.
        if not seen.opening and self._is_due(seen, now_ns):
            self._tries += 1
            self._close_ns = now_ns
            if self._tries > 1:
                times = f"asked for the {self._tries}. time"
                acts.append(
                    self._make_event(
                        "enclosure_retry", f"{times}: {_describe_readings(seen)}", good=False
                    )
                )
            parts = [part for name, part in rule.parts().items() if name in seen.open_parts]
            acts += [
                self._make_action("close", part.close) for part in parts if part.close is not None
            ]
            acts.append(self._make_action("close", rule.close))
        if self._tries > rule.retries:
            tries = "1 try" if rule.retries == 1 else f"{rule.retries} tries"
            acts += self._raise_alarm(
                f"NOT CLOSED after {tries}: {_describe_readings(seen)} ({why})", now_ns
            )
        return acts

    def _is_due(self, seen: EnclosureReadings, now_ns: int) -> bool:
        """Tell whether it is time to ask it to close."""
        if self._close_ns is None:
            return True
        waited = now_ns - self._close_ns
        if seen.moving:
            return waited >= round(self._rule.move_within * SECOND)
        again = min(LONGEST_AGAIN_NS, FIRST_AGAIN_NS << min(self._tries - 1, 10))
        return waited >= again

    def _raise_alarm(self, message: str, now_ns: int) -> list[EnclosureAction | EnclosureEvent]:
        self._problem = message
        every = round(self._rule.alarm_every * SECOND)
        if self._alarm_ns is not None and now_ns - self._alarm_ns < every:
            return []
        self._alarm_ns = now_ns
        return [self._make_event("enclosure_not_closed", message, good=False)]

    def _make_action(self, what: str, step: Step) -> EnclosureAction:
        self._asked += 1
        return EnclosureAction(
            f"enclosure {self._name} {what} {self._asked}",
            msgspec.structs.replace(step, required=False),
        )

    def _make_event(self, kind: str, message: str, *, good: bool) -> EnclosureEvent:
        return EnclosureEvent(kind, f"{self._rule.name}: {message}", good)


def _describe_readings(seen: EnclosureReadings) -> str:
    if seen.disagree:
        return f"its sensors disagree ({seen.disagree})"
    if seen.closed is None:
        return "its sensors say nothing"
    if seen.opening:
        return "it still opens"
    return "it still moves" if seen.moving else "its sensors say that it is open"
