"""Request groups as Las Cumbres' portal takes them (developers.lco.global), read as ours.

What has no meaning at one telescope (class, instrument type, acquisition) is passed over; what
would be observed otherwise than it was meant is a problem.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec

from talaia.hub.request_files.csv_list import read_moment
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
    Constraints,
    GroupOperator,
    Guiding,
    ImageType,
    RequestGroup,
    Urgency,
    Window,
)
from talaia.model.observing.targets import IcrsTarget

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from talaia.hub.request_files.imported import ImportDefaults
    from talaia.model.observing.requests import Request

__all__ = ["read_lco"]

_OPERATORS = {"SINGLE": GroupOperator.SINGLE, "MANY": GroupOperator.MANY, "AND": GroupOperator.MANY}
_TYPES = {
    "EXPOSE": ImageType.LIGHT,
    "STANDARD": ImageType.LIGHT,
    "SKY_FLAT": ImageType.SKY_FLAT,
    "DARK": ImageType.DARK,
    "BIAS": ImageType.BIAS,
}
# Nothing, or SKY with an angle from north through east.
_ROTATOR_MODES = frozenset({"", "SKY"})
# Our priority of a group whose intra-proposal priority is 1.
_PRIORITY = 10.0
_HOUR = 3600.0
_MOST = 1000

_Said = dict[str, Any]


def read_lco(text: str, defaults: ImportDefaults) -> ImportedGroups:
    """Read a request group, a list of them, or the answer of LCO's own list (``results``).

    Args:
        text: JSON.
        defaults: for what it leaves out; its proposal takes the place of theirs.

    """
    try:
        said = msgspec.json.decode(text.encode())
    # A lone surrogate cannot be encoded; nesting without end is refused by the decoder.
    except (msgspec.DecodeError, UnicodeEncodeError, RecursionError) as error:
        return ImportedGroups([], [FileProblem("$", f"this is no JSON: {error}"[:300])])
    # The portal answers in pages; people save that answer as it is.
    if isinstance(said, dict) and isinstance(said.get("results"), list):
        said = said["results"]
    groups: list[RequestGroup] = []
    problems: list[FileProblem] = []
    for at, one in enumerate(said if isinstance(said, list) else [said]):
        where = f"$[{at}]" if isinstance(said, list) else "$"
        try:
            groups.append(_read_group(where, one, defaults))
        # The others are read on, so that all problems are told at once.
        except Misread as error:
            problems.append(FileProblem(error.where, error.message))
    return ImportedGroups(groups, problems)


def _read_group(where: str, said: object, defaults: ImportDefaults) -> RequestGroup:
    group = _object(where, said)
    operator = str(group.get("operator", "SINGLE"))
    if operator not in _OPERATORS:
        raise Misread(f"{where}.operator", f"expected SINGLE or MANY, found {operator[:40]!r}")
    urgency = str(group.get("observation_type", "NORMAL"))
    if urgency not in Urgency.__members__:
        raise Misread(
            f"{where}.observation_type",
            f"expected {', '.join(Urgency.__members__)}, found {urgency[:40]!r}",
        )
    requests: list[Request] = []
    for at, one in enumerate(_list(f"{where}.requests", group.get("requests"))):
        requests += _read_requests(f"{where}.requests[{at}]", one, defaults)
    if len(requests) > _MOST:
        raise Misread(f"{where}.requests", f"expected at most {_MOST}, found {len(requests)}")
    single = len(requests) == 1
    priority = _PRIORITY * read_number(f"{where}.ipp_value", group.get("ipp_value", 1.0))
    return RequestGroup(
        id=NEW,
        proposal=defaults.proposal,
        name=str(group.get("name", ""))[:200],
        # Its cadence makes several of one.
        operator=_OPERATORS[operator] if single else GroupOperator.MANY,
        urgency=Urgency(urgency),
        priority=min(max(priority, 0.01), 1000.0),
        requests=tuple(requests),
    )


def _read_requests(where: str, said: object, defaults: ImportDefaults) -> Iterator[Request]:
    """Read a request; one with a cadence is as many as its visits."""
    request = _object(where, said)
    configurations = _list(f"{where}.configurations", request.get("configurations"))
    # LCO has a target in each configuration; here a request has one.
    first = _object(f"{where}.configurations[0]", configurations[0])
    target = _read_target(f"{where}.configurations[0].target", first.get("target"))
    constraints = _read_constraints(
        f"{where}.configurations[0].constraints", first.get("constraints"), defaults.constraints
    )
    taken: list[Configuration] = []
    for at, one in enumerate(configurations):
        inside = f"{where}.configurations[{at}]"
        configuration = _object(inside, one)
        if configuration.get("target") != first.get("target"):
            raise Misread(
                f"{inside}.target", "expected one target in a request; make a request for each"
            )
        if configuration.get("constraints") != first.get("constraints"):
            raise Misread(f"{inside}.constraints", "expected the same in all of a request")
        # One of theirs may have several settings of exposures; each is one of ours.
        taken += _read_configurations(inside, configuration)
    target = msgspec.structs.replace(target, position_angle=_read_angle(where, configurations))
    for windows in _read_windows(where, request, defaults):
        yield make_request(
            where,
            target,
            configurations=taken,
            constraints=constraints,
            windows=windows,
        )


def _read_target(where: str, said: object) -> IcrsTarget:
    target = _object(where, said)
    kind = str(target.get("type", "ICRS"))
    if kind != "ICRS":
        raise Misread(f"{where}.type", f"expected ICRS, found {kind[:40]!r}")
    return IcrsTarget(
        name=str(target.get("name", ""))[:100],
        ra=read_number(f"{where}.ra", target.get("ra")) % 360.0,
        dec=read_number(f"{where}.dec", target.get("dec")),
        proper_motion_ra=read_number(
            f"{where}.proper_motion_ra", target.get("proper_motion_ra") or 0.0
        ),
        proper_motion_dec=read_number(
            f"{where}.proper_motion_dec", target.get("proper_motion_dec") or 0.0
        ),
        epoch=read_number(f"{where}.epoch", target.get("epoch") or 2000.0),
    )


def _read_angle(where: str, configurations: list[Any]) -> float | None:
    """Give the angle on the sky that all settings of a request name; None: they leave it open.

    Of LCO's modes of a rotator only SKY is an angle on the sky. The others (parallactic, a slit's)
    would be observed otherwise than they were meant, so they are refused.
    """
    angles: dict[float | None, str] = {}
    for at, configuration in enumerate(configurations):
        for part_at, part in enumerate(configuration.get("instrument_configs") or ()):
            inside = f"{where}.configurations[{at}].instrument_configs[{part_at}]"
            said = _object(inside, part)
            mode = str(said.get("rotator_mode") or "")
            extra = _object(f"{inside}.extra_params", said.get("extra_params") or {})
            if mode not in _ROTATOR_MODES:
                raise Misread(
                    f"{inside}.rotator_mode", f"expected SKY or nothing, found {mode[:40]!r}"
                )
            angle = extra.get("rotator_angle") if mode else None
            read = read_angle(f"{inside}.extra_params.rotator_angle", angle)
            angles.setdefault(read, inside)
    if len(angles) > 1:
        raise Misread(
            list(angles.values())[1], "expected one angle in a request; make a request for each"
        )
    return next(iter(angles), None)


def _read_constraints(where: str, said: object, before: Constraints) -> Constraints:
    if said is None:
        return before
    named = {
        "max_airmass": "max_airmass",
        "min_lunar_distance": "min_moon_distance",
        "max_lunar_phase": "max_moon_illumination",
        "max_seeing": "max_seeing",
    }
    limits = _object(where, said)
    # What LCO leaves out stays as the person chose it for the import.
    changed = {
        ours: read_number(f"{where}.{theirs}", limits[theirs])
        for theirs, ours in named.items()
        if limits.get(theirs) is not None
    }
    return msgspec.structs.replace(before, **changed)


def _read_configurations(where: str, said: _Said) -> Iterator[Configuration]:
    kind = str(said.get("type", "EXPOSE"))
    if kind not in _TYPES:
        raise Misread(f"{where}.type", f"expected {', '.join(_TYPES)}, found {kind[:40]!r}")
    guiding = _object(f"{where}.guiding_config", said.get("guiding_config") or {})
    guided = Guiding.OFF
    # LCO guides where it can unless told that it must.
    if str(guiding.get("mode", "OFF")) != "OFF":
        guided = Guiding.OPTIONAL if guiding.get("optional", True) else Guiding.ON
    parts = _list(f"{where}.instrument_configs", said.get("instrument_configs"))
    for at, one in enumerate(parts):
        inside = f"{where}.instrument_configs[{at}]"
        part = _object(inside, one)
        optics = _object(f"{inside}.optical_elements", part.get("optical_elements") or {})
        extra = _object(f"{inside}.extra_params", part.get("extra_params") or {})
        # Bounds (positive, not too many) are checked with the whole request, as for one of the
        # form.
        count = read_number(f"{inside}.exposure_count", part.get("exposure_count", 1))
        binning = read_number(f"{inside}.extra_params.bin_x", extra.get("bin_x") or 1)
        yield Configuration(
            type=_TYPES[kind],
            filter=str(optics.get("filter") or "")[:40],
            exposure=read_number(f"{inside}.exposure_time", part.get("exposure_time")),
            count=int(count),
            binning=int(binning),
            guiding=guided,
        )


def _read_windows(
    where: str, request: Mapping[str, Any], defaults: ImportDefaults
) -> Iterator[list[Window]]:
    """Give the windows of each visit."""
    cadence = request.get("cadence")
    if cadence is not None:
        yield from _read_cadence(f"{where}.cadence", _object(f"{where}.cadence", cadence))
        return
    said = request.get("windows")
    if said is None:
        yield [defaults.window]
        return
    found = []
    for at, one in enumerate(_list(f"{where}.windows", said)):
        inside = f"{where}.windows[{at}]"
        window = _object(inside, one)
        start = read_moment(f"{inside}.start", str(window.get("start")))
        end = read_moment(f"{inside}.end", str(window.get("end")))
        if end <= start:
            raise Misread(inside, "it ends before it begins")
        found.append(Window(start=start, end=end))
    yield found


def _read_cadence(where: str, cadence: Mapping[str, Any]) -> Iterator[list[Window]]:
    """Give a window for each visit: ``period`` (h) apart, each ``jitter`` (h) long."""
    start = read_moment(f"{where}.start", str(cadence.get("start")))
    end = read_moment(f"{where}.end", str(cadence.get("end")))
    period = read_number(f"{where}.period", cadence.get("period")) * _HOUR
    jitter = read_number(f"{where}.jitter", cadence.get("jitter")) * _HOUR
    # Before the loop: a period of a millisecond would make windows till memory ends.
    if period <= 0 or jitter <= 0 or end <= start or (end - start) / period > _MOST:
        raise Misread(where, f"expected 1 to {_MOST} visits of some length")
    visits = 0
    while (middle := start + visits * period) <= end:
        yield [Window(start=max(start, middle - jitter / 2), end=middle + jitter / 2)]
        visits += 1


def _object(where: str, said: object) -> _Said:
    if not isinstance(said, dict):
        raise Misread(where, f"expected an object, found {_kind(said)}")
    return said


def _list(where: str, said: object) -> list[Any]:
    if not isinstance(said, list) or not said:
        found = "an empty list" if isinstance(said, list) else _kind(said)
        raise Misread(where, f"expected a list, found {found}")
    return said


def _kind(said: object) -> str:
    kinds = {dict: "an object", list: "a list", str: "a text", bool: "true or false"}
    return "nothing" if said is None else kinds.get(type(said), "a number")
