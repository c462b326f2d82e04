"""Finds what still holds an object: the path of attributes from a root to it."""

from __future__ import annotations

import gc
from collections import deque
from types import BuiltinFunctionType, FunctionType, MethodType, ModuleType
from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterable

_PLAIN = (str, bytes, int, float, bool, type, ModuleType)


def paths_to(root: object, wanted: Iterable[object]) -> list[str]:
    """Give, for each of ``wanted`` that ``root`` still holds, how it is reached."""
    names = {id(each): type(each).__name__ for each in wanted}
    reached_by: dict[int, tuple[object, object]] = {id(root): (root, None)}
    queue: deque[object] = deque([root])
    found = []
    while queue:
        holder = queue.popleft()
        for held in _referents(holder):
            if isinstance(held, _PLAIN) or id(held) in reached_by:
                continue
            reached_by[id(held)] = (held, holder)
            if id(held) in names:
                found.append(_path(held, reached_by))
            else:
                queue.append(held)
    return found


def replaced_structs(before: object, after: object) -> list[object]:
    """Give the structs of one description that the other has not."""
    kept = _structs_of(after)
    return [each for each in _structs_of(before) if each not in kept]


def _structs_of(value: object) -> list[object]:
    if isinstance(value, msgspec.Struct):
        fields = [getattr(value, name) for name in value.__struct_fields__]
        return [value, *(each for field in fields for each in _structs_of(field))]
    if isinstance(value, dict):
        return [each for item in value.values() for each in _structs_of(item)]
    if isinstance(value, list | tuple):
        return [each for item in value for each in _structs_of(item)]
    return []


def _referents(holder: object) -> list[object]:
    if isinstance(holder, FunctionType):
        # Not its globals: they hold every module.
        return [*(holder.__closure__ or ()), *(holder.__defaults__ or ())]
    if isinstance(holder, MethodType):
        return [holder.__self__, holder.__func__]
    if isinstance(holder, BuiltinFunctionType):
        return [holder.__self__]
    if type(holder).__module__.startswith(("talaia", "builtins", "functools", "collections")):
        return gc.get_referents(holder)
    return []


def _path(held: object, reached_by: dict[int, tuple[object, object]]) -> str:
    steps = []
    at: object = held
    while at is not None:
        steps.append(type(at).__name__)
        at = reached_by[id(at)][1]
    return " < ".join(steps)
