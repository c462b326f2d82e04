"""All enclosures of a site: what their sensors say, and what keeps them closed and in place. Pure.

An `EnclosureGuard` decides what is asked of one roof; here its sensors are read, what it asks is
begun, and people are told.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.safety.dome_following import Follower, Hold, apart_of, hold_of
from talaia.gateway.safety.enclosure_guard import (
    EnclosureAction,
    EnclosureEvent,
    EnclosureGuard,
    EnclosureReadings,
)
from talaia.gateway.safety.sensor_agreement import (
    ClosedVerdict,
    RoofSensor,
    SensorAgreement,
    SensorTurns,
    closed_by,
)
from talaia.gateway.safety.value_validity import word_of
from talaia.model.interlocks.opening import opening_of
from talaia.wire.frames import EnclosureState

if TYPE_CHECKING:
    from talaia.gateway.ports import ControlOutput, ReadingSource
    from talaia.gateway.safety.condition_judge import ConditionJudge
    from talaia.gateway.safety.interlock_monitor import SequenceStarter
    from talaia.model.interlocks.enclosure import Enclosure, Sighting
    from talaia.model.interlocks.interlock import Step
    from talaia.model.site import Site

__all__ = ["EnclosureSupervisor"]


class EnclosureSupervisor:
    """Reads the sensors of every enclosure and carries out what its guard asks for."""

    def __init__(
        self,
        *,
        site: Site,
        readings: ReadingSource,
        judge: ConditionJudge,
        output: ControlOutput,
        run: SequenceStarter,
    ) -> None:
        """Want nothing yet.

        Args:
            site: the description.
            readings: the newest values.
            judge: says what sensors say now.
            output: tells the hub, and writes down.
            run: begins sequences.

        """
        self._site = site  # Replaced by `redescribe`.
        self._readings = readings  # The newest values; only their times are used here.
        self._judge = judge  # Says whether a sensor's value counts, and what it says.
        self._output = output  # Tells the hub and writes the record.
        # Begins a sequence; one of the same label that still runs is not begun again.
        self._run = run
        # All by the enclosure's name. What is asked of each, and how often already:
        self._guards = {name: EnclosureGuard(name, rule) for name, rule in site.enclosures.items()}
        # Whether its sensors contradict each other, and for how long:
        self._agreements = {name: SensorAgreement(rule) for name, rule in site.enclosures.items()}
        # The domes that turn after a telescope:
        self._followers = {
            name: Follower(rule.follow)
            for name, rule in site.enclosures.items()
            if rule.follow is not None
        }
        # Since when each sensor says what it says.
        self._turns = SensorTurns()
        # What was last told of each enclosure, see `EnclosureState`: only changes are told.
        self._told_problems: dict[str, str] = {}
        # When a command of a device ended last: what it said before counts for no `hold_for`.
        self._ended_ns: dict[str, int] = {}

    def redescribe(self, site: Site) -> None:
        """Go by another description; an enclosure that stays as it was goes on where it is."""
        before, self._site = self._site, site
        guards, followers, agreements = self._guards, self._followers, self._agreements
        self._guards, self._followers, self._agreements = {}, {}, {}
        for name, rule in site.enclosures.items():
            # The whole rule is compared: one other end switch makes what was agreed before
            # worthless.
            same = before.enclosures.get(name) == rule
            self._guards[name] = guards[name] if same else EnclosureGuard(name, rule)
            self._agreements[name] = agreements[name] if same else SensorAgreement(rule)
            if rule.follow is not None:
                self._followers[name] = followers[name] if same else Follower(rule.follow)

    def apply_command(self, device: str, command: str, who: str) -> None:
        """Tell of a person's command that was accepted: it may stop or resume a closing."""
        # Each guard is asked, for one motor's STOP may belong to several enclosures.
        for guard in self._guards.values():
            self._carry_out(guard.handle_command(f"{device}/{command}", who))

    def begin_slew(self, device: str, azimuth: float, now_ns: int) -> None:
        """Tell the domes that follow a telescope where it was sent to (°)."""
        for follower in self._followers_of(device):
            follower.begin_slew(azimuth, now_ns)

    def _followers_of(self, device: str) -> list[Follower]:
        return [
            follower
            for follower in self._followers.values()
            if follower.rule.target.partition("/")[0] == device
        ]

    def hold_for(self, device: str, command: str, now_ns: int) -> Hold | None:
        """Say what a command has to wait for, because a dome follows; none when for nothing."""
        for rule in self._site.enclosures.values():
            follow = rule.follow
            if follow is None or f"{device}/{command}" not in follow.before:
                continue
            # `None` (a sensor that is silent) counts as standing: it cannot hold up a command for
            # ever.
            still = not any(self._judge.sighting_holds(sensor, now_ns) for sensor in rule.moving)
            tracks = self._judge.sighting_holds(follow.when, now_ns)
            apart = apart_of(
                self._judge.fresh_value(follow.target, now_ns),
                self._judge.fresh_value(follow.azimuth, now_ns),
            )
            if any(
                self._before_its_end(address) for address in (follow.when.signal, follow.azimuth)
            ):
                # What is known is older than the last motion's end.
                apart = tracks = None
            held = hold_of(
                follow,
                is_open=follow.open is None or self._judge.sighting_holds(follow.open, now_ns),
                closed=still and self._closed_verdict(rule, now_ns).closed is True,
                moving=follow.moving is not None
                and self._judge.sighting_holds(follow.moving, now_ns),
                # No `follow.moving` is no proof of standing; `hold_of` waits by the angle then.
                apart=0.0 if tracks is False else apart,
            )
            if held is not None:
                return held._replace(why=f"{rule.name}: {held.why}")
        return None

    def mark_ended(self, device: str, now_ns: int) -> None:
        """Tell of a command that has ended: what was heard before counts for no hold."""
        self._ended_ns[device] = now_ns
        for follower in self._followers_of(device):
            follower.end_slew()

    def _before_its_end(self, address: str) -> bool:
        reading = self._readings.latest(address)
        ended_ns = self._ended_ns.get(address.partition("/")[0], 0)
        return reading is None or reading.mono_ns < ended_ns

    def read_enclosure(self, name: str, now_ns: int) -> EnclosureReadings:
        # Equal times count as said since: a value that came with the end tells of the end.
        """Give what the sensors of an enclosure say."""
        rule = self._site.enclosures[name]
        return self._read_sensors(rule, self._closed_verdict(rule, now_ns), now_ns)

    def _read_sensors(
        self, rule: Enclosure, closed: ClosedVerdict, now_ns: int
    ) -> EnclosureReadings:
        opening = any(
            self._judge.sighting_holds(sighting, now_ns)
            for sighting in opening_of(self._site, rule)
        )
        # A roof that certainly opens is not closed, whatever its end switch still says.
        return EnclosureReadings(
            closed=None if closed.closed is None else closed.closed and not opening,
            disagree=closed.disagree,
            open_parts=closed.open_parts,
            opening=opening,
            # Not every sensor has spoken since the end of the motion: none is asked to begin anew.
            moving=closed.settling
            or any(self._judge.sighting_holds(sensor, now_ns) for sensor in rule.moving),
            parked=rule.parked is not None
            and self._judge.sighting_holds(rule.parked, now_ns) is True,
        )

    def blind_reason(self, name: str, now_ns: int) -> str:
        """Say why an enclosure cannot be supervised now: its sensors, or all of the weather's."""
        rule = self._site.enclosures[name]
        readings = self.read_enclosure(name, now_ns)
        # Not told to a dome by a heartbeat: it must close by itself then.
        if readings.closed is None:
            return "its sensors disagree" if readings.disagree else "its sensors say nothing"
        conditions = [
            part
            for interlock in rule.unsafe
            for condition in self._site.interlocks[interlock].when
            for part in (condition, *condition.all_of)
            if part.signal
        ]
        if conditions and all(
            self._judge.judge_condition(condition, now_ns).unknown for condition in conditions
        ):
            return "nothing is known of what makes it unsafe"
        return ""

    def is_reached(self, command: str, now_ns: int) -> bool | None:
        """Tell whether sensors say that what a command is for is so; none where none could say.

        ``command`` is ``<device>/<command>``: what closes a roof, or parks its telescope.
        """
        for name, rule in self._site.enclosures.items():
            if command == rule.close.command:
                return self.read_enclosure(name, now_ns).closed is True
            if rule.park is not None and rule.parked is not None and command == rule.park.command:
                return self._judge.sighting_holds(rule.parked, now_ns) is True
        return None

    def keep_closed(self, name: str, why: str, now_ns: int) -> None:
        """Do what keeps an enclosure closed for as long as there is a reason ``why``."""
        # Disagreement first, so that the record has the reason before what follows from it.
        rule, guard = self._site.enclosures[name], self._guards[name]
        closed = self._closed_verdict(rule, now_ns)
        self._carry_out([*self._agreements[name].compare_sensors(closed, now_ns)])
        self._carry_out(
            guard.update_enclosure(why, self._read_sensors(rule, closed, now_ns), now_ns)
        )
        if self._attention_reason(name) != self._told_problems.get(name, ""):
            self.send_state(name)

    def following_step(self, name: str, now_ns: int) -> Step | None:
        """Give the command that turns a dome after its telescope, when one is due."""
        follower = self._followers.get(name)
        if follower is None:
            return None
        rule = follower.rule
        return follower.next_step(
            self._judge.fresh_value(rule.target, now_ns),
            self._judge.fresh_value(rule.azimuth, now_ns),
            now_ns,
            settled=self._judge.sighting_holds(rule.when, now_ns) is True,
            moving=self._judge.sighting_holds(rule.moving, now_ns) if rule.moving else None,
        )

    def _attention_reason(self, name: str) -> str:
        """Say why people are to look at an enclosure: it is not closed, or nobody can tell."""
        return self._guards[name].problem or self._agreements[name].problem

    def send_state(self, name: str) -> None:
        """Tell the hub why people are to look at an enclosure, or that they need not."""
        # The wire's limit for this text.
        why = self._told_problems[name] = self._attention_reason(name)
        self._output.send(EnclosureState(enclosure=name, why=why[:2000]))

    def _closed_verdict(self, rule: Enclosure, now_ns: int) -> ClosedVerdict:
        def sensors(sightings: tuple[Sighting, ...]) -> list[RoofSensor]:
            return [self._roof_sensor(sighting, now_ns) for sighting in sightings]

        segments = {name: sensors(segment.closed) for name, segment in rule.segments.items()}
        flap = {} if rule.flap is None else {"flap": sensors(rule.flap.closed)}
        return closed_by(sensors(rule.closed), segments, flap, now_ns=now_ns)

    def _roof_sensor(self, sighting: Sighting, now_ns: int) -> RoofSensor:
        described = self._site.signal(sighting.signal)
        value = self._judge.fresh_value(sighting.signal, now_ns)
        word = "unknown" if value is None or described is None else word_of(described, value)
        name = sighting.signal if described is None else described.name
        reading, closed = (
            self._readings.latest(sighting.signal),
            self._judge.sighting_holds(sighting, now_ns),
        )
        said_ns = 0 if reading is None else reading.mono_ns
        since_ns = self._turns.since_ns(sighting, closed, said_ns)
        return RoofSensor(closed, f"{name}: {word}", said_ns, since_ns)

    def _carry_out(self, acts: list[EnclosureAction | EnclosureEvent]) -> None:
        for act in acts:
            if isinstance(act, EnclosureEvent):
                # The label is part of the act: a park that hangs must not keep a close from being
                # begun.
                self._output.record_event(act.kind, "", act.message, "", good=act.good)
            else:
                self._run(act.label, (act.step,))
