"""From what a probe found to a site description that runs as it is. Pure.

Everything that can be read becomes a signal; what people look at first is *primary*, the rest is
one click away. Limits of driving are low on purpose: the robot's owner raises them.

Which device something belongs to is decided by `device_places`, what its signals are called and
which come first by `proposed_signals`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, TypeVar

import msgspec

from talaia.model.checks.site_checks import check_site
from talaia.model.connection import (
    RosSource,
)
from talaia.model.discovery.device_places import ODOMETRY, PICTURES, place_of, place_order
from talaia.model.discovery.found_connections import connections_of, ros2_of
from talaia.model.discovery.json_devices import connection_of, json_devices, json_left_out
from talaia.model.discovery.opened_topics import topics_to_open
from talaia.model.discovery.plain_names import with_plain_names
from talaia.model.discovery.proposed_nodes import (
    MAX_OF_A_NODE,
    commands_of_node,
    place_of_node,
    signals_of_node,
)
from talaia.model.discovery.proposed_signals import ProposedSignals
from talaia.model.discovery.role_proposal import with_roles
from talaia.model.discovery.ros_units import word_of
from talaia.model.discovery.rules.drive_topics import (
    choose_drive_topics,
    is_commanded_velocity,
    is_holonomic,
    is_level,
)
from talaia.model.discovery.rules.field_names import JOINTS, plain_name
from talaia.model.discovery.rules.joint_jogs import is_joint_jog, joint_drive
from talaia.model.discovery.rules.proposed_commands import (
    FOLLOW,
    command_of,
    goal_command,
    is_servo,
    jog_command,
    lists_reason,
    pose_commands,
    stays_reason,
)
from talaia.model.discovery.rules.robot_board import robot_boards
from talaia.model.discovery.rules.stop_choice import (
    NO_ANSWERS,
    StopAnswers,
    StopChoice,
    choices_of,
    with_answers,
    without_commands,
)
from talaia.model.discovery.rules.unwanted_devices import without_devices
from talaia.model.discovery.rules.unwanted_fields import hidden_reason
from talaia.model.discovery.rules.whole_topics import MODELS, whole_of
from talaia.model.discovery.topic_words import free_word, last_part
from talaia.model.site import (
    Command,
    CommandKind,
    CommandRole,
    Device,
    DeviceKind,
    Drive,
    DriveMessage,
    SignalType,
    Site,
    Stream,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from talaia.model.discovery.device_places import DevicePlace
    from talaia.model.discovery.probe_report import (
        ActionFound,
        Found,
        NodeFound,
        ServiceFound,
        TopicFound,
    )

__all__ = ["DescriptionProposal", "propose_description"]

_T = TypeVar("_T")

# Slow and gentle: about a walking child's speed, until the owner says what the robot can do.
CAREFUL_SPEED = 0.2
CAREFUL_TURN = 0.5
CAREFUL_STEERING = 0.3
# Leaving out what the checks refuse can break what refers to it; a few rounds end that.
MAX_ROUNDS = 5
# Last parts of camera topics (image_transport's) that say nothing of the camera.
_PICTURE_ENDINGS = (
    *("image_raw", "image", "images", "compressed", "image_color"),
    *("image_rect_raw", "image_rect", "image_rect_color", "image_mono"),
)
# In which a tool's steps are meant, until the owner names the arm's own frame.
JOG_FRAME = "base_link"


class DescriptionProposal(NamedTuple):
    """A description, and in words what of the robot is not in it and why."""

    site: Site
    left_out: tuple[str, ...]
    # What STOP may go by, of each driven device: nobody but its owner knows.
    stops: tuple[StopChoice, ...] = ()


def propose_description(
    found: Found,
    site: str,
    name: str,
    zone: str,
    *,
    answers: StopAnswers = NO_ANSWERS,
    without: frozenset[str] = frozenset(),
) -> DescriptionProposal:
    """Make a description of what was found.

    Args:
        found: what a probe saw.
        site: short name of the site, a word of an address.
        name: what people call it.
        zone: its IANA time zone.
        answers: what the owner said of STOP.
        without: devices, by their words, that the owner does not want.

    """
    # Topics of brokers are no topics of ROS.
    is_json = connection_of(found) is not None
    proposed_devices = _ProposedDevices(
        msgspec.structs.replace(found, topics=()) if is_json else found
    )
    proposed = Site(
        talaia=1,
        site=site,
        name=name,
        zone=zone,
        ros2=ros2_of(found),
        connections=connections_of(found),
        devices={
            name: with_roles(device)
            for name, device in {
                **proposed_devices.build_devices(),
                **_devices_described(found),
                **json_devices(found),
            }.items()
        },
        topics=() if is_json else topics_to_open(found),
    )
    left_out = [*proposed_devices.left_out, *_drivers_away(found), *json_left_out(found)]
    left_out += [f"{word}: not wanted" for word in proposed.devices if word in without]
    proposed = without_devices(proposed, without)
    for _ in range(MAX_ROUNDS):
        # What the checks refuse is left out, with their words: the rest runs. Leaving something
        # out can make a reference to it wrong, hence the rounds.
        wrong = [
            finding for finding in check_site(proposed) if finding.where.startswith("$.devices.")
        ]
        if not wrong:
            break
        left_out += [str(finding) for finding in wrong]
        proposed = _leave_out_findings(proposed, [finding.where.split(".") for finding in wrong])
    devices = with_plain_names(found, proposed.devices)
    stops = choices_of(found, devices)
    for choice in stops:
        device = devices[choice.device]
        if device.drive is not None:
            stop = with_answers(device.drive.stop, answers, choice)
            drive = msgspec.structs.replace(device.drive, stop=stop)
            devices[choice.device] = msgspec.structs.replace(device, drive=drive)
            if stop.topic:
                left_out.append(
                    f"{stop.topic}: STOP of {device.name} sends it, and no command does"
                )
                devices = without_commands(devices, stop.topic)
    # Last: which tiles there are goes by what the checks have left.
    boards = robot_boards(found, devices)
    proposed = msgspec.structs.replace(proposed, devices=devices, boards=boards)
    return DescriptionProposal(proposed, tuple(left_out), stops)


def _devices_described(found: Found) -> dict[str, Device]:
    """Take over the devices that say themselves what they are."""
    return {
        device.word: device.described for device in found.devices if device.described is not None
    }


def _drivers_away(found: Found) -> list[str]:
    """Name the devices and drivers that show nothing, or not all, and say why."""
    told = [f"{device.device}: {device.problem}" for device in found.devices if device.problem]
    told += [f"{device.device}: {why}" for device in found.devices for why in device.left_out]
    away = [
        device.device for device in found.devices if device.described is None and not device.problem
    ]
    if not away:
        return told
    return [
        *told,
        f"{', '.join(away)}: not connected to the hardware yet; the gateway connects these drivers "
        "and then describes them by itself (to have them here, run: talaia init --connect)",
    ]


def _leave_out_findings(site: Site, wrong: Iterable[list[str]]) -> Site:
    """Leave out what the findings' paths (``$.devices.base.signals.speed.unit``) are about."""
    devices = dict(site.devices)
    for path in wrong:
        # $ . devices . <word> . <part> . <its word>
        word, part = path[2], path[3] if len(path) > 3 else ""
        device = devices.get(word)
        if device is None:
            continue
        kept = getattr(device, part, None)
        if isinstance(kept, dict) and len(path) > 4:
            rest = {key: child for key, child in kept.items() if key != path[4]}
            devices[word] = msgspec.structs.replace(device, **{part: rest})
        elif part == "drive":
            devices[word] = msgspec.structs.replace(device, drive=None)
        else:
            # It is the device itself that is wrong.
            del devices[word]
    return msgspec.structs.replace(site, devices=devices)


class _ProposedDevices:
    """The devices of one probe, and what of it is left out.

    Each thing that was found ends in a device or, with the reason, in ``left_out``; a published
    topic without publishers, and a listener that nobody would write to, are no things of the robot.
    """

    def __init__(self, found: Found) -> None:
        self._found = found
        # In words: what is in no device, and why.
        self.left_out: list[str] = []
        # By device: what can be read, seen, asked and driven.
        self._signals = ProposedSignals(
            found.topics, found.joints, lambda topic: is_level(found, topic)
        )
        self._driven = choose_drive_topics(found)
        self._streams: dict[DevicePlace, dict[str, Stream]] = {}
        self._commands: dict[DevicePlace, dict[str, Command]] = {}
        self._drives: dict[DevicePlace, Drive] = {}

    def build_devices(self) -> dict[str, Device]:
        """Make the devices by their words; called once."""
        for topic in self._found.topics:
            if topic.publishers:
                self._add_published(topic)
        for service in self._found.services:
            self._add_service(service)
        for action in self._found.actions:
            self._add_action(action)
        # After what is published: a drive names the camera and the position to drive by.
        for topic in self._found.topics:
            if topic.subscribers and not hidden_reason(topic.topic):
                self._add_listener(topic)
            elif topic.subscribers and not topic.publishers:
                self.left_out.append(f"{topic.topic}: {hidden_reason(topic.topic)}")
        self._join_bases()
        # Last: a node that is called as a device there is belongs to it.
        for node in self._found.nodes:
            self._add_node(node)
        self._signals.choose_primary()
        self.left_out += self._signals.left_out
        places = sorted(self._places(), key=place_order)
        return {
            place.word: Device(
                name=place.name,
                kind=place.kind,
                signals=self._signals.at_place(place),
                streams=self._streams.get(place, {}),
                commands=self._commands.get(place, {}),
                drive=self._drives.get(place),
            )
            for place in places
        }

    # ── what is published ──

    def _add_published(self, topic: TopicFound) -> None:
        reason = hidden_reason(topic.topic) or topic.problem
        if not reason and last_part(topic.topic) in MODELS:
            reason = "the robot's model, which the page Scene draws"
        if reason:
            self.left_out.append(f"{topic.topic}: {reason}")
            return
        if is_commanded_velocity(topic):
            # What somebody tells the robot is no reading of it; it drives, or stands in `left_out`.
            return
        whole = whole_of(topic.type)
        if whole:
            self.left_out.append(f"{topic.topic}: {whole}, which is one thing and no signals")
            return
        if topic.type not in PICTURES and not topic.names:
            # Of pictures and diagnostics all is shown, though not field by field.
            self.left_out += [f"{topic.topic} {field}" for field in topic.left_out]
        place = self._place_of(topic.topic, topic.type)
        if topic.type in PICTURES:
            streams = self._streams.setdefault(place, {})
            last = last_part(topic.topic, _PICTURE_ENDINGS)
            word = free_word(word_of(last), streams)
            source = RosSource(topic=topic.topic, type=topic.type)
            streams[word] = Stream(name=plain_name(last) or "Camera", source=source)
        elif not self._signals.add_topic(place, topic) and not topic.left_out:
            self.left_out.append(f"{topic.topic}: a {topic.type} holds no number or text")

    # ── what can be asked ──

    def _add_service(self, service: ServiceFound) -> None:
        self._add_asked(service.service, service.type, CommandKind.SERVICE, service)

    def _add_action(self, action: ActionFound) -> None:
        poses = tuple(pose_commands(action, self._found)) if action.type == FOLLOW else ()
        for word, command in poses:
            commands = self._commands.setdefault(self._arm_of(action.action), {})
            commands[free_word(word, commands)] = command
        if poses and action.problem:
            # Nobody fills a trajectory in a form; its named poses are what there is of it.
            self.left_out.append(f"{action.action}: but for its named poses, {action.problem}")
            return
        self._add_asked(action.action, action.type, CommandKind.ACTION, action)

    def _add_asked(
        self,
        target: str,
        type_name: str,
        kind: CommandKind,
        asked: ServiceFound | ActionFound | TopicFound,
    ) -> None:
        goal = goal_command(target, type_name, kind)
        reason = hidden_reason(target) or ("" if goal else asked.problem)
        if reason:
            self.left_out.append(f"{target}: {reason}")
            return
        # A goal is what drives' own: the page Scene looks for it there.
        like = "nav_msgs/msg/Odometry" if goal else type_name
        commands = self._commands_at(target, like)
        command = goal or command_of(target, type_name, kind, asked.fields)
        if goal and any(one.role is goal.role for one in commands.values()):
            # A device has one of each role; the scene takes the first.
            command = msgspec.structs.replace(goal, role=CommandRole.NONE)
        commands[free_word(word_of(command.name), commands)] = command

    def _commands_at(self, target: str, type_name: str) -> dict[str, Command]:
        return self._commands.setdefault(self._place_of(target, type_name), {})

    def _places(self) -> set[DevicePlace]:
        """Give the devices that there are so far."""
        return {*self._signals.by_place, *self._streams, *self._commands, *self._drives}

    def _join_bases(self) -> None:
        """Let what drives have the commands of its namespace, where its odometry has another."""
        driven = [place for place in self._drives if place.kind is DeviceKind.VEHICLE]
        if len(driven) != 1:
            return
        for place in list(self._commands):
            if place.kind is not DeviceKind.VEHICLE or place in self._signals.by_place:
                continue
            if place != driven[0]:
                commands = self._commands.setdefault(driven[0], {})
                for word, command in self._commands.pop(place).items():
                    commands[free_word(word, commands)] = command

    def _add_node(self, node: NodeFound) -> None:
        place = place_of_node(node, self._found.topics)
        # By its word: two of one word would be one device in the end, and one of them lost.
        place = next((known for known in self._places() if known.word == place.word), place)
        for word, signal in signals_of_node(node, place):
            self._signals.add_signal(place, word, signal)
        for word, command in commands_of_node(node, place):
            # A node that has nothing to be commanded needs no device of its own.
            commands = self._commands.setdefault(place, {})
            commands[free_word(word, commands)] = command
        self.left_out += [f"{node.node} {parameter}" for parameter in node.left_out]
        more = len(node.parameters) - MAX_OF_A_NODE
        if more > 0:
            self.left_out.append(f"{node.node}: {more} more parameters")

    # ── what listens ──

    def _add_listener(self, topic: TopicFound) -> None:
        # The order counts: what drives is a velocity, and what is left out has its reason already.
        if topic.topic in {one.topic for one in self._driven.driving}:
            self._add_drive(topic, DriveMessage(topic.type))
        elif is_joint_jog(topic):
            self._add_joints(topic)
        elif is_servo(topic):
            commands = self._commands.setdefault(self._arm_of(topic.topic), {})
            jog = jog_command(topic, JOG_FRAME)
            commands[free_word(word_of(jog.name), commands)] = jog
        elif topic.topic in self._driven.left_out:
            self.left_out.append(f"{topic.topic}: {self._driven.left_out[topic.topic]}")
        elif self._is_keys(topic):
            if self._driven.driving:
                # A velocity topic is the better way where both are.
                first = self._driven.driving[0].topic
                self.left_out.append(f"{topic.topic}: characters that drive; {first} drives it")
            else:
                self._add_drive(topic, DriveMessage.KEYS)
        elif topic.publishers:
            # What the robot's own programs say to each other is read, not commanded.
            return
        elif (what := whole_of(topic.type)) or topic.type in PICTURES:
            what = what or "a picture"
            self.left_out.append(f"{topic.topic}: takes {what}, which no form can hold")
        elif not topic.fields and not topic.problem and not topic.type.endswith("/Empty"):
            self.left_out.append(f"{topic.topic}: what a {topic.type} holds was not told")
        else:
            reason = stays_reason(topic) or lists_reason(topic)
            if reason:
                topic = msgspec.structs.replace(topic, problem=reason)
            self._add_asked(topic.topic, topic.type, CommandKind.TOPIC, topic)

    def _arm_of(self, target: str) -> DevicePlace:
        """Give the device of an arm: its joints where one device has them all, else by its name."""
        # By its namespace: an arm is no vehicle, though the type of a jog is a vehicle's.
        joints = [
            place
            for place, signals in self._signals.by_place.items()
            if any(getattr(one.source, "type", "") == JOINTS for one in signals.values())
        ]
        return joints[0] if len(joints) == 1 else self._place_of(target, JOINTS)

    def _add_joints(self, topic: TopicFound) -> None:
        place = self._arm_of(topic.topic)
        read = {
            f"{at.word}/{word}": signal
            for at, signals in self._signals.by_place.items()
            for word, signal in signals.items()
        }
        drive = joint_drive(topic, self._found, read)
        if isinstance(drive, str):
            self.left_out.append(f"{topic.topic}: {drive}")
        elif place in self._drives:
            first = self._drives[place].topic
            self.left_out.append(f"{topic.topic}: {first} drives the joints of {place.name}")
        else:
            self._drives[place] = drive

    def _is_keys(self, topic: TopicFound) -> bool:
        """Tell whether it takes CloudConnect's characters."""
        is_text = topic.type == "std_msgs/msg/String" and last_part(topic.topic) == "control"
        return is_text and not topic.publishers

    def _add_drive(self, topic: TopicFound, message: DriveMessage) -> None:
        # By a type that means a base, also where characters drive it.
        place = self._driven_place(topic.topic)
        if place in self._drives:
            self.left_out.append(f"{topic.topic}: {place.name} is driven by another topic already")
            return
        self._drives[place] = Drive(
            topic=topic.topic,
            message=message,
            max_speed=CAREFUL_SPEED,
            max_turn=0.0 if message.steers else CAREFUL_TURN,
            max_sideways=CAREFUL_SPEED if message.twists and is_holonomic(self._found) else 0.0,
            max_steering=CAREFUL_STEERING if message.steers else 0.0,
            picture=_first_address(self._streams),
            position=_first_address(
                self._signals.by_place, lambda signal: signal.type is SignalType.POSITION
            ),
        )

    def _driven_place(self, topic: str) -> DevicePlace:
        """Give the device that a topic drives: that of its odometry, where there is one alone."""
        place = self._place_of(topic, "geometry_msgs/msg/Twist")
        moving = [
            at
            for at, signals in self._signals.by_place.items()
            if any(getattr(one.source, "type", "") == ODOMETRY for one in signals.values())
        ]
        return moving[0] if place not in moving and len(moving) == 1 else place

    def _place_of(self, topic: str, type_name: str) -> DevicePlace:
        return place_of(topic, type_name, self._found.topics)


def _first_address(
    by_place: Mapping[DevicePlace, Mapping[str, _T]],
    fits: Callable[[_T], bool] = lambda _: True,
) -> str:
    """Give the address of the first one that fits, in the order of pages; empty for none."""
    for place in sorted(by_place, key=place_order):
        for word, member in by_place[place].items():
            if fits(member):
                return f"{place.word}/{word}"
    return ""
