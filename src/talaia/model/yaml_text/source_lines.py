"""From the path of a mistake (``$.devices.base.name``) to the line of the text. Pure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

import yaml

from talaia.model.errors import NotReadable
from talaia.model.yaml_text.document import require_shallow

if TYPE_CHECKING:
    from collections.abc import Iterator

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
            require_shallow(text)
            self._root: yaml.Node | None = yaml.compose(text, Loader=loader)
        # Without a tree there are the lines that its errors name.
        except (NotReadable, yaml.YAMLError, ValueError, RecursionError):
            self._root = None

    def position_of(self, where: str) -> SourcePosition:
        """Give the place of a path; of what is not there, that of what it would stand in."""
        said = _LINE.search(where)
        if said is not None and "$" not in where:
            return SourcePosition(int(said[1]), int(said[2] or 1))
        if "$" not in where:
            return SourcePosition()
        if self._root is None:
            # The whole of it begins in its first line, be it empty.
            return SourcePosition(1, 1) if where == "$" else SourcePosition()
        steps = _STEP.findall(where[where.index("$") + 1 :])
        mark = _walk(self._root, steps).mark
        if mark is None:
            return SourcePosition(1, 1)
        return SourcePosition(mark.line + 1, mark.column + 1)


class _Reached(NamedTuple):
    """How many steps of a path there were, and where the last of them stands."""

    steps: int
    mark: yaml.Mark | None


def _walk(node: yaml.Node, steps: list[tuple[str, str]]) -> _Reached:
    """Go as far as a path leads."""
    farthest = _Reached(0, None)
    for at, part in _parts_of(node, *steps[0]) if steps else ():
        reached = _walk(part, steps[1:])
        # A key that is written twice: the part is in one of the two.
        if reached.steps + 1 > farthest.steps:
            farthest = _Reached(reached.steps + 1, reached.mark or at.start_mark)
    return farthest


def _parts_of(node: yaml.Node, key: str, index: str) -> Iterator[tuple[yaml.Node, yaml.Node]]:
    """Give what names a part, and the part."""
    if isinstance(node, yaml.MappingNode):
        for name, value in node.value:
            if isinstance(name, yaml.ScalarNode) and key in _said_as(name):
                yield name, value
    elif isinstance(node, yaml.SequenceNode) and index and int(index) < len(node.value):
        part = node.value[int(index)]
        yield part, part


def _said_as(name: yaml.ScalarNode) -> tuple[str, ...]:
    """Give what a step of a path may be for a key: of one with a point, the part before it."""
    # Nothing below such a key is found, and it is the key itself that is wrong.
    return name.value, _truth_of(name), _number_of(name), name.value.partition(".")[0]


def _number_of(name: yaml.ScalarNode) -> str:
    """Give the whole part of what a key such as ``1e3`` is read as; empty for any other."""
    try:
        return str(float(name.value)).partition(".")[0] if name.value[:1].isdigit() else ""
    except ValueError:
        return ""


def _truth_of(name: yaml.ScalarNode) -> str:
    """Give what a key such as ``on`` is read as; empty for any other."""
    if name.tag != "tag:yaml.org,2002:bool":
        return ""
    # As it is told: ``on`` stands in the text, and true in the path.
    return "true" if name.value.lower() in {"true", "yes", "on"} else "false"
