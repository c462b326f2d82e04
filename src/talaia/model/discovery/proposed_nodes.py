"""Signals and commands of a robot's nodes: their life cycles and their parameters. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.connection import RosSource
from talaia.model.connections.ros import LIFECYCLE_STATES, LIFECYCLE_TRANSITIONS, TRANSITION
from talaia.model.discovery.device_places import place_of
from talaia.model.discovery.ros_units import readable_name, unit_said, word_of
from talaia.model.discovery.topic_words import path_in_words
from talaia.model.list_texts import LIST_TYPES
from talaia.model.site import Argument, ArgumentType, Command, CommandKind, Signal, SignalType

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from talaia.model.discovery.device_places import DevicePlace
    from talaia.model.discovery.probe_report import NodeFound, ParameterFound, TopicFound

__all__ = ["MAX_OF_A_NODE", "commands_of_node", "place_of_node", "signals_of_node"]

# More parameters of one node than that bury what else is on its device's page.
MAX_OF_A_NODE = 30
# Of what a person may write as a list, in letters.
_MAX_LIST = 2000


def place_of_node(node: NodeFound, found: Iterable[TopicFound]) -> DevicePlace:
    """Give the device of a node: that of most of what it publishes, else one of its own."""
    topics = tuple(found)
    places = [
        place_of(topic.topic, topic.type, topics)
        for topic in topics
        if topic.topic in node.publishes
    ]
    if not places:
        return place_of(f"{node.node}/node", "", topics)
    # Of several that have as much, the first in the alphabet.
    return max(sorted(set(places)), key=places.count)


def signals_of_node(node: NodeFound, place: DevicePlace) -> Iterator[tuple[str, Signal]]:
    """Give a node's signals, each with its word."""
    if node.lifecycle:
        name = _beside(node, place, "life cycle")
        yield (
            word_of(name),
            Signal(
                name=name,
                type=SignalType.STATE,
                states=LIFECYCLE_STATES,
                source=RosSource(lifecycle=node.node),
            ),
        )
    # One click away: a page begins with what a robot says by itself.
    for parameter in node.parameters[:MAX_OF_A_NODE]:
        name = _beside(node, place, path_in_words(parameter.parameter))
        yield word_of(name), _signal_of(node, parameter, name)


def commands_of_node(node: NodeFound, place: DevicePlace) -> Iterator[tuple[str, Command]]:
    """Give a node's commands, each with its word."""
    for transition in LIFECYCLE_TRANSITIONS if node.lifecycle else ():
        name = readable_name(transition)
        # Two nodes of one device have the same transitions.
        if not _is_own(node, place):
            name += f" {_node_name(node).lower()}"
        yield (
            word_of(name),
            Command(
                name=name,
                kind=CommandKind.LIFECYCLE,
                target=node.node,
                fixed={TRANSITION: transition},
                # What it starts or stops nobody knows here.
                confirm=True,
            ),
        )
    for parameter in node.parameters[:MAX_OF_A_NODE]:
        # The node would refuse each.
        if not parameter.read_only:
            yield _setter_of(node, place, parameter)


def _setter_of(
    node: NodeFound, place: DevicePlace, parameter: ParameterFound
) -> tuple[str, Command]:
    said = path_in_words(parameter.parameter)
    shown = _beside(node, place, said)
    name = f"Set {shown[:1].lower()}{shown[1:]}"
    kind = ArgumentType(parameter.type)
    argument = Argument(
        type=kind,
        field=parameter.parameter,
        name=said,
        unit=_unit_of(parameter),
        minimum=parameter.minimum,
        maximum=parameter.maximum,
        max_length=_MAX_LIST if kind in LIST_TYPES else 200,
    )
    return word_of(name), Command(
        name=name,
        kind=CommandKind.PARAMETER,
        target=node.node,
        description=parameter.description,
        arguments={"value": argument},
        confirm=True,
    )


def _signal_of(node: NodeFound, parameter: ParameterFound, name: str) -> Signal:
    source = RosSource(parameter=f"{node.node}/{parameter.parameter}")
    match ArgumentType(parameter.type):
        # A list is read as one text.
        case kind if kind is ArgumentType.TEXT or kind in LIST_TYPES:
            return Signal(name=name, type=SignalType.TEXT, source=source, primary=False)
        case ArgumentType.BOOLEAN:
            states = ("off", "on")
            return Signal(
                name=name, type=SignalType.STATE, states=states, source=source, primary=False
            )
        case _:
            return Signal(
                name=name,
                unit=_unit_of(parameter),
                minimum=parameter.minimum,
                maximum=parameter.maximum,
                decimals=0 if parameter.type == "integer" else -1,
                source=source,
                primary=False,
            )


def _unit_of(parameter: ParameterFound) -> str:
    """Give the unit that a number's name ends with; what it measures alone says none."""
    if parameter.type not in {"number", "integer"}:
        return ""
    said = unit_said(parameter.parameter.rpartition(".")[2])
    return "" if said is None else said.unit


def _beside(node: NodeFound, place: DevicePlace, name: str) -> str:
    """Name a thing of a node; with the node's name where its device is more than the node."""
    if _is_own(node, place):
        return name[:1].upper() + name[1:]
    return f"{_node_name(node)} {name[:1].lower()}{name[1:]}"


def _is_own(node: NodeFound, place: DevicePlace) -> bool:
    return place.word == word_of("_".join(node.node.strip("/").split("/")))


def _node_name(node: NodeFound) -> str:
    return readable_name(node.node.rpartition("/")[2])
