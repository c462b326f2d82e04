"""What founding clients say and how they spell it. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = [
    "STOP_WORD",
    "ClientWishes",
    "read_control",
    "read_wishes",
]

STOP_WORD = "stop"
_KEYS = frozenset("wxads")
# A text is packed at the most so: in a list, of a ``std_msgs/String``.
_DEEPEST = 3
_LONGEST_WISH = 200


class ClientWishes(NamedTuple):
    """What a client says in its address of how it wants to be told; all may be left out.

    Attributes:
        event: name of the events that it is sent; empty: that of their namespace.
        pictures: ``base64`` or ``bytes``.
        camera: ``<device>/<stream>``; empty: the first that the account sees.
        vehicle: the device that is driven; empty: the only one that the account may drive.

    """

    event: str = ""
    pictures: str = "base64"
    camera: str = ""
    vehicle: str = ""


def read_wishes(query: Mapping[str, str]) -> ClientWishes | str:
    """Read the wishes of an address; or say what is wrong with them."""
    wishes = {name: query[name] for name in ClientWishes._fields if name in query}
    for name, value in wishes.items():
        if len(value) > _LONGEST_WISH:
            return f"{name}= has at most {_LONGEST_WISH} letters"
    read = ClientWishes(**wishes)
    if read.pictures not in {"base64", "bytes"}:
        return f"pictures= is base64 or bytes, not {read.pictures!r}"
    return read


def read_control(name: object, args: Sequence[object]) -> str:
    """Give the character of control or the word ``stop`` in an event; empty: neither is in it.

    Its name may be anything; without arguments the name itself may be the character.
    """
    said: object = args[0] if len(args) == 1 else name if not args else None
    for _ in range(_DEEPEST):
        match said:
            case [only]:
                said = only
            case {"data": only}:
                said = only
            case bytes():
                said = said[:10].decode("latin-1")
            case _:
                break
    if not args or isinstance(said, str):
        word = said.strip() if isinstance(said, str) else ""
        if word in _KEYS or word.lower() == STOP_WORD:
            return word.lower()
    return STOP_WORD if isinstance(name, str) and name.lower() == STOP_WORD else ""
