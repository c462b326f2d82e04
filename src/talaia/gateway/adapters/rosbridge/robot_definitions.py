"""Definitions of a robot's types, as its rosapi tells them, or as a distribution has them. Pure."""

from __future__ import annotations

from typing import NamedTuple

from rosbags.typesys import Stores, TypesysError, get_typestore

from talaia.gateway.adapters.ros2.type_definitions.definition_text import definition_text
from talaia.gateway.adapters.ros2.type_definitions.distribution_stores import (
    DistributionDefinitions,
)
from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    BadDefinition,
    FieldType,
    MessageField,
    PartDefinition,
    TypeDefinition,
)
from talaia.gateway.adapters.ros2.type_definitions.message_text import messages_in_bundle
from talaia.gateway.adapters.rosbridge.message_values import MessageSerializer, cbor_carries
from talaia.gateway.tap_ports import TopicDefinition

__all__ = ["ServerType", "find_definition", "learn_type", "told_definition"]

# What rosapi says where it has no text.
_FAILED = "# failed"
_LONGEST = 512 * 1024
# ROS 1 has them as words of their own, and tells no text of them.
_TIMES = {
    f"builtin_interfaces/msg/{name}": PartDefinition(
        (MessageField("sec", FieldType(word)), MessageField("nanosec", FieldType(word))), {}
    )
    for name, word in (("Time", "uint32"), ("Duration", "int32"))
}


class ServerType(NamedTuple):
    """A type of a server's topics.

    Attributes:
        definition: how its bytes are read.
        serializer: makes them of what the server sends.
        cbor: the server can send it as CBOR.

    """

    definition: TopicDefinition
    serializer: MessageSerializer
    cbor: bool


def learn_type(type_name: str, text: str, ros: int) -> ServerType:
    """Compile a type; where the robot tells no text of it, by the newest distribution that has it.

    Raises:
        BadDefinition: nothing is known of it, or nothing that can be used.

    """
    text, definition = find_definition(type_name, text, ros)
    form = (
        TopicDefinition("ros1msg", text, "ros1")
        if ros == 1
        else TopicDefinition("ros2msg", definition_text(definition), "cdr")
    )
    return ServerType(form, MessageSerializer(definition, ros), cbor=cbor_carries(definition, ros))


def find_definition(type_name: str, text: str, ros: int) -> tuple[str, TypeDefinition]:
    """Read a type by the robot's text, or else by the newest distribution's; give that, too.

    Raises:
        BadDefinition: nothing is known of it, or nothing that can be used.

    """
    if not text or text.startswith(_FAILED) or len(text) > _LONGEST:
        text = _distributions_text(type_name, ros)
    return text, told_definition(type_name, text, ros)


def told_definition(type_name: str, text: str, ros: int) -> TypeDefinition:
    """Read a text with all types that it is made of.

    Raises:
        BadDefinition: it defines nothing that can be used.

    """
    parts = messages_in_bundle(text, type_name)
    if ros == 1:
        parts = {**{name: _as_ros1(part) for name, part in parts.items()}, **_TIMES}
    return TypeDefinition(type_name, parts, "the robot's rosapi").checked()


def _as_ros1(part: PartDefinition) -> PartDefinition:
    """Give a part with ROS 1's bytes, which have a sign."""
    fields = tuple(
        field._replace(type=field.type._replace(base="int8"))
        if field.type.base == "byte"
        else field
        for field in part.fields
    )
    return part._replace(fields=fields)


def _distributions_text(type_name: str, ros: int) -> str:
    if ros == 1:
        store = get_typestore(Stores.ROS1_NOETIC)
        try:
            return store.generate_msgdef(type_name, ros_version=1)[0]
        except (TypesysError, KeyError) as error:
            raise _unknown(type_name) from error
    found = next(iter(DistributionDefinitions().find(type_name)), None)
    if found is None:
        raise _unknown(type_name)
    return definition_text(found)


def _unknown(type_name: str) -> BadDefinition:
    return BadDefinition(
        f"nothing is known of {type_name}: the robot's rosapi tells no definition of it. "
        "Start rosapi beside the rosbridge server, where the type's package is installed"
    )
