"""The text of CloudConnect's ``/metric`` topic. Pure.

One topic carries all sensors as ``{'name': 'speed1', 'magnitude': 1.4}``. Nodes in the field
write it with Python's quotes (``str`` of a dictionary) or with JSON's.
"""

from __future__ import annotations

import ast
import json
from typing import NamedTuple

from talaia.gateway.errors import FieldError

__all__ = ["Metric", "parse_metric"]

# Checked before it is read: `literal_eval` of long nested text can exhaust the stack.
MAX_TEXT = 4096


class Metric(NamedTuple):
    """One reading: a sensor's name with its number (``speed1``), and the value."""

    name: str
    magnitude: float


def parse_metric(text: str) -> Metric:
    """Read one message. A truth counts as 0 or 1, a number in quotes as that number.

    Raises:
        FieldError: not a dictionary with a name and a number.

    """
    if len(text) > MAX_TEXT:
        raise FieldError("data", f"a text of {len(text)} characters; at most {MAX_TEXT}")
    found = _read_text(text)
    if not isinstance(found, dict):
        raise FieldError("data", f"expected {{'name': …, 'magnitude': …}}, found {text[:60]!r}")
    name, magnitude = found.get("name"), found.get("magnitude")
    if not isinstance(name, str) or not name.strip():
        raise FieldError("data", f"there is no name in {text[:60]!r}")
    # A truth is an int in Python, so it is in this list.
    if not isinstance(magnitude, int | float | str):
        raise FieldError("data", f"the magnitude of {name[:40]!r} is no number")
    try:
        # Also a number in quotes; what NaN or an infinite one means is for the signal to judge.
        return Metric(name.strip(), float(magnitude))
    except (ValueError, OverflowError):
        raise FieldError("data", f"the magnitude of {name[:40]!r} is no number") from None


def _read_text(text: str) -> object:
    # JSON first: it knows true, false and NaN, and it is what most newer nodes write.
    try:
        return json.loads(text)
    # Not JSON; as Python wrote it, then.
    except (ValueError, RecursionError):
        pass
    try:
        # Literals only: names and calls are refused, so nothing of it is run.
        return ast.literal_eval(text.strip())
    except (ValueError, SyntaxError, TypeError, MemoryError, RecursionError):
        return None
