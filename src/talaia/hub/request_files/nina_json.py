"""Sequences of N.I.N.A.'s advanced sequencer (JSON), read as requests.

Each deep-sky container is a request: its target, and what its exposures take, as often as the loop
around them says. What else a sequence does (cooling, focusing, flips) the night does by itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec

from talaia.hub.request_files.imported import (
    NEW,
    FileProblem,
    ImportedGroups,
    Misread,
    make_request,
    read_angle,
    read_number,
)
from talaia.model.observing.requests import (
    Configuration,
    GroupOperator,
    ImageType,
    RequestGroup,
)
from talaia.model.observing.targets import IcrsTarget

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.hub.request_files.imported import ImportDefaults
    from talaia.model.observing.requests import Request

__all__ = ["read_nina"]

_TYPES = {
    "LIGHT": ImageType.LIGHT,
    "SNAPSHOT": ImageType.LIGHT,
    "FLAT": ImageType.SKY_FLAT,
    "DARK": ImageType.DARK,
    "DARKFLAT": ImageType.DARK,
    "BIAS": ImageType.BIAS,
}
# Instructions that turn a camera to the target's angle.
_TURNING = frozenset({"CenterAndRotate", "SolveAndRotate"})
# What several instructions have in common, and holds no instructions itself.
_SHARED = frozenset({"Filter", "Binning", "InputCoordinates"})
_MOST = 1000
# Containers inside containers; a sequence has a handful.
_DEEPEST = 60

_Said = dict[str, Any]


def read_nina(text: str, defaults: ImportDefaults) -> ImportedGroups:
    """Read a sequence or a target; each target that cannot be read is a problem of its own."""
    try:
        said = msgspec.json.decode(text.lstrip("\ufeff").encode())
    except (msgspec.DecodeError, UnicodeEncodeError, RecursionError) as error:
        return ImportedGroups([], [FileProblem("$", f"this is no JSON: {error}"[:300])])
    _put_references(said)
    requests: list[Request] = []
    problems: list[FileProblem] = []
    for where, container in _containers("$", said, 0):
        try:
            requests.append(_read_container(where, container, defaults))
        except Misread as error:
            problems.append(FileProblem(error.where, error.message))
        if len(requests) == _MOST:
            problems.append(FileProblem(where, f"a file holds at most {_MOST} targets"))
            break
    if not requests:
        nothing = FileProblem("$", "there is no target: expected a DeepSkyObjectContainer")
        return ImportedGroups([], problems or [nothing])
    operator = GroupOperator.SINGLE if len(requests) == 1 else GroupOperator.MANY
    name = str(said.get("Name") or "")[:200] if isinstance(said, dict) else ""
    group = RequestGroup(
        id=NEW, proposal=defaults.proposal, name=name, operator=operator, requests=tuple(requests)
    )
    return ImportedGroups([group], problems)


def _put_references(said: object) -> None:
    """Put what is only referred to in its place: a filter that is used twice is written once.

    N.I.N.A. writes each object with its ``$id`` where it first stands, and ``{"$ref": ID}`` from
    then on. Only plain values are put in: a child refers to its parent, too, which has no end.
    """
    known: dict[str, _Said] = {}
    referring: list[tuple[_Said, str]] = []
    waiting: list[object] = [said]
    while waiting:
        one = waiting.pop()
        if isinstance(one, list):
            waiting += one
        elif isinstance(one, dict):
            waiting += one.values()
            known[str(one.get("$id"))] = one
            shared = [name for name in _SHARED & one.keys() if isinstance(one[name], dict)]
            referring += [(one, name) for name in shared if "$ref" in one[name]]
    for one, name in referring:
        meant = known.get(str(one[name]["$ref"]), {})
        one[name] = {k: v for k, v in meant.items() if not isinstance(v, dict | list)}


def _containers(where: str, said: object, depth: int) -> Iterator[tuple[str, _Said]]:
    """Find what has a target, in order."""
    if depth > _DEEPEST:
        return
    if isinstance(said, dict):
        if isinstance(said.get("Target"), dict):
            yield where, said
            return
        for name, inside in said.items():
            if isinstance(inside, dict | list):
                yield from _containers(f"{where}.{name[:40]}", inside, depth + 1)
    elif isinstance(said, list):
        for at, inside in enumerate(said):
            yield from _containers(f"{where}[{at}]", inside, depth + 1)


def _read_container(where: str, said: _Said, defaults: ImportDefaults) -> Request:
    target = said["Target"]
    inside = f"{where}.Target.InputCoordinates"
    place = target.get("InputCoordinates")
    if not isinstance(place, dict):
        raise Misread(inside, "expected the coordinates of the target")
    hours = _sum_parts(inside, place, ("RAHours", "RAMinutes", "RASeconds"))
    degrees = _sum_parts(inside, place, ("DecDegrees", "DecMinutes", "DecSeconds"))
    # The sign stands beside: -00° 30′ would lose it.
    south = bool(place.get("NegativeDec")) or str(place.get("DecDegrees")).startswith("-")
    name = str(target.get("TargetName") or said.get("Name") or "")[:100]
    times = _loops(where, said)
    taken = tuple(_exposures(where, said.get("Items"), times=times, chosen="", depth=0))
    return make_request(
        where,
        IcrsTarget(
            name=name,
            ra=hours * 15.0 % 360.0,
            dec=-degrees if south else degrees,
            position_angle=_read_angle(where, said),
        ),
        configurations=taken or defaults.configurations,
        constraints=defaults.constraints,
        windows=(defaults.window,),
    )


def _read_angle(where: str, said: _Said) -> float | None:
    """Give the angle that a camera is turned to; None: the sequence turns none.

    Each target has an angle, of whatever the framing showed: it is meant where an instruction turns
    the camera to it.
    """
    if not any(kind in _TURNING for kind in _kinds(said.get("Items"), 0)):
        return None
    target = said["Target"]
    if "PositionAngle" in target:
        return read_angle(f"{where}.Target.PositionAngle", target["PositionAngle"])
    # As N.I.N.A. wrote it before version 3: from north through west.
    west = read_angle(f"{where}.Target.Rotation", target.get("Rotation"))
    return None if west is None else -west % 360.0


def _kinds(said: object, depth: int) -> Iterator[str]:
    """Name the instructions below here, without their namespaces."""
    for _, kind, item in _items(said, depth):
        yield kind
        yield from _kinds(item.get("Items"), depth + 1)


def _items(said: object, depth: int) -> Iterator[tuple[int, str, _Said]]:
    """Give each instruction of a list, with its place and its kind without namespaces."""
    items = said.get("$values", []) if isinstance(said, dict) else said
    if not isinstance(items, list) or depth > _DEEPEST:
        return
    for at, item in enumerate(items):
        if isinstance(item, dict):
            kind = str(item.get("$type", "")).partition(",")[0]
            yield at, kind.rpartition(".")[2], item


def _sum_parts(where: str, place: _Said, names: tuple[str, str, str]) -> float:
    parts = [abs(read_number(f"{where}.{name}", place.get(name, 0))) for name in names]
    return parts[0] + parts[1] / 60.0 + parts[2] / 3600.0


def _exposures(
    where: str, said: object, *, times: int, chosen: str, depth: int
) -> Iterator[Configuration]:
    """Read what is taken below here; ``chosen`` is the filter that was switched to last."""
    for at, kind, item in _items(said, depth):
        inside = f"{where}.Items[{at}]"
        if kind == "SwitchFilter" and isinstance(item.get("Filter"), dict):
            chosen = str(item["Filter"].get("_name") or item["Filter"].get("Name") or "")[:40]
        elif kind == "TakeExposure":
            yield _read_exposure(inside, item, times, chosen)
        elif "Items" in item:
            found = list(
                _exposures(
                    inside,
                    item["Items"],
                    times=times * _loops(inside, item),
                    chosen=chosen,
                    depth=depth + 1,
                )
            )
            chosen = found[-1].filter if found else chosen
            yield from found


def _loops(where: str, container: _Said) -> int:
    """Give how often a container is done; what ends by time or altitude counts once."""
    conditions = container.get("Conditions")
    listed = conditions.get("$values", []) if isinstance(conditions, dict) else conditions
    for one in listed if isinstance(listed, list) else []:
        if isinstance(one, dict) and "LoopCondition" in str(one.get("$type", "")):
            count = read_number(f"{where}.Conditions.Iterations", one.get("Iterations", 1))
            return max(1, min(10_000, int(count)))
    return 1


def _read_exposure(where: str, item: _Said, times: int, chosen: str) -> Configuration:
    kind = str(item.get("ImageType", "LIGHT")).upper()
    if kind not in _TYPES:
        raise Misread(f"{where}.ImageType", f"expected {', '.join(_TYPES)}, found {kind[:40]!r}")
    gain = read_number(f"{where}.Gain", item.get("Gain", -1))
    binning = item.get("Binning")
    across = binning.get("X", 1) if isinstance(binning, dict) else 1
    return Configuration(
        type=_TYPES[kind],
        filter=chosen,
        exposure=read_number(f"{where}.ExposureTime", item.get("ExposureTime")),
        count=min(10_000, times),
        binning=int(read_number(f"{where}.Binning.X", across)),
        # -1: as the camera is set.
        gain=gain if gain >= 0 else None,
    )
