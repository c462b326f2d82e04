"""What an installed type is made of, for the gateway, which has no packages of messages."""

from __future__ import annotations

import base64
import re
import sys
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from rclpy.serialization import serialize_message

if TYPE_CHECKING:
    from typing import Any

_PART = re.compile(r"([a-zA-Z]\w*)/([a-zA-Z]\w*)")


def interface_packages() -> dict[str, str]:
    """Name the packages that have messages, services or actions, and give their folders."""
    found: dict[str, str] = {}
    for entry in sys.path:
        folder = Path(entry or ".")
        if folder.is_dir():
            for path in folder.glob("*/*_s__rosidl_typesupport_c.*"):
                # As Python does: the first on the path counts.
                found.setdefault(path.parent.name, str(path.parent))
    return found


def class_named(name: str) -> Any:  # noqa: ANN401 - generated classes are untyped
    """Find the class of ``package/msg/Name``, ``package/srv/Name_Request`` and so on, or None.

    Parts of services and actions: ``package/srv/Name``, then ``.Request`` or ``.Impl.…``.
    """
    package, middle, short = name.split("/")
    first, *rest = short.split(".")
    try:
        found = getattr(import_module(f"{package}.{middle}"), first)
        for step in rest:
            found = getattr(found, step)
    except (ImportError, AttributeError):
        return None
    return found


def describe_type(name: str) -> dict[str, Any] | None:
    """Give the fields, constants and defaults of a message with all it is made of, or None."""
    top = class_named(name)
    if top is None:
        return None
    # By name: fields and constants of each part, as the classes tell them.
    parts: dict[str, Any] = {}
    waiting = [(name, top)]
    while waiting:
        part, kind = waiting.pop()
        fields = kind.get_fields_and_field_types()
        parts[part] = {"fields": fields, "constants": _constants_of(kind)}
        for declared in fields.values():
            for package, short in _PART.findall(declared):
                inner = f"{package}/msg/{short}"
                # An action's goal is called Name_Goal there, and is found as Name.Goal.
                goal = ".".join(short.rsplit("_", 1))
                found = class_named(inner) or class_named(f"{package}/action/{goal}")
                if inner not in parts and found is not None:
                    waiting.append((inner, found))
    # Its defaults are in the bytes of an empty one, and nowhere else to be had.
    empty = base64.b64encode(serialize_message(top())).decode()
    return {"parts": parts, "empty": empty}


def _constants_of(kind: Any) -> dict[str, Any]:  # noqa: ANN401
    found: dict[str, Any] = {}
    for name in dir(type(kind)):
        value = getattr(kind, name, None) if name.isupper() else None
        # How rosidl has a ``byte``.
        if isinstance(value, bytes) and len(value) == 1:
            found[name] = value[0]
        elif isinstance(value, int) and not isinstance(value, bool):
            found[name] = value
    return found
