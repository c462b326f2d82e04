"""How a device is driven under a lease: a vehicle by velocities, an arm by its joints."""

from __future__ import annotations

import msgspec

from talaia.model.base import Shape
from talaia.model.closed_lists import DriveMessage, KeyMode, LinkLoss

__all__ = ["Drive", "DrivenJoint", "Keys", "Stop"]


class Stop(Shape, frozen=True, kw_only=True):
    """How STOP (software) reaches a device, beside zero velocity.

    Attributes:
        topic: a ``std_msgs/msg/Bool`` topic that is true while stopped; empty if there is none.
        confirmed_by: addresses of numbers that must all be within ``below`` of zero: it stands.
        below: see ``confirmed_by``, in the signals' units.

    """

    topic: str = ""
    confirmed_by: tuple[str, ...] = ()
    below: float = 0.02


class Keys(Shape, frozen=True, kw_only=True):
    """How the characters of a ``std_msgs/msg/String`` drive topic are used.

    Attributes:
        mode: see `KeyMode`.
        speed_step: what one ``w`` adds and one ``x`` takes away (m/s). With it, characters are
            counted: as many are sent as reach what is asked for, never beyond ``max_speed``.
            Without it a press is one character, however far it is pressed.
        turn_step: the same of ``a`` and ``d`` (rad/s).
        speed: address of a number signal with the device's own speed (m/s); while it is fresh it
            bounds what is sent as the count does.
        turn: the same of its rate of turn (rad/s).

    """

    mode: KeyMode = KeyMode.PRESS
    speed_step: float | None = None
    turn_step: float | None = None
    speed: str = ""
    turn: str = ""


class DrivenJoint(Shape, frozen=True, kw_only=True):
    """One joint that is driven by its velocity.

    Attributes:
        name: what pages call it; empty for its name on the robot.
        max_speed: in both directions (rad/s, or m/s where it slides; of a camera's pan, tilt and
            zoom the share of its fastest, up to 1).
        position: address of a number signal with where it stands; empty for none. Where it is
            named and not fresh, the joint is not moved.
        minimum: its lower end (rad or m); a joint comes to rest before it. Needs ``position``.
        maximum: its upper end.
        slides: it moves along a line (m) and does not turn (rad).

    """

    name: str = ""
    max_speed: float
    position: str = ""
    minimum: float | None = None
    maximum: float | None = None
    slides: bool = False


class Drive(Shape, frozen=True, kw_only=True):
    """Continuous control of a device (teleoperation), under a lease.

    Attributes:
        topic: what the robot listens to; needed but of an ONVIF camera, which has none.
        max_speed: forward limit (m/s); needed but where joints are driven.
        max_reverse: backward limit, given positive (m/s).
        max_sideways: limit to each side (m/s), of a base that moves sideways (holonomic); 0 for
            one that does not. Forward and sideways together stay within the ellipse of both.
        max_turn: turning limit (rad/s); needed where the message has a rate of turn.
        max_steering: greatest angle of the steered wheels to each side (rad), of an Ackermann
            message, and needed there.
        max_steering_speed: how fast that angle may change (rad/s).
        joints: what moves where ``message`` drives joints, by their names on the robot, in the
            order of the message; of an ONVIF camera (``ptz``) ``pan``, ``tilt`` and ``zoom``, or
            some of them.
        max_joint_acceleration: of each joint (rad/s², or m/s²).
        max_acceleration: (m/s²); a demand for zero is never ramped.
        max_turn_acceleration: (rad/s²).
        rate: control rate to the robot, and of explicit zeros (Hz).
        ttl: a driving frame older than this is refused (s). Zero comes 0.45 s after the newest
            tick the driver has echoed, however long this is.
        zeros_for: how long explicit zeros are published after the last frame (s).
        lease: a lease ends so long after its last renewal (s).
        picture: name of the stream the driver looks at; empty for none.
        position: name of the position signal for the map; empty for none.
        keys: for a device that listens to characters (``message: std_msgs/msg/String``).

    """

    topic: str = ""
    message: DriveMessage = DriveMessage.TWIST
    keys: Keys = msgspec.field(default_factory=Keys)
    # How fast a robot may go its owner has to say: `checks.drive_checks` takes no 0 where it is
    # needed.
    max_speed: float = 0.0
    # None: as fast as forward.
    max_reverse: float | None = None
    max_sideways: float = 0.0
    max_turn: float = 0.0
    max_steering: float = 0.0
    max_steering_speed: float = 0.8
    joints: dict[str, DrivenJoint] = {}
    max_joint_acceleration: float = 2.0
    max_acceleration: float = 1.0
    max_turn_acceleration: float = 6.0
    # These four have bounds in `checks.drive_checks`, which no description can widen.
    rate: float = 20.0
    ttl: float = 0.25
    zeros_for: float = 1.0
    lease: float = 3.0
    # Where nobody says it, a robot without a hub is to stand.
    link_loss: LinkLoss = LinkLoss.STOP
    stop: Stop = msgspec.field(default_factory=Stop)
    picture: str = ""
    position: str = ""

    @property
    def reverse(self) -> float:
        """How fast it may go backward (m/s)."""
        return self.max_speed if self.max_reverse is None else self.max_reverse
