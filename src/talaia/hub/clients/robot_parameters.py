"""Parameters of the robot's nodes by their own names: read by signals, set by commands. Pure.

A tool names a parameter as its ROS does: ``/node/name`` in ROS 1; in ROS 2 ``/node.name`` for
Foxglove and ``/node:name`` for rosapi. All of these are understood, whichever it is.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.hub.clients.account_offer import OfferedSignal
from talaia.hub.clients.request_fields import fit_field
from talaia.hub.clients.robot_names import RobotCall
from talaia.model.connection import ConnectionKind, RosSource, kind_of
from talaia.model.list_texts import LIST_TYPES, parse_list
from talaia.model.site import ArgumentType, CommandKind, SignalType

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.hub.clients.account_offer import AccountOffer, OfferedCommand
    from talaia.hub.live.sites import LiveSite
    from talaia.model.site import Site

__all__ = [
    "ParameterValue",
    "RobotParameter",
    "RobotParameters",
    "make_robot_parameters",
    "read_parameters",
]

ParameterValue = float | int | bool | str | list[float | int | bool | str]
_KINDS = frozenset({ConnectionKind.ROS2, ConnectionKind.ROS1})
# How a parameter that is true or false is a state.
_TRUTHS = {"false": False, "true": True}


class RobotParameter(NamedTuple):
    """A parameter of a node.

    Attributes:
        node: absolute.
        name: in which dots may stand.
        ros1: of a node of ROS 1.
        seen: the signal that reads it, if the account may see that.
        commands: those that the account may call and that set it and nothing else.

    """

    node: str
    name: str
    ros1: bool
    seen: OfferedSignal | None = None
    commands: tuple[OfferedCommand, ...] = ()

    def named(self, between: str) -> str:
        """Name it as its ROS does; ``between`` stands before its name in ROS 2."""
        return f"{self.node}{'/' if self.ros1 else between}{self.name}"

    @property
    def argument_type(self) -> ArgumentType | None:
        """The type that a command gives it, if one does."""
        for offered in self.commands:
            for argument in offered.command.arguments.values():
                return argument.type
        return None

    def find_command(self, value: object) -> RobotCall | str:
        """Give the command that sets it to a value, or why there is none."""
        if not self.commands:
            return "no command of yours sets it alone"
        reasons = []
        for offered in self.commands:
            args = fit_field(offered.command, self.name, value)
            if not isinstance(args, str):
                return RobotCall(offered.device, offered.name, args)
            reasons.append(args)
        return "; ".join(dict.fromkeys(reasons[:5]))


class RobotParameters:
    """Those of one account."""

    def __init__(self, found: dict[str, RobotParameter]) -> None:
        """Know these, by ``/node/name``."""
        self._found = found

    def listed(self, between: str) -> dict[str, RobotParameter]:
        """Give all by the names that a tool has for them; see `RobotParameter.named`."""
        return {parameter.named(between): parameter for parameter in self._found.values()}

    def find(self, name: str) -> RobotParameter | None:
        """Find one by any of its names; the slash before it may be left out."""
        whole = name if name.startswith("/") else f"/{name}"
        node, colon, rest = whole.partition(":")
        if colon:
            return self._found.get(f"{node}/{rest}")
        at, _, last = whole.rpartition("/")
        # A dot may be of the parameter's own name, too.
        return self._found.get(whole) or self._found.get(f"{at}/{last.replace('.', '/', 1)}")


def make_robot_parameters(site: Site, account: AccountOffer) -> RobotParameters:
    """Find the parameters behind what an account may see and call."""
    links = site.links()
    found: dict[str, RobotParameter] = {}
    # By name: the connections that have it.
    owners: dict[str, set[str]] = {}
    for node, name, one in _readings_and_settings(account):
        link = site.connection_of(one.device)
        kind = kind_of(links[link]) if link in links else None
        if kind not in _KINDS:
            continue
        key = f"{node}/{name}"
        known = found.get(key, RobotParameter(node, name, ros1=kind is ConnectionKind.ROS1))
        if isinstance(one, OfferedSignal):
            found[key] = known if known.seen else known._replace(seen=one)
        else:
            found[key] = known._replace(commands=(*known.commands, one))
        owners.setdefault(key, set()).add(link)
    # Of two robots' one name would say the value of the one and set that of the other.
    return RobotParameters({key: one for key, one in found.items() if len(owners[key]) == 1})


def read_parameters(
    live: LiveSite, parameters: dict[str, RobotParameter], now_ns: int
) -> dict[str, ParameterValue]:
    """Give what is known now: nothing stale, and nothing of a device that is not reached."""
    if not live.online:
        return {}
    places = {channel.address: at for at, channel in enumerate(live.channels)}
    values = {}
    for name, parameter in parameters.items():
        value = _read_value(live, parameter, places, now_ns)
        if value is not None:
            values[name] = value
    return values


def _readings_and_settings(
    account: AccountOffer,
) -> Iterator[tuple[str, str, OfferedSignal | OfferedCommand]]:
    for seen in account.signals:
        source = seen.signal.source
        if isinstance(source, RosSource) and source.parameter:
            node, _, name = source.parameter.rpartition("/")
            yield node, name, seen
    for offered in account.commands:
        command = offered.command
        fields = {*command.fixed, *(one.field for one in command.arguments.values())}
        # Another that is set along with it would be set to what nobody asked for.
        if command.kind is CommandKind.PARAMETER and len(fields) == 1:
            yield command.target, fields.pop(), offered


def _read_value(
    live: LiveSite, parameter: RobotParameter, places: dict[str, int], now_ns: int
) -> ParameterValue | None:
    seen = parameter.seen
    at = None if seen is None else places.get(seen.address)
    if seen is None or at is None or seen.device in live.current.unreached:
        return None
    arrived_ns, signal = int(live.latest.arrived_ns[at]), seen.signal
    if arrived_ns < 0 or (signal.max_age and now_ns - arrived_ns > signal.max_age * SECOND):
        return None
    if signal.type is SignalType.TEXT:
        return _of_text(live.latest.texts.get(at, ""), parameter.argument_type)
    value = float(live.latest.value[at])
    if not math.isfinite(value):
        return None
    return _of_number(value, signal.states, parameter.argument_type)


def _of_text(text: str, kind: ArgumentType | None) -> ParameterValue:
    return parse_list(kind, text) if kind is not None and kind in LIST_TYPES else text


def _of_number(value: float, states: tuple[str, ...], kind: ArgumentType | None) -> ParameterValue:
    if kind is ArgumentType.BOOLEAN:
        return bool(value)
    if kind is ArgumentType.INTEGER and value.is_integer():
        return int(value)
    if states and 0 <= value < len(states):
        word = states[int(value)]
        return _TRUTHS.get(word, word) if set(states) == set(_TRUTHS) else word
    return value
