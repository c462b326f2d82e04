"""What a ROS 2 message class says of itself: its fields, its constants, its parts."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from talaia.gateway.adapters.message_fields import RosMessageType

__all__ = ["kind_named", "kind_of"]


def kind_of(message_class: Any) -> RosMessageType:  # noqa: ANN401 - generated classes are untyped
    """Read a class's own lists; constants stand on its metaclass."""
    constants = {}
    for name in dir(type(message_class)):
        value = getattr(message_class, name, None)
        if name.isupper() and isinstance(value, int) and not isinstance(value, bool):
            constants[name] = value
    return RosMessageType(tuple(message_class.get_fields_and_field_types().items()), constants)


def kind_named(name: str) -> RosMessageType | None:
    """Find ``package/Name`` among the packages that are installed."""
    package, _, short = name.partition("/")
    try:
        return kind_of(getattr(import_module(f"{package}.msg"), short))
    except (ImportError, AttributeError):
        return None
