"""All interlocks and link-loss policies of a site, from the gateway's own copy of it. Pure.

Conditions are judged anew at each command and each driving frame, and ten times a second. A hub
is not needed for any of it.

Long, because all that may lock, close or stop is judged in one place and in one order.
"""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Protocol

import msgspec

from talaia.clock import MS, SECOND
from talaia.gateway.freeze_watchdog import FreezeCredit
from talaia.gateway.safety.condition_holds import ConditionHolds
from talaia.gateway.safety.debounced_condition import DebouncedCondition
from talaia.gateway.safety.derived_conditions import judge_dew_point, judge_difference, judge_sun
from talaia.gateway.safety.enclosure_guard import (
    EnclosureAction,
    EnclosureEvent,
    EnclosureGuard,
    EnclosureReadings,
    Follower,
    Hold,
    apart_of,
    hold_of,
)
from talaia.gateway.safety.interlock_state import (
    InterlockChange,
    InterlockStateMachine,
    InterlockVerdict,
)
from talaia.gateway.safety.link_losses import LinkLosses
from talaia.gateway.safety.outlet_guard import refuse_power_cut
from talaia.gateway.safety.pointing_limits import misdirected
from talaia.gateway.safety.sensor_agreement import (
    ClosedVerdict,
    RoofSensor,
    SensorAgreement,
    SensorTurns,
    closed_by,
)
from talaia.gateway.safety.value_validity import ValueValidity, within_sighting, word_of
from talaia.model.derived_signals import detection_setup_of
from talaia.model.interlocks.interlock import Condition
from talaia.model.interlocks.opening import opening_of
from talaia.model.interlocks.override_rules import condition_id
from talaia.model.site import SignalType
from talaia.wire.frames import EnclosureState

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from talaia.gateway.ports import ChannelReading, ControlOutput, Field, ReadingSource
    from talaia.model.interlocks.enclosure import Enclosure, Sighting
    from talaia.model.interlocks.interlock import Interlock, Step
    from talaia.model.site import Signal, Site
    from talaia.wire.frames import InterlockState, OverrideRequest

__all__ = ["Interlocks", "Runner", "judged", "together"]

LOOK_NS = 100 * MS
# Characters: what the wire takes of a reason.
LONGEST_WHY = 500


class Runner(Protocol):
    """Begins sequences of commands."""

    def __call__(self, label: str, steps: tuple[Step, ...]) -> None:
        """Begin one; one of the same label that still runs goes on instead."""
        ...


def judged(
    *,
    condition: Condition,
    signal: Signal,
    reading: ChannelReading | None,
    age_ns: int,
    problem: str = "",
) -> InterlockVerdict:
    """Say what is unsafe about a signal.

    Args:
        condition: what is unsafe.
        signal: its description.
        reading: its newest, if there ever was one.
        age_ns: of the reading; where there is none, how long it has been listened for.
        problem: what makes it unknown however fresh it is, see `ValueValidity`.

    """
    max_age = signal.max_age if condition.max_age is None else condition.max_age
    fresh = age_ns <= round(max_age * SECOND)
    if reading is None:
        return InterlockVerdict(f"{signal.name}: no value yet", certain=not fresh, unknown=True)
    if problem:
        return InterlockVerdict(problem, unknown=True)
    if not fresh:
        return InterlockVerdict(f"{signal.name}: no value newer than {max_age:g} s", unknown=True)
    value = reading.value
    if not math.isfinite(value):
        return InterlockVerdict(f"{signal.name}: not a number", unknown=True)
    if signal.type is SignalType.STATE:
        return InterlockVerdict(_state_problem(condition, signal, value))
    unit = f" {signal.unit}" if signal.unit else ""
    if condition.above is not None and value > condition.above:
        return InterlockVerdict(f"{signal.name} is above {condition.above:g}{unit}")
    if condition.below is not None and value < condition.below:
        return InterlockVerdict(f"{signal.name} is below {condition.below:g}{unit}")
    return InterlockVerdict()


def together(parts: Sequence[InterlockVerdict]) -> InterlockVerdict:
    """Say what is unsafe about conditions that are unsafe only all at once.

    One that is unknown counts as unsafe, as everywhere; it makes the whole uncertain for as long
    as it is itself.
    """
    if not parts or not all(part.why for part in parts):
        return InterlockVerdict()
    why = " and ".join(part.why for part in parts)
    return InterlockVerdict(why[:LONGEST_WHY], all(part.certain for part in parts))


def _state_problem(condition: Condition, signal: Signal, value: float) -> str:
    if value != int(value) or not 0 <= value < len(signal.states):
        return f"{signal.name}: an unknown state"
    word = signal.states[int(value)]
    if word in condition.is_one_of or (condition.is_not and word not in condition.is_not):
        return f"{signal.name} is {word}"
    return ""


class Interlocks:
    """What may not be done now, and why; and what is done by itself."""

    def __init__(
        self,
        *,
        site: Site,
        readings: ReadingSource,
        output: ControlOutput,
        run: Runner,
        now_ns: int,
        wall_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        """Start locked and without a link.

        Args:
            site: the description.
            readings: the newest values, see `Site.guarded`.
            output: tells the hub, and writes down.
            run: begins sequences.
            now_ns: monotonic.
            wall_ns: UTC, for where the Sun stands.

        """
        self._site = site
        self._wall_ns = wall_ns
        self._readings = readings
        self._validity = ValueValidity(readings, wall_ns)
        self._output = output
        self._run = run
        # From when on a signal that has never said anything has been listened to.
        self._began_ns = dict.fromkeys(site.guarded(), now_ns)
        self._losses = LinkLosses(site, now_ns)
        self._credit = FreezeCredit(now_ns)
        self._looked_ns = now_ns - LOOK_NS
        self._wires = {
            name: [DebouncedCondition(each) for each in rule.when]
            for name, rule in site.interlocks.items()
        }
        self._enclosures = {
            name: EnclosureGuard(name, rule) for name, rule in site.enclosures.items()
        }
        self._agreements = {name: SensorAgreement(rule) for name, rule in site.enclosures.items()}
        self._turns = SensorTurns()
        # What was last told of each enclosure, see `EnclosureState`.
        self._told_problems: dict[str, str] = {}
        self._followers = {
            name: Follower(rule.follow)
            for name, rule in site.enclosures.items()
            if rule.follow is not None
        }
        self._latches = {
            name: InterlockStateMachine(name, rule, now_ns)
            for name, rule in site.interlocks.items()
        }
        self._holds = {
            name: ConditionHolds(site, rule, now_ns) for name, rule in site.interlocks.items()
        }
        # What was last told of overriding: the condition that locks, and why not.
        self._told: dict[str, tuple[str, str]] = {}
        self._ended_ns: dict[str, int] = {}
        self._judged_ns = now_ns

    def redescribe(self, site: Site, now_ns: int) -> None:
        """Judge by another description from here on.

        What is described as it was, with the signals it looks at, goes on with its dwell time and
        its override. All else begins locked, as after a restart.
        """
        before, self._site = self._site, site
        had = before.guarded()
        fresh = {
            each
            for each in site.guarded()
            if each not in had or _heard(before, each) != _heard(site, each)
        }
        self._began_ns = {
            each: now_ns if each in fresh else self._began_ns.get(each, now_ns)
            for each in site.guarded()
        }
        latches, wires, holds = self._latches, self._wires, self._holds
        self._latches, self._wires, self._holds = {}, {}, {}
        for name, rule in site.interlocks.items():
            old = before.interlocks.get(name)
            watched = {address for each in rule.when for address in each.signals()}
            sun = any(part.sun for each in rule.when for part in (each, *each.all_of))
            moved = sun and before.place != site.place
            changed = any(_meant(before, each) != _meant(site, each) for each in watched)
            if old == rule and not changed and not moved:
                self._latches[name], self._wires[name] = latches[name], wires[name]
                self._holds[name] = holds[name]
                continue
            known = latches.get(name)
            if known is not None and (over := known.override) is not None:
                self._output.record_event("override_ended", "", name, over.who, good=True)
            latch = InterlockStateMachine(name, rule, now_ns)
            latch.why = "it has just been described"
            self._latches[name] = latch if known is None else known.redescribed(rule, now_ns)
            self._wires[name] = [DebouncedCondition(each) for each in rule.when]
            self._holds[name] = ConditionHolds(site, rule, now_ns)
            self._output.send(self._state(name, now_ns))
        self._redescribe_enclosures(before, site)
        self._losses.redescribe(site)

    def _redescribe_enclosures(self, before: Site, site: Site) -> None:
        guards, followers, agreements = self._enclosures, self._followers, self._agreements
        self._enclosures, self._followers, self._agreements = {}, {}, {}
        for name, rule in site.enclosures.items():
            same = before.enclosures.get(name) == rule
            self._enclosures[name] = guards[name] if same else EnclosureGuard(name, rule)
            self._agreements[name] = agreements[name] if same else SensorAgreement(rule)
            if rule.follow is not None:
                self._followers[name] = followers[name] if same else Follower(rule.follow)

    def refusal(
        self, device: str, what: str, now_ns: int, args: Mapping[str, Field] | None = None
    ) -> str:
        """Say why a command of a device (or ``drive``) may not be done now; empty when it may.

        ``args`` are the command's, by name: where a telescope is pointed is looked at as well.
        """
        for name, rule in self._site.interlocks.items():
            if f"{device}/{what}" in rule.refuse or f"{device}/*" in rule.refuse:
                self._judge_interlock(name, now_ns)
                latch = self._latches[name]
                if latch.locked:
                    return f"{rule.name}: {latch.why}"
                if unheard := self._unheard(rule, now_ns):
                    return f"{rule.name}: {unheard}"
        return self._misdirected(device, what, args or {})

    def refuse_power_cut(
        self, device: str, command: str, now_ns: int, args: Mapping[str, Field]
    ) -> str:
        """Say why a command takes power that a safe state needs; empty when it takes none."""
        return refuse_power_cut(
            site=self._site,
            device=device,
            command=command,
            args=args,
            sighted=lambda each: self._sighted(each, now_ns),
        )

    def share(self, device: str, now_ns: int) -> float:
        """Say at which share of its limits a device may be driven now, 0 to 1."""
        target, share = f"{device}/drive", 1.0
        for name, rule in self._site.interlocks.items():
            if target in rule.slow:
                self._judge_interlock(name, now_ns)
                if self._latches[name].locked:
                    share = min(share, rule.slow[target])
        return share

    def _misdirected(self, device: str, what: str, args: Mapping[str, Field]) -> str:
        described = self._site.devices.get(device)
        if described is None or described.pointing is None or self._site.place is None:
            return ""
        pointed = described.pointing.commands.get(what)
        if pointed is None:
            return ""
        return misdirected(
            rule=described.pointing,
            names=pointed,
            args=args,
            place=self._site.place,
            wall_ns=self._wall_ns(),
        )

    def hold(self, device: str, command: str, now_ns: int) -> Hold | None:
        """Say what a command has to wait for, because a dome follows; none when for nothing."""
        for rule in self._site.enclosures.values():
            follow = rule.follow
            if follow is None or f"{device}/{command}" not in follow.before:
                continue
            still = not any(self._sighted(each, now_ns) for each in rule.moving)
            tracks = self._sighted(follow.when, now_ns)
            apart = apart_of(
                self._fresh(follow.target, now_ns), self._fresh(follow.azimuth, now_ns)
            )
            if any(self._before_its_end(each) for each in (follow.when.signal, follow.azimuth)):
                # What is known is older than the last motion's end.
                apart = tracks = None
            held = hold_of(
                follow,
                is_open=follow.open is None or self._sighted(follow.open, now_ns),
                closed=still and self._closed(rule, now_ns).closed is True,
                moving=follow.moving is not None and self._sighted(follow.moving, now_ns),
                apart=0.0 if tracks is False else apart,
            )
            if held is not None:
                return held._replace(why=f"{rule.name}: {held.why}")
        return None

    def ended(self, device: str, now_ns: int) -> None:
        """Tell of a command that has ended: what its device said before counts for no `hold`."""
        self._ended_ns[device] = now_ns

    def _before_its_end(self, address: str) -> bool:
        reading = self._readings.latest(address)
        ended_ns = self._ended_ns.get(address.partition("/")[0], 0)
        return reading is None or reading.mono_ns < ended_ns

    def commanded(self, device: str, command: str, who: str) -> None:
        """Tell of a person's command that was accepted: it may stop or resume a closing."""
        for guard in self._enclosures.values():
            self._carry_out(guard.commanded(f"{device}/{command}", who))

    def override(self, ask: OverrideRequest, now_ns: int) -> None:
        """Override a condition for a time, or end that; who asked is told by the state."""
        condition, refused = self._overrule(ask, now_ns)
        if refused:
            self._output.record_event("override_refused", "", refused, ask.who, good=False)
            return
        if ask.seconds:
            said = f"{ask.interlock} ({condition}) for {ask.seconds:g} s: {ask.reason.strip()}"
            self._output.record_event("interlock_overridden", "", said, ask.who, good=False)
            self._output.send(self._state(ask.interlock, now_ns))
        self._judge_interlock(ask.interlock, now_ns)

    def _overrule(self, ask: OverrideRequest, now_ns: int) -> tuple[str, str]:
        """Override as asked; give the condition that is, and why it was refused, if it was."""
        latch = self._latches.get(ask.interlock)
        if latch is None:
            return "", f"there is no interlock {ask.interlock!r}"
        self._judge_interlock(ask.interlock, now_ns)
        holds = self._holds[ask.interlock]
        condition = ask.condition or holds.locking(now_ns)
        if ask.seconds and latch.is_locked and (why := holds.problem(condition, now_ns)):
            return condition, why
        refused = latch.overrule(
            who=ask.who, reason=ask.reason, seconds=ask.seconds, now_ns=now_ns, condition=condition
        )
        return condition, refused

    def _state(self, name: str, now_ns: int) -> InterlockState:
        """Say how an interlock stands, and which condition could be overridden."""
        latch, holds = self._latches[name], self._holds[name]
        state = latch.state(now_ns)
        condition = no_override = ""
        if latch.override is not None:
            condition = latch.override.condition
        elif state.locked:
            condition = holds.locking(now_ns)
            no_override = holds.problem(condition, now_ns)
        self._told[name] = condition, no_override
        return msgspec.structs.replace(state, condition=condition, no_override=no_override)

    def _tell_overridable(self, name: str, now_ns: int) -> None:
        """Tell when another condition locks, or it may be overridden now and could not before."""
        before = self._told.get(name)
        state = self._state(name, now_ns)
        if before is not None and self._told[name] != before:
            self._output.send(state)

    def link_up(self, now_ns: int) -> None:
        """Tell a new link how all stand; what was to follow its loss is called off."""
        self._losses.link_up()
        for name in self._latches:
            self._output.send(self._state(name, now_ns))
        for name in self._enclosures:
            self._tell_enclosure(name)

    def link_lost(self, now_ns: int) -> None:
        """Count from now."""
        self._credit.at(now_ns)
        self._losses.link_lost(now_ns)

    @property
    def judged_ns(self) -> int | None:
        """When all was last judged to the end (monotonic); none where there is nothing to judge."""
        return self._judged_ns if self._latches or self._enclosures else None

    def enclosure_seen(self, name: str, now_ns: int) -> EnclosureReadings:
        """Give what the sensors of an enclosure say."""
        rule = self._site.enclosures[name]
        return self._seen(rule, self._closed(rule, now_ns), now_ns)

    def _seen(self, rule: Enclosure, closed: ClosedVerdict, now_ns: int) -> EnclosureReadings:
        opening = any(self._sighted(each, now_ns) for each in opening_of(self._site, rule))
        return EnclosureReadings(
            closed=None if closed.closed is None else closed.closed and not opening,
            disagree=closed.disagree,
            open_parts=closed.open_parts,
            opening=opening,
            # Not every sensor has spoken since the end of the motion: none is asked to begin anew.
            moving=closed.settling or any(self._sighted(each, now_ns) for each in rule.moving),
            parked=rule.parked is not None and self._sighted(rule.parked, now_ns) is True,
        )

    def blind(self, name: str, now_ns: int) -> str:
        """Say why an enclosure cannot be supervised now: its sensors, or all of the weather's."""
        rule = self._site.enclosures[name]
        if self.enclosure_seen(name, now_ns).closed is None:
            return "its sensors say nothing"
        conditions = [
            part
            for interlock in rule.unsafe
            for each in self._site.interlocks[interlock].when
            for part in (each, *each.all_of)
            if part.signal
        ]
        if conditions and all(self._judge(each, now_ns).unknown for each in conditions):
            return "nothing is known of what makes it unsafe"
        return ""

    def due_ns(self) -> int | None:
        """Give when `step` wants to be called next, or none where there is nothing to watch."""
        if not self._latches and not self._enclosures and self._losses.idle:
            return None
        return self._looked_ns + LOOK_NS

    def step(self, now_ns: int) -> None:
        """Look at everything."""
        if now_ns - self._looked_ns < LOOK_NS:
            return
        self._looked_ns = now_ns
        self._validity.observe(self._site, now_ns)
        for name in self._latches:
            self._judge_interlock(name, now_ns)
            self._tell_overridable(name, now_ns)
        self._act_on_link_loss(now_ns)
        for name, guard in self._enclosures.items():
            self._keep_closed(name, guard, now_ns)
        self._judged_ns = now_ns

    def _act_on_link_loss(self, now_ns: int) -> None:
        """Begin what is due without a hub; before the roofs, for it may want them closed."""
        for device, policy in self._losses.due(lambda since: self._age_ns(since, now_ns)):
            away = f"no hub for {policy.after:g} s"
            self._output.record_event("link_loss_acted", device, away, "", good=False)
            if policy.run:
                self._run(f"link loss {device}", policy.run)

    def _age_ns(self, since_ns: int, now_ns: int) -> int:
        """Say how old something is; a standstill of our own is no silence of a station."""
        return self._credit.age_ns(since_ns, now_ns)

    def _unheard(self, rule: Interlock, now_ns: int) -> str:
        """Say what has not been heard since a standstill of our own: nothing opens by its leave."""
        if not self._credit.settling(now_ns):
            return ""
        for condition in [part for each in rule.when for part in (each, *each.all_of)]:
            device, _, name = condition.signal.partition("/")
            reading = self._readings.latest(condition.signal) if condition.signal else None
            if reading is None:
                continue
            signal = self._site.devices[device].signals[name]
            max_age = signal.max_age if condition.max_age is None else condition.max_age
            if now_ns - reading.mono_ns > round(max_age * SECOND):
                return f"{signal.name}: nothing was heard since the gateway stood still"
        return ""

    def reached(self, command: str, now_ns: int) -> bool | None:
        """Tell whether sensors say that what a command is for is so; none where none could say.

        ``command`` is ``<device>/<command>``: what closes a roof, or parks its telescope.
        """
        for name, rule in self._site.enclosures.items():
            if command == rule.close.command:
                return self.enclosure_seen(name, now_ns).closed is True
            if rule.park is not None and rule.parked is not None and command == rule.park.command:
                return self._sighted(rule.parked, now_ns) is True
        return None

    def _judge_interlock(self, name: str, now_ns: int) -> None:
        latch, rule = self._latches[name], self._site.interlocks[name]
        before, ended = latch.override, ""
        verdict = self._verdict(name, now_ns)
        if before is not None and (ended := self._holds[name].ends(before.condition, now_ns)):
            latch.end_override(now_ns)
        for change in latch.update_state(verdict, now_ns):
            match change:
                case InterlockChange.LOCKED:
                    self._record_event("interlock_locked", f"{name}: {latch.why}", good=False)
                case InterlockChange.RELEASED:
                    self._record_event("interlock_released", name, good=True)
                case InterlockChange.OVERRIDE_ENDED:
                    who = "" if before is None else before.who
                    said = f"{name}: {ended}" if ended else name
                    self._output.record_event("override_ended", "", said, who, good=True)
                case InterlockChange.FIRED:
                    if rule.run:
                        self._record_event("interlock_acts", f"{name}: {latch.why}", good=False)
                        self._run(f"interlock {name}", rule.run)
                    continue
                case InterlockChange.TOLD:
                    pass
            self._output.send(self._state(name, now_ns))

    def _keep_closed(self, name: str, guard: EnclosureGuard, now_ns: int) -> None:
        rule = self._site.enclosures[name]
        why = self._losses.closing(name)
        for interlock in rule.unsafe:
            latch = self._latches.get(interlock)
            if latch is not None and latch.demands:
                why = f"{self._site.interlocks[interlock].name}: {latch.why}"
                why = why if latch.why else self._site.interlocks[interlock].name
                break
        closed = self._closed(rule, now_ns)
        self._carry_out([*self._agreements[name].compare_sensors(closed, now_ns)])
        self._carry_out(guard.update_enclosure(why, self._seen(rule, closed, now_ns), now_ns))
        if self._problem(name) != self._told_problems.get(name, ""):
            self._tell_enclosure(name)
        follower = self._followers.get(name)
        if follower is not None and not why:
            self._follow(follower, now_ns)

    def _problem(self, name: str) -> str:
        """Say why people are to look at an enclosure: it is not closed, or nobody can tell."""
        return self._enclosures[name].problem or self._agreements[name].problem

    def _tell_enclosure(self, name: str) -> None:
        why = self._told_problems[name] = self._problem(name)
        self._output.send(EnclosureState(enclosure=name, why=why[:2000]))

    def _closed(self, rule: Enclosure, now_ns: int) -> ClosedVerdict:
        def sensors(sightings: tuple[Sighting, ...]) -> list[RoofSensor]:
            return [self._sensor(each, now_ns) for each in sightings]

        segments = {name: sensors(each.closed) for name, each in rule.segments.items()}
        flap = {} if rule.flap is None else {"flap": sensors(rule.flap.closed)}
        return closed_by(sensors(rule.closed), segments, flap, now_ns=now_ns)

    def _sensor(self, sighting: Sighting, now_ns: int) -> RoofSensor:
        described = self._site.signal(sighting.signal)
        value = self._fresh(sighting.signal, now_ns)
        word = "unknown" if value is None or described is None else word_of(described, value)
        name = sighting.signal if described is None else described.name
        reading, closed = self._readings.latest(sighting.signal), self._sighted(sighting, now_ns)
        said_ns = 0 if reading is None else reading.mono_ns
        since_ns = self._turns.since_ns(sighting, closed, said_ns)
        return RoofSensor(closed, f"{name}: {word}", said_ns, since_ns)

    def _follow(self, follower: Follower, now_ns: int) -> None:
        rule = follower.rule
        device, _, command = rule.command.partition("/")
        step = follower.next_step(
            self._fresh(rule.target, now_ns),
            self._fresh(rule.azimuth, now_ns),
            now_ns,
            settled=self._sighted(rule.when, now_ns) is True,
        )
        if step is not None and not self.refusal(device, command, now_ns):
            self._run(f"follow {device}", (step,))

    def _carry_out(self, acts: list[EnclosureAction | EnclosureEvent]) -> None:
        for act in acts:
            if isinstance(act, EnclosureEvent):
                self._output.record_event(act.kind, "", act.message, "", good=act.good)
            else:
                self._run(act.label, (act.step,))

    def _fresh(self, address: str, now_ns: int) -> float | None:
        """Give a signal's value, or none when it is unknown or too old."""
        device, _, signal = address.partition("/")
        described = self._site.devices[device].signals[signal]
        reading = self._readings.latest(address)
        if reading is None or self._age_ns(reading.mono_ns, now_ns) > round(
            described.max_age * SECOND
        ):
            return None
        if self._validity.problem(
            address, described, reading, max_age=described.max_age, now_ns=now_ns
        ):
            return None
        return reading.value if math.isfinite(reading.value) else None

    def _sighted(self, sighting: Sighting, now_ns: int) -> bool | None:
        """Tell whether a sensor says so; none when it says nothing."""
        value = self._fresh(sighting.signal, now_ns)
        device, _, signal = sighting.signal.partition("/")
        described = self._site.devices[device].signals[signal]
        if described.type is SignalType.NUMBER:
            return None if value is None else within_sighting(sighting, value)
        states = described.states
        if value is None or value != int(value) or not 0 <= value < len(states):
            return None
        return states[int(value)] in sighting.is_one_of

    def _verdict(self, name: str, now_ns: int) -> InterlockVerdict:
        """Give the first thing that is certainly unsafe, or else the first that is unknown.

        It asks for the longest dwell time of all that are unsafe.
        """
        looks = [
            (
                condition_id(wire.condition),
                wire.judge_condition(lambda one: self._judge(one, now_ns), now_ns),
            )
            for wire in self._wires[name]
        ]
        self._holds[name].update_verdicts(looks, now_ns)
        verdicts = [verdict for _, verdict in looks if verdict.why]
        if not verdicts:
            return InterlockVerdict()
        own = self._site.interlocks[name].dwell
        longest = max(own if each.dwell is None else each.dwell for each in verdicts)
        first = next((each for each in verdicts if each.certain), verdicts[0])
        return first._replace(dwell=longest)

    def _judge(self, condition: Condition, now_ns: int) -> InterlockVerdict:
        if condition.all_of:
            return together([self._judge(part, now_ns) for part in condition.all_of])
        if condition.link_lost is not None:
            lost = self._losses.lost_ns
            if lost is None or self._age_ns(lost, now_ns) < round(condition.link_lost * SECOND):
                return InterlockVerdict()
            return InterlockVerdict(f"the hub has been out of reach for {condition.link_lost:g} s")
        if condition.sun is not None:
            place = self._site.place
            if place is None:
                return InterlockVerdict("it is not known where the site is", unknown=True)
            return judge_sun(condition, place, self._wall_ns())
        other = condition.minus or condition.humidity
        if not other:
            return self._judge_signal(condition, condition.signal, now_ns)
        # Each by itself first: one that is unknown makes the difference unknown.
        alone = Condition(max_age=condition.max_age)
        for address in (condition.signal, other):
            verdict = self._judge_signal(alone, address, now_ns)
            if verdict.why:
                return verdict
        return self._judge_two(condition, other)

    def _judge_two(self, condition: Condition, other: str) -> InterlockVerdict:
        first, second = self._site.signal(condition.signal), self._site.signal(other)
        one, two = self._readings.latest(condition.signal), self._readings.latest(other)
        if first is None or second is None or one is None or two is None:
            return InterlockVerdict("no value yet", unknown=True)
        if condition.humidity:
            return judge_dew_point(
                condition=condition,
                name=first.name,
                temperature=one.value,
                humidity=two.value,
                unit=first.unit,
            )
        values = (one.value, two.value)
        return judge_difference(condition, (first.name, second.name), values, first.unit)

    def _judge_signal(self, condition: Condition, address: str, now_ns: int) -> InterlockVerdict:
        device, _, signal = address.partition("/")
        reading = self._readings.latest(address)
        since = self._began_ns[address] if reading is None else reading.mono_ns
        described = self._site.devices[device].signals[signal]
        problem = ""
        if reading is not None:
            max_age = described.max_age if condition.max_age is None else condition.max_age
            problem = self._validity.problem(
                address, described, reading, max_age=max_age, now_ns=now_ns
            )
        return judged(
            condition=condition,
            signal=described,
            reading=reading,
            age_ns=self._age_ns(since, now_ns),
            problem=problem,
        )

    def _record_event(self, kind: str, message: str, *, good: bool) -> None:
        self._output.record_event(kind, "", message, "", good=good)


def _meant(site: Site, address: str) -> tuple[object, ...] | None:
    """Give what is described of a signal, and of the camera it counts on, but for its name."""
    device, _, name = address.partition("/")
    described = site.devices.get(device)
    signal = None if described is None else described.signals.get(name)
    if signal is None:
        return None
    return msgspec.structs.replace(signal, name="", was=""), detection_setup_of(
        site, device, signal.source.stream
    )


def _heard(site: Site, address: str) -> tuple[object, ...]:
    """Give all that decides whether a newest reading of a signal is at hand."""
    device = address.partition("/")[0]
    connection = site.connection_of(device) if device in site.devices else ""
    return _meant(site, address), connection
