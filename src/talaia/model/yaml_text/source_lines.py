"""From the path of a mistake (``$.devices.base.name``) to the line of the text. Pure."""

from __future__ import annotations

import re
from typing import NamedTuple

import yaml

__all__ = ["SourcePosition", "SourcePositions"]

# As YAML's own errors say where.
_LINE = re.compile(r"line (\d+)(?:, column (\d+))?")
_STEP = re.compile(r"\.([^.\[]+)|\[(\d+)\]")


class SourcePosition(NamedTuple):
    """A line and a column of a text, from 1; 0 where it is not known."""

    line: int = 0
    column: int = 0


class SourcePositions:
    """Knows where each part of a YAML text stands."""

    def __init__(self, text: str) -> None:
        """Read the text; one that is not YAML has no places but those that errors name."""
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
        try:
            self._root: yaml.Node | None = yaml.compose(text, Loader=loader)
        # Without a tree there are the lines that its errors name.
        except (yaml.YAMLError, ValueError, RecursionError):
            self._root = None

    def position_of(self, where: str) -> SourcePosition:
        """Give the place of a path; of what is not there, that of what it would stand in."""
        said = _LINE.search(where)
        if said is not None and "$" not in where:
            return SourcePosition(int(said[1]), int(said[2] or 1))
        node, mark = self._root, None
        if "$" not in where:
            return SourcePosition()
        if node is None:
            # The whole of it begins in its first line, be it empty.
            return SourcePosition(1, 1) if where == "$" else SourcePosition()
        for key, index in _STEP.findall(where[where.index("$") + 1 :]):
            found = _step_into(node, key, index)
            if found is None:
                break
            at, node = found
            mark = at.start_mark
        if mark is None:
            return SourcePosition(1, 1)
        return SourcePosition(mark.line + 1, mark.column + 1)


def _step_into(node: yaml.Node, key: str, index: str) -> tuple[yaml.Node, yaml.Node] | None:
    """Give what names a part, and the part."""
    if isinstance(node, yaml.MappingNode):
        for name, value in node.value:
            if isinstance(name, yaml.ScalarNode) and key in (name.value, _truth_of(name)):
                return name, value
    elif isinstance(node, yaml.SequenceNode) and index and int(index) < len(node.value):
        part = node.value[int(index)]
        return part, part
    return None


def _truth_of(name: yaml.ScalarNode) -> str:
    """Give what a key such as ``on`` is read as; empty for any other."""
    if name.tag != "tag:yaml.org,2002:bool":
        return ""
    # As it is told: ``on`` stands in the text, and true in the path.
    return "true" if name.value.lower() in {"true", "yes", "on"} else "false"
