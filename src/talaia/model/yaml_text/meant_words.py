"""Words that people bring from elsewhere, and what they are called in a description. Pure.

Likeness of letters finds a slip of the finger; it takes ``private`` for no word, and
``vehicle.velocity`` for ``vehicle.position``. What stands here goes first, where it is among the
words that fit.
"""

from __future__ import annotations

from difflib import SequenceMatcher, get_close_matches
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Collection

__all__ = ["list_words", "meant_word", "near_words", "quoted_text"]

# More are no help to who reads them.
_MOST_LISTED = 20
# What is less alike is another word: ``icon`` was no slip of ``twin``.
_LIKENESS = 0.62
# Words that several entries share.
_ABOVE, _BELOW = ("above",), ("below",)
_RATE, _LASTING, _HOST, _PERSON = ("max_rate",), ("lasting", "delay"), ("host", "url"), ("person",)
_LONGITUDE = ("longitude",)
_NUMBER, _TEXT, _WHOLE = ("number",), ("text",), ("integer", "number")
_MEANT: dict[str, tuple[str, ...]] = {
    # Signs and words of other languages for conditions.
    ">": _ABOVE,
    ">=": _ABOVE,
    "gt": _ABOVE,
    "greater": _ABOVE,
    "greater_than": _ABOVE,
    "more_than": _ABOVE,
    "<": _BELOW,
    "<=": _BELOW,
    "lt": _BELOW,
    "less": _BELOW,
    "less_than": _BELOW,
    "=": ("is",),
    "==": ("is",),
    "equals": ("is",),
    "state": ("is",),
    "!=": ("is_not",),
    "not": ("is_not",),
    # Types of programming languages and of messages.
    "bool": ("boolean", "state"),
    "boolean": ("state",),
    "switch": ("state",),
    "enum": ("state",),
    "float": _NUMBER,
    "float32": _NUMBER,
    "float64": _NUMBER,
    "double": _NUMBER,
    "int": _WHOLE,
    "int32": _WHOLE,
    "integer": _NUMBER,
    "str": _TEXT,
    "string": _TEXT,
    "gps": ("position",),
    "pose": ("position",),
    # Kinds of devices.
    "robot": ("vehicle",),
    "rover": ("vehicle",),
    "car": ("vehicle",),
    "mobile_base": ("vehicle",),
    "mount": ("telescope",),
    "roof": ("dome",),
    "battery": ("power",),
    # Who sees it, and how bad it is.
    "private": ("view",),
    "hidden": ("view",),
    "guest": ("public", "view"),
    "everyone": ("public", "view"),
    "viewer": ("view",),
    "operator": ("use",),
    "high": ("critical",),
    "low": ("info",),
    "error": ("critical",),
    "fatal": ("critical",),
    "threshold": ("limit",),
    "range": ("limit",),
    "timeout": ("stale",),
    "condition": ("expression",),
    **dict.fromkeys(("formula", "calculation", "compute", "template"), ("expression",)),
    **dict.fromkeys(("value_template", "lambda", "equation"), ("expression",)),
    # Keys, as other programs call them.
    "max": ("maximum",),
    "min": ("minimum",),
    "speed_limit": ("max_speed",),
    "velocity": ("max_speed",),
    "max_velocity": ("max_speed",),
    "max_linear": ("max_speed",),
    "max_angular": ("max_turn",),
    "max_rotation": ("max_turn",),
    "label": ("name",),
    "title": ("name",),
    "sensors": ("signals",),
    "actions": ("commands",),
    "services": ("commands",),
    "buttons": ("commands",),
    "cameras": ("streams",),
    "timezone": ("zone",),
    "time_zone": ("zone",),
    "tz": ("zone",),
    "location": ("place",),
    "altitude": ("elevation",),
    "alt": ("elevation", "altitude"),
    "lat": ("latitude",),
    "lon": _LONGITUDE,
    "lng": _LONGITUDE,
    "long": _LONGITUDE,
    "version": ("talaia",),
    "rules": ("interlocks",),
    "sensor": ("signal",),
    "entity": ("signal",),
    "message": ("advice",),
    "text": ("advice",),
    "notify": ("to",),
    "service": ("target",),
    "action": ("target",),
    "property": ("target",),
    "type": ("message",),
    "params": ("arguments",),
    "parameters": ("arguments",),
    "unit_of_measurement": ("unit",),
    "fps": _RATE,
    "framerate": _RATE,
    "frequency": _RATE,
    "rate": _RATE,
    "interval": ("poll",),
    "duration": _LASTING,
    "for": _LASTING,
    # Of a server.
    "ip": _HOST,
    "address": _HOST,
    "hostname": _HOST,
    "broker": _HOST,
    "server": _HOST,
    "uri": ("url",),
    "username": ("user",),
    "password": ("password_file",),
    "token": ("token_file",),
    # What a camera sees.
    "human": _PERSON,
    "people": _PERSON,
    "persons": _PERSON,
    "pedestrian": _PERSON,
    # Kinds of connections.
    "rosbridge_server": ("rosbridge",),
    "rtsp": ("video",),
    "ptz": ("onvif",),
    "ipcamera": ("onvif",),
    "camera": ("video",),
    "ascom": ("alpaca",),
    "ros": ("ros2",),
    "vehicle.velocity": ("vehicle.speed",),
    "weather.wind_speed": ("weather.wind",),
}


def meant_word(word: str, known: Collection[str], likeness: float = _LIKENESS) -> str:
    """Give the one of ``known`` that was most likely meant; empty for none."""
    # With other capitals: ``INDI``.
    for one in known:
        if one.casefold() == word.casefold():
            return one
    for meant in _MEANT.get(word.lower(), ()):
        if meant in known:
            return meant
    # Addresses: ``device/name``.
    if any("/" in one for one in known) and not word.startswith("/"):
        return _meant_address(word, known)
    near = get_close_matches(word, sorted(known), n=1, cutoff=likeness)
    return near[0] if near else ""


def _meant_address(word: str, known: Collection[str]) -> str:
    """Compare what stands behind the device: that alone tells ``dome/open`` from ``dome/close``."""
    device, _, name = word.rpartition("/")
    # Of the same device first, then of one that is called alike.
    for likeness in (1.0, 0.6) if device else (0.0,):
        some = {
            one.rpartition("/")[2]: one
            for one in sorted(known)
            if SequenceMatcher(None, device, one.rpartition("/")[0]).ratio() >= likeness
        }
        # Higher than for whole words: these are short, and a wrong command is dangerous.
        near = get_close_matches(name, sorted(some), n=1, cutoff=0.65)
        if near:
            return some[near[0]]
    # A device by another name, with a signal that only one has.
    same = [one for one in known if one.rpartition("/")[2] == name]
    return same[0] if len(same) == 1 else ""


def quoted_text(text: str) -> str:
    """Put a text in quotes as it stands; what is not seen in it is shown by its number."""
    if text.isprintable():
        return repr(text)
    shown = (letter if letter.isprintable() else f"<U+{ord(letter):04X}>" for letter in text)
    return f"'{''.join(shown)}'"


def near_words(word: str, known: Collection[str]) -> list[str]:
    """Give those of ``known`` that belong to the same device; all, if none does."""
    # A site has thousands of signals, a device a dozen.
    device = word.partition("/")[0]
    return [one for one in known if one.partition("/")[0] == device] or list(known)


def list_words(words: Collection[str]) -> str:
    """List words with commas, the first of many."""
    # In the order of the alphabet, so that the same mistake gives the same sentence.
    shown = sorted(words)
    if len(shown) <= _MOST_LISTED:
        return ", ".join(shown)
    return f"{', '.join(shown[:_MOST_LISTED])}, … ({len(shown)} in all)"
