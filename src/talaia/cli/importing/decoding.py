"""Messages by the definitions that their file carries: ROS 1, ROS 2 (CDR) and JSON."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import TYPE_CHECKING, NamedTuple

from rosbags.typesys import (
    Stores,
    TypesysError,
    get_types_from_idl,
    get_types_from_msg,
    get_typestore,
)

from talaia.ros_definitions import OutOfBounds, check_text, check_types

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosbags.interfaces.typing import Typesdict

__all__ = ["Definition", "Undecodable", "decoder_of", "ros_type"]

# ROS's own types, for files that carry no definitions: the newest that rosbags has.
_KNOWN = get_typestore(Stores.LATEST)
_NO_DEFINITION = (TypesysError, AssertionError, ValueError, LookupError, SyntaxError)
# Between a definition and each that it is made of, as ROS 2 writes them into a recording.
_RULE = "=" * 80 + "\n"


class Undecodable(Exception):
    """Messages of a topic cannot be read; the text says why."""


class Definition(NamedTuple):
    """How a topic's messages are written.

    Attributes:
        encoding: ``cdr``, ``ros1`` or ``json``.
        type_name: ``package/msg/Name``.
        form: ``msg``, ``idl``, or empty where the file has no definition.
        text: the definition with all that it is made of.

    """

    encoding: str
    type_name: str
    form: str
    text: str


def ros_type(name: str) -> str:
    """Give a type's name with its ``/msg/``, as ROS 2 writes it."""
    parts = name.split("/")
    return f"{parts[0]}/msg/{parts[1]}" if len(parts) == 2 else name


def decoder_of(definition: Definition) -> Callable[[bytes], object]:
    """Give what turns a message's bytes into an object with its fields.

    Raises:
        Undecodable: nobody knows how.

    """
    name = definition.type_name
    if definition.encoding == "json":
        return _json_decoder
    if definition.encoding not in ("cdr", "ros1"):
        raise Undecodable(f"its messages are {definition.encoding or 'raw bytes'}")
    # A store for each topic: two files, or two topics, may define one type name differently.
    store = get_typestore(Stores.EMPTY)
    try:
        # Before anything is made of it: rosbags writes a class of this name, and runs it.
        check_text(name, definition.text)
        types = _read_types(definition)
        if definition.form:
            check_types(types)
        store.register(types)
    # What rosbags raises of text that is no definition; it was written by whoever made the file.
    except (OutOfBounds, RecursionError, *_NO_DEFINITION) as error:
        raise Undecodable(f"its definition of {name} cannot be read: {error}") from error
    read = store.deserialize_ros1 if definition.encoding == "ros1" else store.deserialize_cdr
    return lambda data: read(data, name)


def _read_types(definition: Definition) -> Typesdict:
    name = definition.type_name
    if definition.form == "msg":
        return get_types_from_msg(definition.text, name)
    if definition.form == "idl":
        # One IDL text, or several, each below a rule and a line with the name of its type.
        if not definition.text.startswith(f"{_RULE}IDL: "):
            return get_types_from_idl(definition.text)
        found: Typesdict = {}
        for part in definition.text.split(_RULE)[1:]:
            found.update(get_types_from_idl(part.split("\n", 1)[1]))
        return found
    # The encoding says how bytes are laid out; without the type nobody knows what they are.
    if name not in _KNOWN.fielddefs:
        raise Undecodable(f"the file has no definition of {name}, and it is none of ROS's own")
    return dict(_KNOWN.fielddefs)


def _json_decoder(data: bytes) -> object:
    # As objects with fields, so that the same paths read them as decoded ROS messages.
    return json.loads(data, object_hook=lambda found: SimpleNamespace(**found))
