"""What one account is offered of a site as ROS topics, services and actions. Pure.

What an account may not see is not in it, so nothing that is listed has to be hidden later. Raw
topics of the robot come beside it, from those who tap them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.auth.permissions import Right, sees_device, sees_signal
from talaia.model.site import ArgumentType, CommandKind, SignalType, parts_of

if TYPE_CHECKING:
    from talaia.hub.auth.permissions import Grants
    from talaia.model.site import Command, Signal, Site

__all__ = [
    "NUMBER_TYPE",
    "TEXT_TYPE",
    "TWIST_TYPE",
    "DrivenTopic",
    "OfferedCommand",
    "RosbridgeOffer",
    "SignalTopic",
    "full_type",
    "make_rosbridge_offer",
]

NUMBER_TYPE, TEXT_TYPE = "std_msgs/msg/Float64", "std_msgs/msg/String"
TWIST_TYPE = "geometry_msgs/msg/Twist"
_TRIGGER_TYPE = "std_srvs/srv/Trigger"
# What is ours and no topic of the robot begins with it.
_PREFIX = "/talaia"
_FIELD_TYPES = {
    ArgumentType.NUMBER: "float64",
    ArgumentType.INTEGER: "int64",
    ArgumentType.BOOLEAN: "bool",
    ArgumentType.TEXT: "string",
}


class SignalTopic(NamedTuple):
    """A topic with the samples of one channel.

    Attributes:
        node: the device, as a ROS node.
        type: of its messages.
        states: of a state: its words.

    """

    node: str
    type: str
    states: tuple[str, ...] = ()


class OfferedCommand(NamedTuple):
    """A service that is a command of a device, or STOP when ``command`` is empty.

    Attributes:
        type: of the service; an action of the same name has `action_type`.
        fields: arguments in their order, each with its ROS type.

    """

    device: str
    command: str
    type: str
    fields: tuple[tuple[str, str], ...] = ()
    action: bool = False

    @property
    def node(self) -> str:
        """Name the device as a ROS node."""
        return f"{_PREFIX}/{self.device}"

    @property
    def action_type(self) -> str:
        """Name the type of its action."""
        return f"talaia/action/{self.device}_{self.command}"


class DrivenTopic(NamedTuple):
    """A topic to which a velocity may be published, and of which type it is there."""

    device: str
    type: str


@dataclass(frozen=True, slots=True)
class RosbridgeOffer:
    """All of it, by the name of topic, service or parameter.

    Attributes:
        signals: see above.
        addresses: by the address of a channel: its topic.
        services: see above.
        driven: see above.
        parameters: plain facts of the description.

    """

    signals: dict[str, SignalTopic] = field(default_factory=dict)
    addresses: dict[str, str] = field(default_factory=dict)
    services: dict[str, OfferedCommand] = field(default_factory=dict)
    driven: dict[str, DrivenTopic] = field(default_factory=dict)
    parameters: dict[str, str | float] = field(default_factory=dict)


def full_type(name: str) -> str:
    """Give a type's name as ROS 2 writes it; clients of ROS 1 leave ``/msg/`` out."""
    package, slash, rest = name.partition("/")
    return f"{package}/msg/{rest}" if slash and "/" not in rest else name


def make_rosbridge_offer(site: Site, grants: Grants) -> RosbridgeOffer:
    """Offer an account what it may see and do at a site now."""
    offer = RosbridgeOffer()
    offer.parameters.update({"/site": site.site, "/name": site.name, "/zone": site.zone})
    for device in site.devices:
        if sees_device(grants, site, device):
            _offer_signals(offer, site, grants, device)
            _offer_actions(offer, site, grants, device)
    return offer


def _offer_signals(offer: RosbridgeOffer, site: Site, grants: Grants, device: str) -> None:
    for name, signal in site.devices[device].signals.items():
        if not sees_signal(grants, site, device, name):
            continue
        for part in parts_of(signal):
            address = f"{device}/{name}.{part}" if part else f"{device}/{name}"
            topic = f"{_PREFIX}/{device}/{name}/{part}" if part else f"{_PREFIX}/{device}/{name}"
            offer.signals[topic] = SignalTopic(
                f"{_PREFIX}/{device}", _type_of(signal), signal.states
            )
            offer.addresses[address] = topic


def _type_of(signal: Signal) -> str:
    worded = signal.type is SignalType.TEXT or (signal.type is SignalType.STATE and signal.states)
    return TEXT_TYPE if worded else NUMBER_TYPE


def _offer_actions(offer: RosbridgeOffer, site: Site, grants: Grants, device: str) -> None:
    described = site.devices[device]
    if grants.has_right(Right.USE, site.site, device):
        for name, command in described.commands.items():
            offer.services[f"{_PREFIX}/{device}/{name}"] = _offer_command(device, name, command)
    rule = described.drive
    # Whoever may look at a driven device may stop it.
    if rule is not None and grants.has_right(Right.VIEW, site.site, device):
        stop = OfferedCommand(device, "", _TRIGGER_TYPE)
        offer.services[f"{_PREFIX}/{device}/drive/stop"] = stop
        # Of two devices that listen to one topic, the first; the other has its own name.
        offer.driven.setdefault(rule.topic, DrivenTopic(device, rule.message.value))
        offer.driven[f"{_PREFIX}/{device}/drive"] = DrivenTopic(device, TWIST_TYPE)
        offer.parameters[f"/{device}/drive/max_speed"] = rule.max_speed
        offer.parameters[f"/{device}/drive/max_turn"] = rule.max_turn


def _offer_command(device: str, name: str, command: Command) -> OfferedCommand:
    fields = tuple(
        (argument, _FIELD_TYPES[described.type])
        for argument, described in command.arguments.items()
    )
    kind = f"talaia/srv/{device}_{name}" if fields else _TRIGGER_TYPE
    return OfferedCommand(device, name, kind, fields, command.kind is CommandKind.ACTION)
