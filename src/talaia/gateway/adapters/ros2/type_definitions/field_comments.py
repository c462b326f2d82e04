"""What the authors of ROS messages wrote beside their fields, from the installed definitions."""

from __future__ import annotations

import functools
import re
from importlib import import_module
from pathlib import Path

__all__ = ["comment_of", "comments_in"]

_FIELD = re.compile(
    r"^\s*[\w/]+(?:<=\d+)?(?:\[[^\]]*\])?\s+(?P<name>[a-z]\w*)\b[^#=]*(?:#\s*(?P<said>.*))?$"
)


def comment_of(type_name: str, field: str) -> str:
    """Give the comment beside or just above a field of ``package/Name``; empty if there is none."""
    return _comments(type_name).get(field, "")


@functools.cache
def _comments(type_name: str) -> dict[str, str]:
    package, _, name = type_name.partition("/")
    text = _definition(package, name)
    return comments_in(text) if text else {}


def comments_in(text: str) -> dict[str, str]:
    """Read the comments of a ``.msg`` text, by field.

    A comment on the field's own line counts; else the line of comment directly above it.
    """
    found: dict[str, str] = {}
    above = ""
    for line in text.split("\n---", 1)[0].splitlines():
        stripped = line.strip()
        if stripped.startswith("#"):
            above = stripped.lstrip("# ")
            continue
        match = _FIELD.match(line)
        if match:
            found[match["name"]] = match["said"] or above
        above = ""
    return found


def _definition(package: str, name: str) -> str:
    """Find the definition as ROS installs it: ``scope/<package>/msg/<Name>.msg``."""
    try:
        where = import_module(package).__file__
    except ImportError:
        return ""
    folders = list(Path(where).resolve().parents)[:6] if where else []
    try:
        from ament_index_python.packages import get_package_share_directory

        folders.insert(0, Path(get_package_share_directory(package)))
    except Exception:  # noqa: BLE001, S110 - the index raises kinds of its own; the rest remains
        pass
    for folder in folders:
        for base in (folder, folder / "scope" / package, folder / "share" / package):
            try:
                return (base / "msg" / f"{name}.msg").read_text(errors="replace")
            except OSError:
                continue
    return ""
