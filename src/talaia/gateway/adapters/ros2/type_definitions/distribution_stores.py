"""The definitions that `rosbags` brings for each ROS 2 distribution."""

from __future__ import annotations

import functools
import os
from typing import TYPE_CHECKING

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    FieldForm,
    FieldType,
    MessageField,
    PartDefinition,
    TypeDefinition,
    collect_parts,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosbags.interfaces.typing import FieldDesc
    from rosbags.typesys.store import Typestore

__all__ = ["DistributionDefinitions"]

# The newest first: where no hash tells, the newest is as good a guess as any.
_DISTRIBUTIONS = ("lyrical", "kilted", "jazzy", "iron", "humble", "galactic", "foxy")
_FILLER = "structure_needs_at_least_one_member"


class DistributionDefinitions:
    """A `DefinitionSource` of all distributions, that of ``ROS_DISTRO`` first."""

    def find(self, type_name: str) -> Iterable[TypeDefinition]:
        """Give each distribution's definition; distributions that are not needed stay unread."""
        own = os.environ.get("ROS_DISTRO", "")
        for name in sorted(_DISTRIBUTIONS, key=lambda name: name != own):
            store = _store(name)
            if store is None or type_name not in store.fielddefs:
                continue
            source = f"the definitions of ROS 2 {name.capitalize()}"
            parts = collect_parts(type_name, functools.partial(_read_part, store))
            yield TypeDefinition(type_name, parts, source).checked()


@functools.cache
def _store(distribution: str) -> Typestore | None:
    # A version of rosbags may not have it yet, or not any more.
    found = Stores.__members__.get(f"ROS2_{distribution.upper()}")
    return None if found is None else get_typestore(found)


def _read_part(store: Typestore, name: str) -> dict[str, PartDefinition]:
    if name not in store.fielddefs:
        return {}
    constants, fields = store.fielddefs[name]
    part = PartDefinition(
        tuple(MessageField(field, _type_of(desc)) for field, desc in fields if field != _FILLER),
        {
            constant: value
            for constant, _, value in constants
            if isinstance(value, int) and not isinstance(value, bool)
        },
    )
    return {name: part}


def _type_of(described: FieldDesc) -> FieldType:
    match described:
        case (Nodetype.BASE, (base, bound)):
            # A ``.msg`` file's char is an uint8, and rosbags keeps the file's word.
            return FieldType("uint8" if base == "char" else base, text_bound=bound)
        case (Nodetype.NAME, name):
            return FieldType(str(name))
        case (Nodetype.ARRAY, (inner, count)):
            return _type_of(inner)._replace(form=FieldForm.ARRAY, size=count)
        case (Nodetype.SEQUENCE, (inner, count)):
            form = FieldForm.BOUNDED if count else FieldForm.SEQUENCE
            return _type_of(inner)._replace(form=form, size=count)
    raise AssertionError(described)
