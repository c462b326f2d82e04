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
from talaia.gateway.enclosure import (
    Act,
    EnclosureGuard,
    Follower,
    Hold,
    Said,
    Seen,
    apart_of,
    hold_of,
)
from talaia.gateway.latch import Change, Latch, Verdict
from talaia.gateway.pointing import misdirected
from talaia.gateway.tripwire import Tripwire
from talaia.model.seen import eye_of
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from talaia.gateway.ports import Field, Mouth, Reading, Readings
    from talaia.model.enclosure import Sighting
    from talaia.model.interlock import Condition, LinkLossPolicy, Step
    from talaia.model.site import Signal, Site
    from talaia.wire.frames import OverrideAsk

__all__ = ["Interlocks", "Runner", "judged", "together"]

LOOK_NS = 100 * MS
# Characters: what the wire takes of a reason.
LONGEST_WHY = 500


class Runner(Protocol):
    """Begins sequences of commands."""

    def __call__(self, label: str, steps: tuple[Step, ...]) -> None:
        """Begin one; one of the same label that still runs goes on instead."""
        ...


def judged(condition: Condition, signal: Signal, reading: Reading | None, age_ns: int) -> Verdict:
    """Say what is unsafe about a signal.

    Args:
        condition: what is unsafe.
        signal: its description.
        reading: its newest, if there ever was one.
        age_ns: of the reading; where there is none, how long it has been listened for.

    """
    max_age = signal.max_age if condition.max_age is None else condition.max_age
    fresh = age_ns <= round(max_age * SECOND)
    if reading is None:
        return Verdict(f"{signal.name}: no value yet", certain=not fresh, unknown=True)
    if not fresh:
        return Verdict(f"{signal.name}: no value newer than {max_age:g} s", unknown=True)
    value = reading.value
    if not math.isfinite(value):
        return Verdict(f"{signal.name}: not a number", unknown=True)
    if signal.type is SignalType.STATE:
        return Verdict(_state_problem(condition, signal, value))
    unit = f" {signal.unit}" if signal.unit else ""
    if condition.above is not None and value > condition.above:
        return Verdict(f"{signal.name} is above {condition.above:g}{unit}")
    if condition.below is not None and value < condition.below:
        return Verdict(f"{signal.name} is below {condition.below:g}{unit}")
    return Verdict()


def together(parts: Sequence[Verdict]) -> Verdict:
    """Say what is unsafe about conditions that are unsafe only all at once.

    One that is unknown counts as unsafe, as everywhere; it makes the whole uncertain for as long
    as it is itself.
    """
    if not parts or not all(part.why for part in parts):
        return Verdict()
    why = " and ".join(part.why for part in parts)
    return Verdict(why[:LONGEST_WHY], all(part.certain for part in parts))


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
        site: Site,
        readings: Readings,
        mouth: Mouth,
        run: Runner,
        now_ns: int,
        wall_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        """Start locked and without a link.

        Args:
            site: the description.
            readings: the newest values, see `Site.guarded`.
            mouth: tells the hub, and writes down.
            run: begins sequences.
            now_ns: monotonic.
            wall_ns: UTC, for where the Sun stands.

        """
        self._site = site
        self._wall_ns = wall_ns
        self._readings = readings
        self._mouth = mouth
        self._run = run
        # From when on a signal that has never said anything has been listened to.
        self._began_ns = dict.fromkeys(site.guarded(), now_ns)
        self._lost_ns: int | None = now_ns
        self._looked_ns = now_ns - LOOK_NS
        self._wires = {
            name: [Tripwire(each) for each in rule.when] for name, rule in site.interlocks.items()
        }
        self._enclosures = {
            name: EnclosureGuard(name, rule) for name, rule in site.enclosures.items()
        }
        self._followers = {
            name: Follower(rule.follow)
            for name, rule in site.enclosures.items()
            if rule.follow is not None
        }
        self._latches = {name: Latch(name, rule, now_ns) for name, rule in site.interlocks.items()}
        self._waiting = _policies(site)
        self._due = dict(self._waiting)
        self._ended_ns: dict[str, int] = {}

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
        latches, wires = self._latches, self._wires
        self._latches, self._wires = {}, {}
        for name, rule in site.interlocks.items():
            old = before.interlocks.get(name)
            watched = {each.signal for each in rule.when}
            watched |= {part.signal for each in rule.when for part in each.all_of}
            if old == rule and not any(_meant(before, a) != _meant(site, a) for a in watched if a):
                self._latches[name], self._wires[name] = latches[name], wires[name]
                continue
            known = latches.get(name)
            if known is not None and (over := known.override) is not None:
                self._mouth.note("override_ended", "", name, over.who, good=True)
            latch = Latch(name, rule, now_ns)
            latch.why = "it has just been described"
            self._latches[name] = latch if known is None else known.redescribed(rule, now_ns)
            self._wires[name] = [Tripwire(each) for each in rule.when]
            self._mouth.send(self._latches[name].state(now_ns))
        self._redescribe_enclosures(before, site)
        acted = self._waiting.keys() - self._due.keys()
        self._waiting = _policies(site)
        self._due = {name: rule for name, rule in self._waiting.items() if name not in acted}

    def _redescribe_enclosures(self, before: Site, site: Site) -> None:
        guards, followers = self._enclosures, self._followers
        self._enclosures, self._followers = {}, {}
        for name, rule in site.enclosures.items():
            same = before.enclosures.get(name) == rule
            self._enclosures[name] = guards[name] if same else EnclosureGuard(name, rule)
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
                self._look(name, now_ns)
                latch = self._latches[name]
                if latch.locked:
                    return f"{rule.name}: {latch.why}"
        return self._misdirected(device, what, args or {})

    def share(self, device: str, now_ns: int) -> float:
        """Say at which share of its limits a device may be driven now, 0 to 1."""
        target, share = f"{device}/drive", 1.0
        for name, rule in self._site.interlocks.items():
            if target in rule.slow:
                self._look(name, now_ns)
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
        return misdirected(described.pointing, pointed, args, self._site.place, self._wall_ns())

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
                closed=still and all(self._sighted(each, now_ns) is True for each in rule.closed),
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
            self._do(guard.commanded(f"{device}/{command}", who))

    def override(self, ask: OverrideAsk, now_ns: int) -> None:
        """Override an interlock for a time, or end that; who asked is told by the state."""
        latch = self._latches.get(ask.interlock)
        refused = f"there is no interlock {ask.interlock!r}"
        if latch is not None:
            refused = latch.overrule(ask.who, ask.reason, ask.seconds, now_ns)
        if refused:
            self._mouth.note("override_refused", "", refused, ask.who, good=False)
            return
        if latch is not None and ask.seconds:
            said = f"{ask.interlock} for {ask.seconds:g} s: {ask.reason.strip()}"
            self._mouth.note("interlock_overridden", "", said, ask.who, good=False)
            self._mouth.send(latch.state(now_ns))
        self._look(ask.interlock, now_ns)

    def link_up(self, now_ns: int) -> None:
        """Tell a new link how all stand; what was to follow its loss is called off."""
        self._lost_ns = None
        self._due = dict(self._waiting)
        for latch in self._latches.values():
            self._mouth.send(latch.state(now_ns))

    def link_lost(self, now_ns: int) -> None:
        """Count from now."""
        self._lost_ns = now_ns

    def due_ns(self) -> int | None:
        """Give when `step` wants to be called next, or none where there is nothing to watch."""
        idle = self._lost_ns is None or not self._due
        if not self._latches and not self._enclosures and idle:
            return None
        return self._looked_ns + LOOK_NS

    def step(self, now_ns: int) -> None:
        """Look at everything."""
        if now_ns - self._looked_ns < LOOK_NS:
            return
        self._looked_ns = now_ns
        for name in self._latches:
            self._look(name, now_ns)
        for name, guard in self._enclosures.items():
            self._keep_closed(name, guard, now_ns)
        if self._lost_ns is None:
            return
        for device, policy in list(self._due.items()):
            if now_ns - self._lost_ns >= round(policy.after * SECOND):
                del self._due[device]
                away = f"no hub for {policy.after:g} s"
                self._mouth.note("link_loss_acted", device, away, "", good=False)
                self._run(f"link loss {device}", policy.run)

    def _look(self, name: str, now_ns: int) -> None:
        latch, rule = self._latches[name], self._site.interlocks[name]
        before = latch.override
        verdict = self._verdict(name, now_ns)
        for change in latch.look(verdict, now_ns):
            match change:
                case Change.LOCKED:
                    self._note("interlock_locked", f"{name}: {latch.why}", good=False)
                case Change.RELEASED:
                    self._note("interlock_released", name, good=True)
                case Change.OVERRIDE_ENDED:
                    who = "" if before is None else before.who
                    self._mouth.note("override_ended", "", name, who, good=True)
                case Change.FIRED:
                    if rule.run:
                        self._note("interlock_acts", f"{name}: {latch.why}", good=False)
                        self._run(f"interlock {name}", rule.run)
                    continue
                case Change.TOLD:
                    pass
            self._mouth.send(latch.state(now_ns))

    def _keep_closed(self, name: str, guard: EnclosureGuard, now_ns: int) -> None:
        rule = self._site.enclosures[name]
        why = ""
        for interlock in rule.unsafe:
            latch = self._latches.get(interlock)
            if latch is not None and latch.demands:
                why = f"{self._site.interlocks[interlock].name}: {latch.why}"
                why = why if latch.why else self._site.interlocks[interlock].name
                break
        closed = [self._sighted(each, now_ns) for each in rule.closed]
        seen = Seen(
            closed=None if None in closed else all(closed),
            moving=any(self._sighted(each, now_ns) for each in rule.moving),
            parked=rule.parked is not None and self._sighted(rule.parked, now_ns) is True,
        )
        self._do(guard.look(why, seen, now_ns))
        follower = self._followers.get(name)
        if follower is not None and not why:
            self._follow(follower, now_ns)

    def _follow(self, follower: Follower, now_ns: int) -> None:
        rule = follower.rule
        device, _, command = rule.command.partition("/")
        step = follower.look(
            self._fresh(rule.target, now_ns),
            self._fresh(rule.azimuth, now_ns),
            now_ns,
            settled=self._sighted(rule.when, now_ns) is True,
        )
        if step is not None and not self.refusal(device, command, now_ns):
            self._run(f"follow {device}", (step,))

    def _do(self, acts: list[Act | Said]) -> None:
        for act in acts:
            if isinstance(act, Said):
                self._mouth.note(act.kind, "", act.message, "", good=act.good)
            else:
                self._run(act.label, (act.step,))

    def _fresh(self, address: str, now_ns: int) -> float | None:
        """Give a signal's value, or none when it is unknown or too old."""
        device, _, signal = address.partition("/")
        described = self._site.devices[device].signals[signal]
        reading = self._readings.latest(address)
        if reading is None or now_ns - reading.mono_ns > round(described.max_age * SECOND):
            return None
        return reading.value if math.isfinite(reading.value) else None

    def _sighted(self, sighting: Sighting, now_ns: int) -> bool | None:
        """Tell whether a sensor says so; none when it says nothing."""
        value = self._fresh(sighting.signal, now_ns)
        device, _, signal = sighting.signal.partition("/")
        states = self._site.devices[device].signals[signal].states
        if value is None or value != int(value) or not 0 <= value < len(states):
            return None
        return states[int(value)] in sighting.is_one_of

    def _verdict(self, name: str, now_ns: int) -> Verdict:
        """Give the first thing that is certainly unsafe, or else the first that is unknown.

        It asks for the longest dwell time of all that are unsafe.
        """
        verdicts = [
            verdict
            for wire in self._wires[name]
            if (verdict := wire.look(lambda each: self._judge(each, now_ns), now_ns)).why
        ]
        if not verdicts:
            return Verdict()
        own = self._site.interlocks[name].dwell
        longest = max(own if each.dwell is None else each.dwell for each in verdicts)
        first = next((each for each in verdicts if each.certain), verdicts[0])
        return first._replace(dwell=longest)

    def _judge(self, condition: Condition, now_ns: int) -> Verdict:
        if condition.all_of:
            return together([self._judge(part, now_ns) for part in condition.all_of])
        if condition.link_lost is not None:
            lost = self._lost_ns
            if lost is None or now_ns - lost < round(condition.link_lost * SECOND):
                return Verdict()
            return Verdict(f"the hub has been out of reach for {condition.link_lost:g} s")
        device, _, signal = condition.signal.partition("/")
        reading = self._readings.latest(condition.signal)
        since = self._began_ns[condition.signal] if reading is None else reading.mono_ns
        described = self._site.devices[device].signals[signal]
        return judged(condition, described, reading, now_ns - since)

    def _note(self, kind: str, message: str, *, good: bool) -> None:
        self._mouth.note(kind, "", message, "", good=good)


def _policies(site: Site) -> dict[str, LinkLossPolicy]:
    return {
        name: device.link_loss
        for name, device in site.devices.items()
        if device.link_loss is not None
    }


def _meant(site: Site, address: str) -> tuple[object, ...] | None:
    """Give what is described of a signal, and of the camera it counts on, but for its name."""
    device, _, name = address.partition("/")
    described = site.devices.get(device)
    signal = None if described is None else described.signals.get(name)
    if signal is None:
        return None
    return msgspec.structs.replace(signal, name="", was=""), eye_of(
        site, device, signal.source.stream
    )


def _heard(site: Site, address: str) -> tuple[object, ...]:
    """Give all that decides whether a newest reading of a signal is at hand."""
    device = address.partition("/")[0]
    connection = site.connection_of(device) if device in site.devices else ""
    return _meant(site, address), connection
