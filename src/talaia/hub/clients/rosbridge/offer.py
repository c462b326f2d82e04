"""What one account is offered of a site as ROS topics, services and actions. Pure.

Raw topics of the robot come beside it, from those who tap them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.clients.account_offer import make_account_offer
from talaia.hub.clients.robot_names import RobotNames, full_type, make_robot_names
from talaia.hub.clients.robot_parameters import RobotParameters, make_robot_parameters
from talaia.model.list_texts import LIST_TYPES
from talaia.model.site import ArgumentType, CommandKind, SignalType

if TYPE_CHECKING:
    from talaia.hub.auth.permissions import Grants
    from talaia.hub.clients.account_offer import AccountOffer, DrivenTopic
    from talaia.hub.clients.robot_names import RobotName
    from talaia.model.site import Command, Signal, Site

__all__ = [
    "NUMBER_TYPE",
    "TEXT_TYPE",
    "RosService",
    "RosbridgeOffer",
    "SignalTopic",
    "full_type",
    "make_rosbridge_offer",
]

NUMBER_TYPE, TEXT_TYPE = "std_msgs/msg/Float64", "std_msgs/msg/String"
_TRIGGER_TYPE = "std_srvs/srv/Trigger"
# What is ours and no topic of the robot begins with it.
_PREFIX = "/talaia"
_FIELD_TYPES = {
    ArgumentType.NUMBER: "float64",
    ArgumentType.INTEGER: "int64",
    ArgumentType.BOOLEAN: "bool",
    ArgumentType.TEXT: "string",
    # Lists are one text: `1, 2.5`, or as JSON has them.
    **dict.fromkeys(LIST_TYPES, "string"),
}
# In the robot's own requests lists are lists. How wide a number is there is not known here.
_ROBOT_TYPES = {
    **_FIELD_TYPES,
    ArgumentType.NUMBERS: "float64[]",
    ArgumentType.INTEGERS: "int64[]",
    ArgumentType.BOOLEANS: "bool[]",
    ArgumentType.TEXTS: "string[]",
    ArgumentType.BYTES: "uint8[]",
}
_FIXED_TYPES = {bool: "bool", int: "int64", float: "float64", str: "string"}


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


class RosService(NamedTuple):
    """A service that is a command of a device, or STOP when ``command`` is empty.

    Attributes:
        type: of the service; an action of the same name has `action_type`.
        fields: arguments in their order, each with its ROS type; of the robot's own, the paths
            in its request that may be filled.
        robot: the robot's own service or action; the request says which command is meant.

    """

    device: str
    command: str
    type: str
    fields: tuple[tuple[str, str], ...] = ()
    action: bool = False
    robot: RobotName | None = None

    @property
    def node(self) -> str:
        """Name the device as a ROS node."""
        return f"{_PREFIX}/{self.device}"

    @property
    def action_type(self) -> str:
        """Name the type of its action."""
        if self.robot is not None:
            return self.type
        return f"talaia/action/{self.device}_{self.command}"


@dataclass(frozen=True, slots=True)
class RosbridgeOffer:
    """All of it, by the name of topic, service or parameter.

    Attributes:
        signals: see above.
        addresses: by the address of a channel: its topic.
        services: see above.
        driven: see above.
        listened: topics of the robot on which messages become commands.
        parameters: plain facts of the description.
        robot_parameters: of the robot's nodes.

    """

    signals: dict[str, SignalTopic] = field(default_factory=dict)
    addresses: dict[str, str] = field(default_factory=dict)
    services: dict[str, RosService] = field(default_factory=dict)
    driven: dict[str, DrivenTopic] = field(default_factory=dict)
    listened: dict[str, RobotName] = field(default_factory=dict)
    parameters: dict[str, str | float] = field(default_factory=dict)
    robot_parameters: RobotParameters = field(default_factory=lambda: RobotParameters({}))


def make_rosbridge_offer(site: Site, grants: Grants) -> RosbridgeOffer:
    """Offer an account what it may see and do at a site now."""
    account = make_account_offer(site, grants)
    offer = RosbridgeOffer(
        driven=account.driven_topics(_PREFIX),
        parameters=account.facts,
        robot_parameters=make_robot_parameters(site, account),
    )
    _offer_signals(offer, account)
    for device, name, command in account.commands:
        offer.services[f"{_PREFIX}/{device}/{name}"] = _offer_command(device, name, command)
    for drive in account.drives:
        stop = RosService(drive.device, "", _TRIGGER_TYPE)
        offer.services[f"{_PREFIX}/{drive.device}/drive/stop"] = stop
    _offer_robot_names(offer, make_robot_names(site, account.commands))
    return offer


def _offer_robot_names(offer: RosbridgeOffer, names: RobotNames) -> None:
    for name, found in (*names.services.items(), *names.actions.items()):
        fields = (
            *((path, _FIXED_TYPES[type(values[0])]) for path, values in found.fixed().items()),
            *((path, _ROBOT_TYPES[of.type]) for path, of in found.arguments().items()),
        )
        action = found.kind is CommandKind.ACTION
        offered = RosService(found.device, "", found.type, fields, action, found)
        # Names of ours stay what they were; of two kinds of one name it is the service.
        offer.services.setdefault(name, offered)
    offer.listened.update(names.topics)


def _offer_signals(offer: RosbridgeOffer, account: AccountOffer) -> None:
    for seen in account.signals:
        whole = f"{_PREFIX}/{seen.address}"
        for part, address in seen.addresses().items():
            topic = f"{whole}/{part}" if part else whole
            offer.signals[topic] = SignalTopic(
                f"{_PREFIX}/{seen.device}", _type_of(seen.signal), seen.signal.states
            )
            offer.addresses[address] = topic


def _type_of(signal: Signal) -> str:
    worded = signal.type is SignalType.TEXT or (signal.type is SignalType.STATE and signal.states)
    return TEXT_TYPE if worded else NUMBER_TYPE


def _offer_command(device: str, name: str, command: Command) -> RosService:
    fields = tuple(
        (argument, _FIELD_TYPES[described.type])
        for argument, described in command.arguments.items()
    )
    kind = f"talaia/srv/{device}_{name}" if fields else _TRIGGER_TYPE
    return RosService(device, name, kind, fields, command.kind is CommandKind.ACTION)
