"""One interlock over time: unsafe at once, safe again after a dwell time, overridden. Pure."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import MS, SECOND
from talaia.model.interlocks.override_rules import longest_override
from talaia.wire.frames import InterlockState

if TYPE_CHECKING:
    from talaia.model.interlocks.interlock import Interlock

__all__ = ["InterlockChange", "InterlockOverride", "InterlockStateMachine", "InterlockVerdict"]


class InterlockVerdict(NamedTuple):
    """What the conditions say now.

    Attributes:
        why: what is unsafe, as a sentence; empty when nothing is.
        certain: not merely unknown because the gateway has just begun to listen.
        unknown: there is no value that could be judged.
        dwell: all must then be safe for so long (s); none takes the interlock's own time.

    """

    why: str = ""
    certain: bool = True
    unknown: bool = False
    dwell: float | None = None


class InterlockOverride(NamedTuple):
    """Who lets people act in spite of a condition, why, and until when (ns, monotonic)."""

    who: str
    reason: str
    until_ns: int
    condition: str = ""


class InterlockChange(Enum):
    """What a look brought about; several may come at once, in this order."""

    OVERRIDE_ENDED = "override ended"
    LOCKED = "locked"
    FIRED = "fired"
    RELEASED = "released"
    # Nothing to write down, but what pages show is no longer so.
    TOLD = "told"


class InterlockStateMachine:
    """The state of one interlock. It begins locked, until all has been safe for the dwell time."""

    def __init__(self, name: str, rule: Interlock, now_ns: int) -> None:
        """Start as after a restart: nothing is known, so nothing may be done."""
        self._name = name  # Its key, as on the wire.
        # Of the description; another rule makes another machine, see `for_rule`.
        self._rule = rule
        # All must be safe for so long; a condition may ask for more than the interlock's own.
        self._dwell_ns = self._own_dwell_ns = round(rule.dwell * SECOND)
        # It refuses, and since when (monotonic).
        self._locked = True
        self._since_ns = now_ns
        # Something is unsafe now; while it is not, since when all is safe.
        self._unsafe = True
        self._safe_ns = now_ns
        # Its sequence was begun; once until it is released or its override ends.
        self._fired = False
        # A condition has asked for a dwell time since it locked.
        self._stretched = False
        # None while nobody overrides; ends by time, by a person, or when it is released.
        self._override: InterlockOverride | None = None
        # What was unsafe last; stays while the dwell time runs, cleared on release.
        self.why = "the gateway has just started"

    @property
    def locked(self) -> bool:
        """Tell whether it refuses now."""
        # An override does not unlock: what is unsafe is still shown as unsafe.
        return self._locked and self._override is None

    @property
    def is_locked(self) -> bool:
        """Tell whether it would refuse now, were it not overridden."""
        return self._locked

    @property
    def demands(self) -> bool:
        """Tell whether something was unsafe, is not safe for long enough, and nobody overrides."""
        # `_fired` and not `_unsafe`: a roof stays wanted closed through the dwell time.
        return self._fired and self._override is None

    @property
    def override(self) -> InterlockOverride | None:
        """Who has overridden it, if anybody."""
        return self._override

    def for_rule(self, rule: Interlock, now_ns: int) -> InterlockStateMachine:
        """Give the latch of another rule of this name: locked, and no override is left.

        What was unsafe and has not been safe for long enough goes on to demand what it did; while
        it is unsafe, another sequence is run as if it had just become so.
        """
        latch = InterlockStateMachine(self._name, rule, now_ns)
        latch.why = self.why or "its description has changed"
        # A changed sequence has to run for a rain that goes on; an unchanged one is not run twice.
        latch._fired = self._fired and (not self._unsafe or rule.run == self._rule.run)
        return latch

    def update_state(self, verdict: InterlockVerdict, now_ns: int) -> list[InterlockChange]:
        """Take in what the conditions say; give what follows."""
        changes: list[InterlockChange] = []
        if self._override is not None and now_ns >= self._override.until_ns:
            # Before the verdict: what is unsafe when it ends locks, and fires, in the same look.
            self._override = None
            # The sequence that the override held back is due again.
            self._fired = False
            changes.append(InterlockChange.OVERRIDE_ENDED)
        if verdict.why:
            if not self._locked:
                self._locked, self._since_ns = True, now_ns
                changes.append(InterlockChange.LOCKED)
            elif not self._unsafe or verdict.why != self.why:
                changes.append(InterlockChange.TOLD)
            # Each look resets the count of safe time, by way of `_unsafe`.
            self._unsafe, self.why = True, verdict.why
            asked = self._own_dwell_ns
            if verdict.dwell is not None:
                asked = round(verdict.dwell * SECOND)
            # The longest that anything unsafe has asked for since it locked.
            # The first to be unsafe sets the time, even a shorter one than the interlock's; later
            # ones only lengthen it.
            self._dwell_ns = max(self._dwell_ns, asked) if self._stretched else asked
            self._stretched = True
            # Uncertain locks but does not act: a station that is merely starting closes no roof.
            if verdict.certain and not self._fired and self._override is None:
                self._fired = True
                changes.append(InterlockChange.FIRED)
            return changes
        if self._unsafe:
            self._unsafe, self._safe_ns = False, now_ns
            changes.append(InterlockChange.TOLD)
        # Monotonic and inclusive: a dwell time of 0 releases in the same look.
        if self._locked and now_ns - self._safe_ns >= self._dwell_ns:
            self._locked = self._fired = self._stretched = False
            self._dwell_ns = self._own_dwell_ns
            self.why = ""
            changes.append(InterlockChange.RELEASED)
            if self._override is not None:
                # There is nothing left to override; the next time somebody has to say so anew.
                self._override = None
                changes.insert(0, InterlockChange.OVERRIDE_ENDED)
        return changes

    def end_override(self, now_ns: int) -> None:
        """End an override at the next look, whoever gave it."""
        if self._override is not None:
            # Left to `update_state`, so that its end is told in one place.
            self._override = self._override._replace(until_ns=now_ns)

    def due_ns(self) -> int | None:
        """Give when time alone changes it: the dwell time or an override ends; none if it can't."""
        times = []
        if self._locked and not self._unsafe:
            times.append(self._safe_ns + self._dwell_ns)
        if self._override is not None:
            times.append(self._override.until_ns)
        return min(times, default=None)

    def override_condition(
        self, *, who: str, reason: str, seconds: float, now_ns: int, condition: str = ""
    ) -> str:
        """Override a condition for a time, or end that with 0 s; give the reason why not."""
        # Anybody who may override may end it, however long it was for.
        if seconds == 0:
            if self._override is None:
                return f"{self._rule.name} is not overridden"
            self.end_override(now_ns)
            return ""
        longest = longest_override(self._rule)
        if not longest:
            return f"{self._rule.name} may never be overridden"
        if not 0 < seconds <= longest:
            return f"{self._rule.name} may be overridden for at most {longest:g} s"
        if not reason.strip():
            return "say why it is overridden"
        if not self._locked:
            return f"{self._rule.name} locks nothing now, so there is nothing to override"
        until_ns = now_ns + round(seconds * SECOND)
        self._override = InterlockOverride(who, reason.strip(), until_ns, condition)
        return ""

    def current_state(self, now_ns: int) -> InterlockState:
        """Say how it stands."""
        over = self._override
        clears_ns = 0
        if self._locked and not self._unsafe:
            clears_ns = max(0, self._safe_ns + self._dwell_ns - now_ns)
        return InterlockState(
            interlock=self._name,
            locked=self._locked,
            unsafe=self._unsafe,
            why=self.why,
            for_ms=(now_ns - self._since_ns) // MS if self._locked else 0,
            clears_ms=clears_ns // MS,
            overridden_by="" if over is None else over.who,
            reason="" if over is None else over.reason,
            override_ms=0 if over is None else max(0, over.until_ns - now_ns) // MS,
        )
