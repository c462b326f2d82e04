"""Reads ``.msg``, ``.srv`` and ``.action`` texts, alone or as recordings carry them. Pure.

https://docs.ros.org/en/rolling/Concepts/Basic/About-Interfaces.html
"""

from __future__ import annotations

import re

from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    TYPE_IDS,
    BadDefinition,
    FieldForm,
    FieldType,
    MessageField,
    PartDefinition,
)

__all__ = ["message_in", "messages_in_bundle", "parts_in"]

# Between the types of a bundle, as rosbag 2 and MCAP write it.
_RULE = re.compile(r"^={20,}\s*$", re.MULTILINE)
_TITLE = re.compile(r"\s*MSG:\s*(\S+)[ \t]*\n?")
_DIVIDER = re.compile(r"^---[ \t]*$", re.MULTILINE)
# Type, bound of a text, array; then the name, and what follows it.
_LINE = re.compile(
    r"(?P<base>[A-Za-z][A-Za-z0-9_/]*)(?:<=(?P<bound>\d+))?"
    r"(?P<array>\[(?P<most><=)?(?P<count>\d+)?\])?"
    r"\s+(?P<name>[A-Za-z]\w*)\s*(?P<rest>.*)\Z"
)
# What ``.msg`` files may say, and ROS 1's words that some still have.
_WORDS = {
    "char": "uint8",
    "time": "builtin_interfaces/msg/Time",
    "duration": "builtin_interfaces/msg/Duration",
    "Header": "std_msgs/msg/Header",
}
# The parts of a service and of an action, in the order of their texts.
_PARTS = {"srv": ("_Request", "_Response"), "action": ("_Goal", "_Result", "_Feedback")}


def message_in(text: str, type_name: str) -> PartDefinition:
    """Read the text of one message.

    Args:
        text: as in a ``.msg`` file.
        type_name: ``package/msg/Name``; types without a package are of the same one.

    Raises:
        BadDefinition: a line is neither a field nor a constant.

    """
    package = type_name.split("/", 1)[0]
    fields: list[MessageField] = []
    constants: dict[str, int] = {}
    for number, line in enumerate(text.splitlines(), 1):
        said = _without_comment(line).strip()
        # Annotations of IDL.
        if not said or said.startswith("@"):
            continue
        match = _LINE.match(said)
        if match is None:
            problem = f"{said[:80]!r} is neither a field nor a constant"
            raise BadDefinition(f"{type_name}, line {number}: {problem}")
        rest = match["rest"]
        if rest.startswith("="):
            value = _whole_number(rest[1:].strip())
            # Texts and fractions name no states, and decode nothing.
            if value is not None:
                constants[match["name"]] = value
        else:
            # What follows the name is a default value, which says nothing of what is sent.
            fields.append(MessageField(match["name"], _type_of(match, package)))
    return PartDefinition(tuple(fields), constants, text)


def parts_in(text: str, type_name: str) -> dict[str, PartDefinition]:
    """Read a ``.msg``, ``.srv`` or ``.action`` text: its messages by their names.

    Of a service ``package/srv/Name`` they are ``…/Name_Request`` and ``…/Name_Response``.

    Raises:
        BadDefinition: see `message_in`; or it has too few parts.

    """
    endings = _PARTS.get(type_name.split("/")[1])
    if endings is None:
        return {type_name: message_in(text, type_name)}
    texts = _DIVIDER.split(text)
    if len(texts) != len(endings):
        raise BadDefinition(f"{type_name}: found {len(texts)} parts, expected {len(endings)}")
    return {
        f"{type_name}{ending}": message_in(part, f"{type_name}{ending}")
        for ending, part in zip(endings, texts, strict=True)
    }


def messages_in_bundle(text: str, type_name: str) -> dict[str, PartDefinition]:
    """Read a text with all types that it is made of, as MCAP and rosbag 2 have it.

    Raises:
        BadDefinition: see `message_in`.

    """
    own, *others = _RULE.split(text)
    title = _TITLE.match(own)
    found = {type_name: message_in(own[title.end() :] if title else own, type_name)}
    for other in others:
        title = _TITLE.match(other)
        if title is None:
            raise BadDefinition(f"{type_name}: a part has no line 'MSG: package/Name'")
        name = full_name(title[1])
        found.setdefault(name, message_in(other[title.end() :].lstrip("\n"), name))
    return found


def full_name(name: str, package: str = "") -> str:
    """Give ``package/msg/Name`` for ``package/Name``, or for ``Name`` of this package."""
    if name in _WORDS:
        return _WORDS[name]
    steps = name.split("/")
    if len(steps) == 1:
        return f"{package}/msg/{name}"
    return name if len(steps) > 2 else f"{steps[0]}/msg/{steps[1]}"


def _type_of(match: re.Match[str], package: str) -> FieldType:
    word = _WORDS.get(match["base"], match["base"])
    base = word if word in TYPE_IDS else full_name(word, package)
    count = int(match["count"] or 0)
    form = FieldForm.ONE
    if match["array"]:
        form = FieldForm.SEQUENCE
        if match["count"]:
            form = FieldForm.BOUNDED if match["most"] else FieldForm.ARRAY
    return FieldType(base, form, count, int(match["bound"] or 0))


def _without_comment(line: str) -> str:
    """Cut the comment off, which may stand in quotes as part of a text."""
    quote = ""
    for at, letter in enumerate(line):
        if quote:
            if letter == quote and line[at - 1] != "\\":
                quote = ""
        elif letter in "\"'":
            quote = letter
        elif letter == "#":
            return line[:at]
    # A quote that nothing ends is an apostrophe of a comment or of a text.
    return line.split("#", 1)[0] if quote else line


def _whole_number(text: str) -> int | None:
    if text.lower() in ("true", "false"):
        return int(text.lower() == "true")
    try:
        return int(text, 0)
    except ValueError:
        pass
    try:
        # With leading zeros, which Python does not take for a number of its own.
        return int(text)
    except ValueError:
        return None
