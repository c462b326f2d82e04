"""JSON of others, read no deeper than anything here has a use for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["MOST_LEVELS", "check_depth", "decode_nested"]

# Lists and objects within each other. Messages of robots have a dozen; what reads them afterwards
# calls itself for each level, and the interpreter ends that at about a thousand calls.
MOST_LEVELS = 64


def decode_nested(data: bytes | str) -> object:
    """Read JSON.

    Raises:
        ValueError: it is none, or over `MOST_LEVELS` deep.

    """
    try:
        read: object = msgspec.json.decode(data)
    except RecursionError as error:
        raise ValueError(f"nested deeper than {MOST_LEVELS} levels") from error
    except UnicodeError as error:
        raise ValueError(f"not UTF-8 text: {str(error)[:200]}") from error
    check_depth(data, read)
    return read


def check_depth(data: bytes | str, read: object) -> None:
    """Hold what was read of ``data`` to `MOST_LEVELS`.

    Raises:
        ValueError: it is deeper.

    """
    # Nearly all messages open fewer brackets altogether, which takes no time to see.
    opened = (
        data.count("{") + data.count("[")
        if isinstance(data, str)
        else data.count(b"{") + data.count(b"[")
    )
    if opened <= MOST_LEVELS:
        return
    # Level by level, and not by a call for each: the depth is what is not known.
    level = [read]
    # Each turn goes one level down; what is left then lies deeper than the bound.
    for _ in range(MOST_LEVELS):
        level = [
            inner
            for value in level
            for inner in _inside(value)
            if isinstance(inner, (dict, list)) or hasattr(inner, "__dict__")
        ]
        if not level:
            return
    raise ValueError(f"nested deeper than {MOST_LEVELS} levels")


def _inside(value: object) -> Iterable[object]:
    if isinstance(value, list):
        return value
    fields = value if isinstance(value, dict) else getattr(value, "__dict__", {})
    return fields.values()
