"""What a ROS 2 type says of itself: its fields, its constants, its parts."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from talaia.gateway.adapters.message_fields import RosMessageType
from talaia.gateway.adapters.ros2.type_definitions.definition_text import rosidl_word
from talaia.gateway.adapters.ros2.type_definitions.field_comments import comments_in
from talaia.gateway.adapters.ros2.type_definitions.installed_package import constants_of

if TYPE_CHECKING:
    from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
        PartDefinition,
        TypeDefinition,
    )

__all__ = ["DefinedParts", "kind_named", "kind_of"]


def kind_of(message_class: Any) -> RosMessageType:  # noqa: ANN401 - generated classes are untyped
    """Read a class's own lists."""
    fields = tuple(message_class.get_fields_and_field_types().items())
    return RosMessageType(fields, constants_of(message_class))


def kind_named(name: str) -> RosMessageType | None:
    """Find ``package/Name`` among the packages that are installed."""
    package, _, short = name.partition("/")
    try:
        return kind_of(getattr(import_module(f"{package}.msg"), short))
    except (ImportError, AttributeError):
        return None


class DefinedParts:
    """The types that one definition holds, by ``package/Name``."""

    def __init__(self, definition: TypeDefinition) -> None:
        """Take the definition."""
        self._parts = definition.parts
        # By type and then by field; read when they are asked for.
        self._comments: dict[str, dict[str, str]] = {}

    def kind_named(self, name: str) -> RosMessageType | None:
        """Give a type; none that the definition does not hold."""
        package, _, short = name.partition("/")
        full = f"{package}/msg/{short}"
        return self.kind_of_part(full) if full in self._parts else None

    def kind_of_part(self, name: str) -> RosMessageType:
        """Give a type by its full name, ``package/srv/Name_Request``; it must be held."""
        part = self._parts[name]
        fields = tuple((field.name, rosidl_word(field.type)) for field in part.fields)
        return RosMessageType(fields, part.constants)

    def comment_of(self, name: str, field: str) -> str:
        """Give what the author wrote beside a field; empty if that is nothing."""
        # Texts are read once; a type has many fields.
        if name not in self._comments:
            part = self._part(name)
            self._comments[name] = comments_in(part.text) if part is not None else {}
        return self._comments[name].get(field, "")

    def _part(self, name: str) -> PartDefinition | None:
        package, _, short = name.partition("/")
        return self._parts.get(f"{package}/msg/{short}")
