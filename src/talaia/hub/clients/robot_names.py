"""Commands by the robot's own names: its services, topics and actions, as its programs call them.

A description's command fills fields of a request of the robot's. Here it goes the other way: a
request that was written for the robot becomes the command that makes the same request. What no
command could make is refused in words, and nothing else of the robot can be reached so. Pure.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.clients.request_fields import fit_request
from talaia.model.connection import ROS_KINDS, kind_of
from talaia.model.site import CommandKind

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from talaia.hub.clients.account_offer import OfferedCommand
    from talaia.model.site import Argument, Site
    from talaia.wire.frames import Scalar

__all__ = ["RobotCall", "RobotName", "RobotNames", "full_type", "make_robot_names"]

# Commands of one name whose reasons are told.
_MOST_REASONS = 5


class RobotCall(NamedTuple):
    """The command that makes a request."""

    device: str
    command: str
    args: dict[str, Scalar]


class RobotName(NamedTuple):
    """A service, topic or action of the robot, and the commands that go there.

    Attributes:
        name: absolute.
        type: as the description has it: ``package/srv/Name``.
        kind: which of the three.
        commands: those that the account may call, in the order of the description.
        connections: of these commands' devices.

    """

    name: str
    type: str
    kind: CommandKind
    commands: tuple[OfferedCommand, ...]
    connections: frozenset[str]

    @property
    def device(self) -> str:
        """Name the device that is meant where one has to be told."""
        return self.commands[0].device

    def arguments(self) -> dict[str, Argument]:
        """Give what may be filled, by the field's path in the request."""
        found: dict[str, Argument] = {}
        for offered in self.commands:
            for argument in offered.command.arguments.values():
                found.setdefault(argument.field, argument)
        return found

    def fixed(self) -> dict[str, list[Scalar]]:
        """Give the fields that have to be one of some values, by path, where no argument is."""
        free = self.arguments()
        found: dict[str, list[Scalar]] = {}
        for offered in self.commands:
            for path, value in offered.command.fixed.items():
                if path not in free:
                    found.setdefault(path, []).append(value)
        return found

    def find_command(self, request: Mapping[str, object]) -> RobotCall | str:
        """Give the first command that makes this very request, or why there is none."""
        named = [f"{offered.device}/{offered.name}" for offered in self.commands]
        if len(self.connections) > 1:
            # Each robot has its own: nobody is to move another than was meant.
            several = ", ".join(named[:_MOST_REASONS])
            return f"several robots of this site have {self.name}; call a command: {several}"
        reasons = []
        for name, offered in zip(named, self.commands, strict=True):
            args = fit_request(offered.command, request)
            if not isinstance(args, str):
                return RobotCall(offered.device, offered.name, args)
            reasons.append(f"{name}: {args}")
        more = len(reasons) - _MOST_REASONS
        said = "; ".join(reasons[:_MOST_REASONS])
        return f"{said}; and {more} more" if more > 0 else said


@dataclass(frozen=True, slots=True)
class RobotNames:
    """All of them, by name."""

    services: dict[str, RobotName] = field(default_factory=dict)
    topics: dict[str, RobotName] = field(default_factory=dict)
    actions: dict[str, RobotName] = field(default_factory=dict)


def full_type(name: str) -> str:
    """Give a type's name as ROS 2 writes it; clients of ROS 1 leave ``/msg/`` out."""
    package, slash, rest = name.partition("/")
    return f"{package}/msg/{rest}" if slash and "/" not in rest else name


def make_robot_names(site: Site, commands: Iterable[OfferedCommand]) -> RobotNames:
    """Find the names behind ``commands``, which are those that an account may call."""
    names = RobotNames()
    links = site.links()
    # Whoever may see the device: what is published there is a velocity, which takes a lease.
    moving = {device.drive.topic for device in site.devices.values() if device.drive is not None}
    found = {
        CommandKind.SERVICE: names.services,
        CommandKind.TOPIC: names.topics,
        CommandKind.ACTION: names.actions,
    }
    for offered in commands:
        command, link = offered.command, site.connection_of(offered.device)
        kind = command.kind
        if kind not in found or link not in links or kind_of(links[link]) not in ROS_KINDS:
            continue
        if kind is CommandKind.TOPIC and command.target in moving:
            continue
        known = found[kind].get(command.target)
        if known is None:
            known = RobotName(command.target, command.type, kind, (), frozenset())
        # One name has one type; of another the robot would refuse it.
        same = (offered,) if known.type == command.type else ()
        found[kind][command.target] = known._replace(
            commands=(*known.commands, *same), connections=known.connections | {link}
        )
    return names
