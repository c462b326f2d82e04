"""How STOP reaches a robot: what may be meant, and what its owner said. Pure.

A topic that is called stop may want true or false, and a speed that is always 0 would confirm every
STOP at once. Neither can be seen from outside, so both are asked and never assumed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.model.connection import RosSource
from talaia.model.discovery.rules.field_names import JOINTS
from talaia.model.discovery.topic_words import last_part
from talaia.model.site import DriveMessage, Stop

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.discovery.probe_report import Found
    from talaia.model.site import Device

__all__ = [
    "ABOUT_STOP",
    "NO_ANSWERS",
    "StopAnswers",
    "StopChoice",
    "choices_of",
    "question_of_signal",
    "question_of_topic",
    "with_answers",
    "without_commands",
]

_STOP_TOPICS = ("stop", "e_stop", "estop", "emergency_stop", "soft_stop", "software_stop")
_MOTION = ("twist.twist.linear.x", "twist.twist.angular.z")


class StopAnswers(NamedTuple):
    """What the owner said.

    Attributes:
        topic: is true while the robot is stopped; empty if there is none.
        confirmed_by: addresses of signals that are 0 when it stands, and are not when it moves.

    """

    topic: str = ""
    confirmed_by: tuple[str, ...] = ()


NO_ANSWERS = StopAnswers()


# The questions, as the terminal, the page and the configurator ask them.
ABOUT_STOP = (
    "STOP always sends a velocity of zero. What else it does, only you know; no answer means no."
)


def question_of_topic(topic: str) -> str:
    """Ask for the polarity of a topic: neither is ever assumed."""
    return f"{topic} listens. Does `true` on it stop the robot, and `false` let it go?"


def question_of_signal(shown: str) -> str:
    """Ask whether a signal can confirm STOP: one that never moves confirms nothing."""
    return f"Have you seen {shown} move while the robot moves, and stand at 0 when it stands?"


class StopChoice(NamedTuple):
    """What may be meant at one driven device.

    Attributes:
        topics: that listen, and whose names speak of stopping.
        signals: addresses of speeds.

    """

    device: str
    topics: tuple[str, ...]
    signals: tuple[str, ...]


def choices_of(found: Found, devices: Mapping[str, Device]) -> tuple[StopChoice, ...]:
    """List for each driven device what STOP may go by."""
    topics = tuple(
        topic.topic
        for topic in found.topics
        if topic.subscribers
        and topic.type == "std_msgs/msg/Bool"
        and last_part(topic.topic) in _STOP_TOPICS
    )
    return tuple(
        StopChoice(
            name,
            topics,
            # The robot's odometry may stand at another of its devices.
            _joint_speeds_of(name, device)
            if device.drive.joints
            else _speeds_of(name, device)
            or tuple(one for other in devices.items() for one in _speeds_of(*other)),
        )
        for name, device in devices.items()
        # A camera says itself whether it moves, and was asked.
        if device.drive is not None and device.drive.message is not DriveMessage.PTZ
    )


def _speeds_of(name: str, device: Device) -> tuple[str, ...]:
    return tuple(
        f"{name}/{word}"
        for word, signal in device.signals.items()
        if isinstance(signal.source, RosSource)
        and signal.source.type == "nav_msgs/msg/Odometry"
        and signal.source.field in _MOTION
    )


def _joint_speeds_of(name: str, device: Device) -> tuple[str, ...]:
    return tuple(
        f"{name}/{word}"
        for word, signal in device.signals.items()
        if isinstance(signal.source, RosSource)
        and signal.source.type == JOINTS
        and signal.source.field.startswith("velocity")
    )


def with_answers(stop: Stop, answers: StopAnswers, choice: StopChoice) -> Stop:
    """Give the way of STOP with what the owner said, as far as it is among the choices."""
    confirmed = tuple(one for one in answers.confirmed_by if one in choice.signals)
    topic = answers.topic if answers.topic in choice.topics else ""
    return Stop(topic=topic, confirmed_by=confirmed, below=stop.below)


def without_commands(devices: Mapping[str, Device], topic: str) -> dict[str, Device]:
    """Leave out the commands that write to a topic: what stops the robot has no second button.

    A device that had nothing else goes with them.
    """
    made = {
        word: msgspec.structs.replace(
            device,
            commands={name: one for name, one in device.commands.items() if one.target != topic},
        )
        for word, device in devices.items()
    }
    return {
        word: device
        for word, device in made.items()
        if device.commands or device.signals or device.streams or device.drive
    }
