"""What a driven device is told: limits, ramp, speed cap, watchdog, explicit zeros. Pure.

Every bound of the safety rules on a velocity stands here. Nothing outside this file makes a
number that reaches an actuator. Long, because each bound leans on the same few times.
"""

from __future__ import annotations

import math
from enum import Enum
from typing import TYPE_CHECKING

from talaia.clock import MS, SECOND
from talaia.gateway.velocity_demand import STILL, VelocityDemand

if TYPE_CHECKING:
    from talaia.model.site import Drive as DriveRule, DrivenJoint
    from talaia.wire.frames import DriveFrame as DriveFrame

__all__ = [
    "STILL",
    "STOP_BY_NS",
    "VelocityDemand",
    "VelocityLimiter",
    "cap_of_loop",
    "cap_of_picture",
    "room_of_joint",
]

# The round trip's steps of the safety rules: full, half and no speed (docs of driving name them).
FULL_LOOP_MS = 150.0
HALF_LOOP_MS = 300.0
NO_LOOP_MS = 500.0
# The same for the age of the picture that the driver looks at.
OLD_PICTURE_MS = 500.0
DEAD_PICTURE_MS = 1000.0
# After the newest sign that the way to the driver and back was whole (the tick that a frame
# echoes), zero comes by then, whatever frames still arrive: with the way up dark, the page echoes
# its last tick for as long as it does not know. 500 ms are promised; the rest is for this process.
STOP_BY_NS = 450 * MS
# A joint slows so that it would need this long (s) for the rest of its way to its end.
END_S = 1.0
# Publications that may come at once, beyond the steady rate.
CREDIT = 3.0


class OutputPhase(Enum):
    """What is published: nothing, the driver's wish, or explicit zeros until a time."""

    SILENT = "silent"
    DRIVING = "driving"
    ZEROS = "zeros"


def cap_of_loop(loop_ms: float) -> float:
    """Give the speed cap for a measured round trip: 1 up to 150 ms, half up to 300, 0 at 500."""
    if not loop_ms <= NO_LOOP_MS:
        return 0.0
    if loop_ms <= FULL_LOOP_MS:
        return 1.0
    if loop_ms <= HALF_LOOP_MS:
        return 0.5
    return 0.5 * (NO_LOOP_MS - loop_ms) / (NO_LOOP_MS - HALF_LOOP_MS)


def cap_of_picture(picture_ms: float, *, has_picture: bool) -> float:
    """Give the speed cap for the age of the picture that the driver looks at.

    Half over 500 ms, none over 1 s. No picture at all counts as an old one where the description
    gives the driver a picture: whoever drives without it does so slowly.
    """
    if picture_ms < 0:
        return 0.5 if has_picture else 1.0
    if picture_ms <= OLD_PICTURE_MS:
        return 1.0
    return 0.5 if picture_ms <= DEAD_PICTURE_MS else 0.0


class VelocityLimiter:
    """One driven device: `offer_frame` takes frames, `next_demand` says what to publish."""

    def __init__(self, rule: DriveRule) -> None:
        """Start silent: after any restart nothing moves and nothing is said."""
        self._rule = rule  # Limits of the description; a changed rule makes another limiter.
        self._ttl_ns = round(rule.ttl * SECOND)  # Longest life of a frame, ns.
        # Between two messages to the robot in a steady hold, ns.
        self._period_ns = round(SECOND / rule.rate)
        # m/s backwards; the forward limit where the description names none.
        self._reverse = rule.reverse
        self._phase = OutputPhase.SILENT
        self._still = STILL._replace(joints=(0.0,) * len(rule.joints))
        # What the driver asks for, clamped to the limits; before cap and ramp.
        self._wish = self._still
        self._output = self._still  # What the robot was told last; the ramp starts there.
        # Where each joint stands (rad or m): NaN where that is not known. Set by the controller.
        self.joint_places: tuple[float, ...] = (math.nan,) * len(rule.joints)
        # Why a joint that is asked for is not moved; empty when none is.
        self.joint_reason = ""
        # When the phase ends by itself (monotonic, as all times here): driving, or the zeros.
        self._until_ns = 0
        # Until when the last frame counts, from when its driver made it.
        self._fresh_until_ns = 0
        # When the robot was last told something; none: it is to be told at once.
        self._said_ns: int | None = None
        # A demand waits because the rate was used up.
        self._unsaid = False
        # How many messages may go at once, for frames come in bunches; and counted up to when.
        self._credit = CREDIT
        self._credit_ns = 0
        # The highest that was accepted: what a network brings late or twice never counts.
        # `-1` lets the first frame, number 0, through.
        self._seq = -1
        self._epoch = -1
        # Whoever drives has to let go before anything is accepted again.
        self._rest = False
        # Between two drivers the robot stands for a moment.
        self._pause_until_ns = 0
        # When a frame last came, accepted or not: a driver who is silent has let go.
        self._offered_ns = 0
        # What the round trip and the age of the picture allow (0 to 1).
        self._line_cap = 1.0  # min of both, set by each accepted frame.
        # What interlocks and enclosures allow, 0 to 1; set by `DriveController.limit_speed`.
        self.share = 1.0
        # Round trip of the last accepted frame without the page's own waiting, ms.
        self.loop_ms = 0.0
        # Frames in this hold (reset when a hold begins) and refused since the last end was
        # recorded.
        self.accepted = 0
        self.refused = 0

    @property
    def output(self) -> VelocityDemand:
        """The last demand given out."""
        return self._output

    @property
    def zero(self) -> VelocityDemand:
        """What stops the robot: no speed, and steered wheels as they were told to stand.

        Wheels that straighten while a vehicle brakes in a curve would leave the curve.
        """
        return self._still._replace(steering=self._output.steering)

    @property
    def cap(self) -> float:
        """The speed cap now (0 to 1): the line's, the picture's, and `share`, which others set."""
        return min(self._line_cap, self.share)

    @property
    def moving(self) -> bool:
        """Tell whether a hold is on: frames were accepted and have not ended."""
        return self._phase is OutputPhase.DRIVING

    @property
    def silent(self) -> bool:
        """Tell whether there is nothing to publish, zeros included."""
        return self._phase is OutputPhase.SILENT

    def offer_frame(self, frame: DriveFrame, epoch: int, age_ns: int, now_ns: int) -> str:
        """Take a frame whose session holds the lease, or give the reason for refusing it.

        Args:
            frame: as it came.
            epoch: of the lease now.
            age_ns: how long ago the tick it echoes was sent, by the gateway's own clock;
                negative for a tick that was never sent.
            now_ns: monotonic.

        """
        why = self._why_not(frame, epoch, age_ns) or self._restless_reason(frame, now_ns)
        # Refused frames count as well: somebody who holds the key through an interlock is not
        # silent.
        self._offered_ns = now_ns
        if why:
            self.refused += 1
            return why
        self._epoch, self._seq = epoch, frame.seq
        if self._phase is not OutputPhase.DRIVING:
            self.accepted = 0
        self.accepted += 1
        self._phase = OutputPhase.DRIVING
        # Whichever is sooner: the driver's frame has aged out, or the way back has been dark too
        # long.
        self._until_ns = now_ns + min(self._ttl_ns, STOP_BY_NS - age_ns)
        # It may have spent most of its life on the way: then it is not said again.
        self._fresh_until_ns = now_ns + self._ttl_ns - age_ns
        # What the page says of its own waiting may shorten the loop, never below nothing.
        self.loop_ms = max(0.0, age_ns / MS - max(0.0, frame.held_ms))
        self._line_cap = min(
            cap_of_loop(self.loop_ms),
            cap_of_picture(frame.picture_ms, has_picture=bool(self._rule.picture)),
        )
        self._wish = self._wish_of(frame)
        return ""

    def _wish_of(self, frame: DriveFrame) -> VelocityDemand:
        rule = self._rule
        linear, lateral = self._within_ellipse(
            min(max(frame.linear, -self._reverse), rule.max_speed),
            _clamp_value(frame.lateral, rule.max_sideways),
            1.0,
        )
        limits = [joint.max_speed for joint in rule.joints.values()]
        return VelocityDemand(
            linear,
            _clamp_value(frame.angular, rule.max_turn),
            lateral,
            _clamp_value(frame.steering, rule.max_steering),
            # A frame that names none lets go of all.
            tuple(map(_clamp_value, frame.joints or self._still.joints, limits)),
        )

    def _within_ellipse(self, linear: float, lateral: float, share: float) -> tuple[float, float]:
        """Cut a velocity to a share of its limits; one that goes aslant keeps its direction.

        Forward and sideways at their limits at once would be faster than either.
        """
        # Each limit of the ellipse, on the side that is gone to.
        ahead = share * (self._rule.max_speed if linear >= 0 else self._reverse)
        aside = share * self._rule.max_sideways
        linear, lateral = _clamp_value(linear, ahead), _clamp_value(lateral, aside)
        if linear == 0.0 or lateral == 0.0:
            return linear, lateral
        reach = math.hypot(linear / ahead, lateral / aside)
        return (linear, lateral) if reach <= 1.0 else (linear / reach, lateral / reach)

    def _why_not(self, frame: DriveFrame, epoch: int, age_ns: int) -> str:
        numbers = (
            *(frame.linear, frame.angular, frame.lateral, frame.steering, *frame.joints),
            *(frame.held_ms, frame.ttl_ms, frame.picture_ms),
        )
        # NaN passes every `min` and `max`, and would reach the actuator.
        if not all(map(math.isfinite, numbers)):
            return "a value is not a finite number"
        if frame.joints and len(frame.joints) != len(self._rule.joints):
            return f"the frame is for {len(frame.joints)} joints, not {len(self._rule.joints)}"
        if frame.epoch != epoch:
            return "the frame belongs to an earlier lease"
        # Only within an epoch: a page loaded anew counts from zero under a higher one.
        if epoch == self._epoch and frame.seq <= self._seq:
            return "the frame is repeated or out of order"
        if age_ns < 0:
            return "the frame echoes a tick that was never sent"
        # A frame may ask for a shorter life than the description gives it, never for a longer.
        ttl_ns = self._ttl_ns
        if frame.ttl_ms > 0:
            # Bounded before the multiplication: a huge number must not become a negative integer.
            ttl_ns = min(ttl_ns, round(min(frame.ttl_ms, 1e6) * MS))
        if age_ns > ttl_ns or age_ns >= STOP_BY_NS:
            return f"the frame is too old ({age_ns // MS} ms)"
        return ""

    def _restless_reason(self, frame: DriveFrame, now_ns: int) -> str:
        let_go = not frame.asks
        if now_ns < self._pause_until_ns and not let_go:
            return "the vehicle comes to rest between two drivers"
        # Nothing offered for twice a frame's life: the key was up, even if no zero arrived.
        paused = now_ns - self._offered_ns > 2 * self._ttl_ns
        if self._rest and not let_go and not paused:
            return "let go first, then press anew"
        self._rest = False
        return ""

    def demand_rest(self, now_ns: int) -> None:
        """Let nothing move before the driver has let go: a reset of STOP starts no motion."""
        # Counted from now: the silence before this is no letting go.
        self._rest, self._offered_ns = True, now_ns

    def demand_pause(self, until_ns: int) -> None:
        """Let nothing move before this time, whoever drives: another takes over."""
        self._pause_until_ns = until_ns

    def halt_motion(self, now_ns: int, seconds: float = 0.0) -> None:
        """End the hold now: zeros for the stated time, or longer, then silence. No ramp."""
        self._wish = self._still
        self._phase = OutputPhase.ZEROS
        self._until_ns = now_ns + round(max(seconds, self._rule.zeros_for) * SECOND)
        # None makes `due_ns` say at once; the first zero does not wait for its turn.
        self._said_ns = None

    def is_prompt(self, now_ns: int) -> bool:
        """Tell whether a fresh wish may be published at once instead of at the next turn.

        A demand for zero always may, and its repetitions need not. Others have a small credit
        that refills at twice the control rate: a key pressed between two frames, or again right
        after its release, is not held back, and a flood of frames cannot raise the rate to the
        robot.
        """
        if not self._wish.asks:
            return self._output.moves
        # Two turns' worth in a period: the frames' own pace plus what bunches.
        earned = max(0, now_ns - self._credit_ns) / (self._period_ns / 2)
        self._credit = min(CREDIT, self._credit + earned)
        self._credit_ns = now_ns
        self._unsaid = self._credit < 1.0
        if self._unsaid:
            return False
        self._credit -= 1.0
        return True

    def due_ns(self) -> int | None:
        """Give when `next_demand` wants to be called next, or none while silent.

        In a hold the frames themselves set the pace; the turn comes half a period later than
        theirs, so that it only fills in for a frame that is missing.
        """
        if self._phase is OutputPhase.SILENT:
            return None
        if self._said_ns is None:
            # 0 is long past on the monotonic clock: due at once.
            return min(0, self._until_ns)
        wait = self._period_ns
        if self._phase is OutputPhase.DRIVING:
            # Half a period where the rate was used up, one and a half where a frame should come
            # meanwhile.
            wait = self._period_ns // 2 if self._unsaid else self._period_ns * 3 // 2
            if self._wish.asks and self._said_ns + wait > self._fresh_until_ns:
                return self._until_ns
        return min(self._said_ns + wait, self._until_ns)

    def next_demand(self, now_ns: int) -> VelocityDemand | None:
        """Give what to publish now, or none for silence."""
        if self._phase is OutputPhase.DRIVING and now_ns >= self._until_ns:
            self.halt_motion(now_ns)
        driven = self._phase is OutputPhase.DRIVING and self._wish.asks
        if driven and now_ns > self._fresh_until_ns:
            # Silence until the zeros, or until a fresh frame: an old wish moves nothing.
            # -1, so that `due_ns` waits for the end of the hold and does not come back each turn.
            self._fresh_until_ns = -1
            return None
        if self._phase is OutputPhase.ZEROS and now_ns >= self._until_ns:
            self._phase = OutputPhase.SILENT
        if self._phase is OutputPhase.SILENT:
            self._output, self._said_ns = self.zero, None
            return None
        # Zeros are told without a ramp: stopping is the robot's own brake.
        driving = self._phase is OutputPhase.DRIVING and self._wish.asks
        self._output = self._ramped_demand(now_ns) if driving else self.zero
        self._said_ns, self._unsaid = now_ns, False
        return self._output

    def _ramped_demand(self, now_ns: int) -> VelocityDemand:
        since = self._period_ns if self._said_ns is None else now_ns - self._said_ns
        # A late turn does not buy a larger jump than two turns' worth.
        seconds = min(max(since, 0), 2 * self._period_ns) / SECOND
        rule, was, wish = self._rule, self._output, self._wish
        linear, lateral = _ramp_vector(
            (was.linear, was.lateral), (wish.linear, wish.lateral), rule.max_acceleration * seconds
        )
        turn = rule.max_turn_acceleration * seconds
        angular = _ramp_toward(was.angular, wish.angular, turn)
        # The cap cuts after the ramp: when the line gets worse, speed falls at once.
        linear, lateral = self._within_ellipse(linear, lateral, self.cap)
        # An angle is no speed: the cap slows how fast it changes.
        steer = rule.max_steering_speed * seconds * self.cap
        return VelocityDemand(
            linear,
            _clamp_value(angular, self.cap * rule.max_turn),
            lateral,
            min(max(wish.steering, was.steering - steer), was.steering + steer),
            self._ramped_joints(seconds),
        )

    def _ramped_joints(self, seconds: float) -> tuple[float, ...]:
        rule, self.joint_reason = self._rule, ""
        step = rule.max_joint_acceleration * seconds
        speeds = []
        for (name, joint), was, wish, place in zip(
            rule.joints.items(),
            self._output.joints,
            self._wish.joints,
            self.joint_places,
            strict=True,
        ):
            # The cap cuts here as well, and then the joint's own end does.
            limit = self.cap * joint.max_speed
            speed = _clamp_value(_ramp_toward(was, wish, step), limit)
            room = room_of_joint(joint, speed, place)
            if abs(speed) > room:
                unknown = math.isnan(place)
                why = "where it stands is not known" if unknown else "it comes to its end"
                self.joint_reason = self.joint_reason or f"{joint.name or name}: {why}"
            speeds.append(_clamp_value(speed, room))
        return tuple(speeds)


def room_of_joint(joint: DrivenJoint, speed: float, place: float) -> float:
    """Give how fast a joint may go on the way it goes, by where it stands (NaN: not known)."""
    if not joint.position or speed == 0.0:
        return abs(speed)
    if math.isnan(place):
        return 0.0
    end = joint.maximum if speed > 0 else joint.minimum
    if end is None:
        return abs(speed)
    # It slows toward its end and is never there: the reading is younger than this time.
    return max(0.0, (end - place) if speed > 0 else (place - end)) / END_S


def _ramp_vector(
    now: tuple[float, float], wish: tuple[float, float], step: float
) -> tuple[float, float]:
    """Ramp forward and sideways as one: aslant is not quicker than along an axis."""
    if wish[0] == 0.0 or wish[1] == 0.0:
        return _ramp_toward(now[0], wish[0], step), _ramp_toward(now[1], wish[1], step)
    # Along the straight way from what was told to what is asked for.
    way = (wish[0] - now[0], wish[1] - now[1])
    share = min(1.0, step / max(math.hypot(*way), 1e-12))
    return now[0] + way[0] * share, now[1] + way[1] * share


def _ramp_toward(now: float, wish: float, step: float) -> float:
    """Move from ``now`` toward ``wish`` by at most ``step``; zero is reached at once."""
    if wish == 0.0:
        return 0.0
    # Both ways in one line: never past the wish, never more than a step from now.
    return min(max(wish, now - step), now + step)


def _clamp_value(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)
