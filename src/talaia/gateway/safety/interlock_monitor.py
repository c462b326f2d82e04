"""One interlock of a site: its conditions, its state, and who overrides it. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import msgspec

from talaia.gateway.safety.condition_holds import ConditionHolds
from talaia.gateway.safety.debounced_condition import DebouncedCondition
from talaia.gateway.safety.interlock_state import (
    InterlockChange,
    InterlockStateMachine,
    InterlockVerdict,
)
from talaia.model.interlocks.override_rules import condition_id

if TYPE_CHECKING:
    from talaia.gateway.ports import ControlOutput
    from talaia.gateway.safety.condition_judge import ConditionJudge
    from talaia.model.interlocks.interlock import Interlock, Step
    from talaia.model.site import Site
    from talaia.wire.frames import InterlockState, OverrideRequest

__all__ = ["InterlockMonitor", "SequenceStarter"]


class SequenceStarter(Protocol):
    """Begins sequences of commands."""

    def __call__(self, label: str, steps: tuple[Step, ...]) -> None:
        """Begin one; one of the same label that still runs goes on instead."""
        ...


class InterlockMonitor:
    """Judges one interlock again and again, and tells and does what follows.

    Attributes:
        rule: its description.

    """

    def __init__(
        self,
        *,
        name: str,
        site: Site,
        judge: ConditionJudge,
        output: ControlOutput,
        run: SequenceStarter,
        now_ns: int,
        why: str = "the gateway has just started",
    ) -> None:
        """Start locked.

        Args:
            name: its key in the description.
            site: the description.
            judge: says what its conditions say now.
            output: tells the hub, and writes down.
            run: begins its sequence.
            now_ns: monotonic.
            why: what it says until it has been judged.

        """
        self.rule: Interlock = site.interlocks[name]
        self._name = name  # Its key, as in records and on the wire.
        self._judge = judge  # Shared by all interlocks of the site.
        self._output = output  # Tells the hub and writes the record.
        self._run = run  # Begins the interlock's own sequence.
        # Locked or not, and since when: of the interlock as a whole.
        self._state = InterlockStateMachine(name, self.rule, now_ns)
        self._state.why = why
        # Limits with hysteresis and a time to last, each with its own memory.
        self._conditions = [DebouncedCondition(condition) for condition in self.rule.when]
        # Which of the conditions holds it locked: only one at a time may be overridden.
        self._holds = ConditionHolds(site, self.rule, now_ns)
        # What was last told of its conditions: the one that locks, why it may not be overridden,
        # and those that are unknown.
        self._told: tuple[str, str, list[str]] | None = None

    @property
    def locked(self) -> bool:
        """Tell whether it refuses now."""
        return self._state.locked

    @property
    def why(self) -> str:
        """Say what is unsafe; while it is safe again, what was."""
        return self._state.why

    @property
    def closing_reason(self) -> str:
        """Say why it wants roofs closed, if it does; empty otherwise."""
        if not self._state.demands:
            return ""
        return f"{self.rule.name}: {self.why}" if self.why else self.rule.name

    def for_description(self, site: Site, now_ns: int) -> InterlockMonitor:
        """Give the one of another description of it, and end an override.

        What was unsafe stays so, see `InterlockStateMachine.for_rule`.
        """
        if (over := self._state.override) is not None:
            self._record_event("override_ended", self._name, who=over.who, good=True)
        monitor = InterlockMonitor(
            name=self._name,
            site=site,
            judge=self._judge,
            output=self._output,
            run=self._run,
            now_ns=now_ns,
        )
        # Only the state is carried over; hysteresis and dwell times of its conditions begin anew.
        monitor._state = self._state.for_rule(monitor.rule, now_ns)
        return monitor

    def evaluate_conditions(self, now_ns: int) -> None:
        """Judge it now; tell what has changed, and begin its sequence when it fires."""
        # Read before `update_state`, which forgets who it was.
        before, ended = self._state.override, ""
        verdict = self._judge_conditions(now_ns)
        if before is not None and (ended := self._holds.override_end(before.condition, now_ns)):
            # Ends within this very look, for the override's time is now.
            self._state.end_override(now_ns)
        for change in self._state.update_state(verdict, now_ns):
            match change:
                case InterlockChange.LOCKED:
                    self._record_event("interlock_locked", f"{self._name}: {self.why}", good=False)
                case InterlockChange.RELEASED:
                    self._record_event("interlock_released", self._name, good=True)
                case InterlockChange.OVERRIDE_ENDED:
                    who = "" if before is None else before.who
                    said = f"{self._name}: {ended}" if ended else self._name
                    self._record_event("override_ended", said, who=who, good=True)
                case InterlockChange.FIRED:
                    if self.rule.run:
                        acts = f"{self._name}: {self.why}"
                        self._record_event("interlock_acts", acts, good=False)
                        self._run(f"interlock {self._name}", self.rule.run)
                    # A sequence changes nothing that a page shows of the interlock.
                    continue
                case InterlockChange.TOLD:
                    pass
            self._output.send(self.interlock_state(now_ns))

    def handle_override(self, ask: OverrideRequest, now_ns: int) -> None:
        """Override a condition for a time, or end that; who asked is told by the state."""
        # Judged first: what a person sees may be 100 ms old, and an override must fit what is true
        # now.
        self.evaluate_conditions(now_ns)
        condition = ask.condition or self._holds.locking_condition(now_ns)
        refused = ""
        if ask.seconds and self._state.is_locked:
            refused = self._holds.override_problem(condition, now_ns)
        if not refused:
            refused = self._state.override_condition(
                who=ask.who,
                reason=ask.reason,
                seconds=ask.seconds,
                now_ns=now_ns,
                condition=condition,
            )
        if refused:
            self._record_event("override_refused", refused, who=ask.who, good=False)
            return
        if ask.seconds:
            said = f"{ask.interlock} ({condition}) for {ask.seconds:g} s: {ask.reason.strip()}"
            self._record_event("interlock_overridden", said, who=ask.who, good=False)
            self._output.send(self.interlock_state(now_ns))
        # Once more, so that an end with 0 s takes effect and is recorded now.
        self.evaluate_conditions(now_ns)

    def interlock_state(self, now_ns: int) -> InterlockState:
        """Say how it stands, and which condition could be overridden."""
        state = self._state.current_state(now_ns)
        condition = no_override = ""
        if self._state.override is not None:
            condition = self._state.override.condition
        elif state.locked:
            condition = self._holds.locking_condition(now_ns)
            no_override = self._holds.override_problem(condition, now_ns)
        unknown = self._holds.unknown
        self._told = condition, no_override, unknown
        return msgspec.structs.replace(
            state, condition=condition, no_override=no_override, unknown=unknown
        )

    def send_if_conditions_changed(self, now_ns: int) -> None:
        """Tell when another condition locks or is unknown, or may now be overridden, or not."""
        before = self._told
        state = self.interlock_state(now_ns)
        if before is not None and self._told != before:
            self._output.send(state)

    def _judge_conditions(self, now_ns: int) -> InterlockVerdict:
        """Give the first thing that is certainly unsafe, or else the first that is unknown.

        It asks for the longest dwell time of all that are unsafe.
        """
        judged = [
            (
                condition_id(condition.condition),
                condition.judge_condition(
                    lambda one: self._judge.judge_condition(one, now_ns), now_ns
                ),
            )
            for condition in self._conditions
        ]
        self._holds.update_verdicts(judged, now_ns)
        # All are judged, also after the first that is unsafe: each has a memory of its own to keep.
        verdicts = [verdict for _, verdict in judged if verdict.why]
        if not verdicts:
            return InterlockVerdict()
        own = self.rule.dwell
        longest = max(own if verdict.dwell is None else verdict.dwell for verdict in verdicts)
        # Certain before unknown: a person should read of the rain, not of the sensor that starts
        # up.
        first = next((verdict for verdict in verdicts if verdict.certain), verdicts[0])
        return first._replace(dwell=longest)

    def _record_event(self, kind: str, message: str, *, good: bool, who: str = "") -> None:
        self._output.record_event(kind, "", message, who, good=good)
