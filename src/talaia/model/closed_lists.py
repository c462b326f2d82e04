"""The closed lists of the site description: every part downstream knows each of their words."""

from __future__ import annotations

from enum import StrEnum

__all__ = [
    "ArgumentType",
    "CommandKind",
    "CommandRight",
    "DeviceKind",
    "DriveMessage",
    "KeyMode",
    "LinkLoss",
    "LogLevel",
    "PositionFrame",
    "SignalType",
    "Visibility",
]


class SignalType(StrEnum):
    """What a signal holds. The list is closed: every part downstream knows each."""

    NUMBER = "number"
    STATE = "state"
    TEXT = "text"
    POSITION = "position"


class PositionFrame(StrEnum):
    """How a position is given: metres in a local frame (REP-105), or WGS 84 degrees."""

    LOCAL = "local"
    WGS84 = "wgs84"


class DeviceKind(StrEnum):
    """What a device is, so that its page can look the part."""

    VEHICLE = "vehicle"
    DOME = "dome"
    TELESCOPE = "telescope"
    CAMERA = "camera"
    WEATHER = "weather"
    POWER = "power"
    OTHER = "other"


class Visibility(StrEnum):
    """Who sees it: everyone (guests too), or those with the right to view."""

    PUBLIC = "public"
    VIEW = "view"


class ArgumentType(StrEnum):
    """What a command's argument may be."""

    NUMBER = "number"
    INTEGER = "integer"
    BOOLEAN = "boolean"
    TEXT = "text"
    # Lists, given as one text: with commas between, or as JSON has them.
    NUMBERS = "numbers"
    INTEGERS = "integers"
    BOOLEANS = "booleans"
    TEXTS = "texts"
    BYTES = "bytes"


class CommandKind(StrEnum):
    """How a one-shot command reaches the robot."""

    SERVICE = "service"
    TOPIC = "topic"
    ACTION = "action"
    # ROS: sets parameters. INDI: sends a property. Alpaca: calls a method. ONVIF: moves a
    # camera, or sets a preset. Process: runs a command. Extension: its own.
    PARAMETER = "parameter"
    # ROS 2: a transition of a life-cycle node.
    LIFECYCLE = "lifecycle"
    INDI = "indi"
    ALPACA = "alpaca"
    ONVIF = "onvif"
    PROCESS = "process"
    EXTENSION = "extension"


class CommandRight(StrEnum):
    """Which right on its device a command takes: ``admin`` where it changes what others rely on."""

    USE = "use"
    ADMIN = "admin"


class DriveMessage(StrEnum):
    """What a driven device listens to."""

    TWIST = "geometry_msgs/msg/Twist"
    TWIST_STAMPED = "geometry_msgs/msg/TwistStamped"
    KEYS = "std_msgs/msg/String"
    ACKERMANN = "ackermann_msgs/msg/AckermannDrive"
    ACKERMANN_STAMPED = "ackermann_msgs/msg/AckermannDriveStamped"
    JOINT_JOG = "control_msgs/msg/JointJog"
    JOINT_VELOCITIES = "std_msgs/msg/Float64MultiArray"
    # Of an ONVIF camera: pan, tilt and zoom, as joints.
    PTZ = "ptz"

    @property
    def steers(self) -> bool:
        """Whether it holds a speed and the angle of steered wheels."""
        return self in (DriveMessage.ACKERMANN, DriveMessage.ACKERMANN_STAMPED)

    @property
    def jogs(self) -> bool:
        """Whether it holds velocities of joints."""
        return self in (
            DriveMessage.JOINT_JOG,
            DriveMessage.JOINT_VELOCITIES,
            DriveMessage.PTZ,
        )

    @property
    def twists(self) -> bool:
        """Whether it holds a velocity of the whole device."""
        return self in (DriveMessage.TWIST, DriveMessage.TWIST_STAMPED)


class KeyMode(StrEnum):
    """How a device that is driven by characters takes them.

    ``press``: each character changes a velocity that the device keeps until ``s``, as the founding
    vehicle's teleoperation does; one is sent for a press, and ``s`` when the press ends.
    ``repeat``: each character is good for a moment, so it is sent again and again while a key is
    held. Never for a device that adds them up.
    """

    PRESS = "press"
    REPEAT = "repeat"


class LogLevel(StrEnum):
    """How bad a line of a robot's log is; ``none`` for a log that nobody reads."""

    NONE = "none"
    DEBUG = "debug"
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"
    FATAL = "fatal"


class LinkLoss(StrEnum):
    """What a driven device is told when the hub cannot be reached.

    A hold that is on ends with zeros in any case. ``stop`` says zeros also to a device that
    nobody drives, so that it halts whatever it is doing; ``hold`` leaves that as it is.
    """

    STOP = "stop"
    HOLD = "hold"
    # The former word for `HOLD`.
    NOTHING = "nothing"
