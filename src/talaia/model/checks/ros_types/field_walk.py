"""The walk along a field's path through types of ROS, in each version of them that is known. Pure.

A type may be known in several versions: as it is installed, and as a robot described it. What any
of them has is right.
"""

from __future__ import annotations

import re
from difflib import get_close_matches
from typing import TYPE_CHECKING, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

__all__ = ["FieldEnd", "KnownTypes", "RosFieldShape", "field_ends", "list_names", "part_names"]

_INDEX = re.compile(r"\[(\d+)\]")
# Names in one remedy.
_MOST_NAMES = 8


class RosFieldShape(Protocol):
    """The type of a field; see `talaia.ros_type_library.FieldKind`."""

    @property
    def base(self) -> str:
        """Give what it is of: ``float64``, ``string``, or ``package/msg/Name``."""
        ...

    @property
    def many(self) -> bool:
        """Tell whether it is a list."""
        ...

    @property
    def length(self) -> int:
        """Give how long such a list always is; 0 where that is open."""
        ...


class KnownTypes(Protocol):
    """What knows types; see `talaia.ros_type_library.RosTypeLibrary`."""

    def versions_of(self, type_name: str, part: str = "") -> Iterable[Mapping[str, RosFieldShape]]:
        """Give the fields of each known version of a type, the installed one first."""
        ...

    def names_in(self, package: str, middle: str) -> list[str]:
        """List the types of a package."""
        ...

    def packages(self) -> list[str]:
        """List all packages."""
        ...


class FieldEnd(NamedTuple):
    """Where a path ends in one version of the types on its way.

    Attributes:
        owner: the type that has, or has not, the last step that was made.
        step: that step, as it is written: ``ranges[0]``.
        kind: what is there; none where the path goes wrong, or on into what nothing here knows.
        wrong: what is wrong and what to do, where the path goes wrong.

    """

    owner: str
    step: str
    kind: RosFieldShape | None = None
    wrong: tuple[str, str] | None = None

    @property
    def is_list(self) -> bool:
        """Tell whether it is a whole list, and not an element of one."""
        return self.kind is not None and self.kind.many and "[" not in self.step


def field_ends(
    known: KnownTypes, fields: Mapping[str, RosFieldShape], owner: str, steps: Sequence[str]
) -> Iterator[FieldEnd]:
    """Walk along a path; gives at least one end.

    Args:
        known: what knows the types on the way.
        fields: of the type in which it begins.
        owner: that type's name.
        steps: the path in its parts.

    """
    step = steps[0]
    name = step.partition("[")[0]
    kind = fields.get(name)
    if kind is None:
        yield FieldEnd(owner, step, wrong=_no_field(name, fields, owner))
    elif (wrong := _index_problem(kind, step)) is not None:
        yield FieldEnd(owner, step, wrong=(f"{name} of {owner} {wrong[0]}", wrong[1]))
    elif len(steps) == 1:
        yield FieldEnd(owner, step, kind)
    elif (wrong := _no_way_on(kind, step, owner, ".".join(steps[1:]))) is not None:
        yield FieldEnd(owner, step, wrong=wrong)
    else:
        end = None
        for version in known.versions_of(kind.base):
            for end in field_ends(known, version, kind.base, steps[1:]):
                yield end
        if end is None:
            yield FieldEnd(owner, step)


def part_names(known: KnownTypes, kind: RosFieldShape, step: str) -> list[str]:
    """Name the parts of what is more than one value; nothing where that is not known."""
    fields = next(iter(known.versions_of(kind.base)), {}) if "/" in kind.base else {}
    return [f"{step}.{name}" for name in fields]


def list_names(names: Iterable[str]) -> str:
    """List the first of some names."""
    listed = list(names)
    return ", ".join(listed[:_MOST_NAMES]) + (", …" if len(listed) > _MOST_NAMES else "")


def _no_field(name: str, fields: Mapping[str, RosFieldShape], owner: str) -> tuple[str, str]:
    near = get_close_matches(name, fields, n=1, cutoff=0.5)
    has = f"it has: {list_names(fields)}" if fields else "it has none: leave it out"
    return f"no field {name} in {owner}", f"did you mean {near[0]}?" if near else has


def _no_way_on(kind: RosFieldShape, step: str, owner: str, below: str) -> tuple[str, str] | None:
    name = step.partition("[")[0]
    if "/" not in kind.base:
        return f"{name} of {owner} is a {kind.base} and has no fields", f"leave out .{below}"
    if kind.many and "[" not in step:
        return f"{name} of {owner} is a list", f"write {name}[0].{below}"
    return None


def _index_problem(kind: RosFieldShape, step: str) -> tuple[str, str] | None:
    name, _, _ = step.partition("[")
    indices = [int(index) for index in _INDEX.findall(step)]
    if len(indices) > int(kind.many):
        return "is no list of lists" if kind.many else "is no list", f"write {name}"
    if indices and kind.length and indices[0] >= kind.length:
        return f"has {kind.length} elements", f"write {name}[0] to {name}[{kind.length - 1}]"
    return None
