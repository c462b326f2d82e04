"""A list of targets as a spreadsheet writes it: a head line of names, then one request a line."""

from __future__ import annotations

import csv
import datetime as dt
import io
from typing import TYPE_CHECKING

import msgspec

from talaia.hub.request_files.imported import (
    NEW,
    FileProblem,
    ImportedGroups,
    Misread,
    make_request,
    read_angle,
    read_declination,
    read_number,
    read_right_ascension,
)
from talaia.model.observing.requests import (
    Configuration,
    GroupOperator,
    RequestGroup,
    Window,
)
from talaia.model.observing.targets import IcrsTarget

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.hub.request_files.imported import ImportDefaults
    from talaia.model.observing.requests import Constraints, Request

__all__ = ["COLUMNS", "read_csv"]

COLUMNS = (
    "name",
    "ra",
    "dec",
    "filter",
    "exposure",
    "count",
    "binning",
    "min_altitude",
    "min_moon_distance",
    "start",
    "end",
    "position_angle",
)
_NEEDED = ("ra", "dec")
_MOST_LINES = 1000


def read_csv(text: str, defaults: ImportDefaults) -> ImportedGroups:
    """Read a list; each line that cannot be read is a problem of its own.

    Args:
        text: with a head line of some of `COLUMNS`, apart by commas, semicolons or tabs.
        defaults: for what a line leaves empty.

    """
    head = text.lstrip("\ufeff").splitlines()[:1]
    separator = max(",;\t", key=head[0].count) if head else ","
    rows = csv.reader(io.StringIO(text.lstrip("\ufeff"), newline=""), delimiter=separator)
    requests: list[Request] = []
    problems: list[FileProblem] = []
    try:
        names = [name.strip().lower() for name in next(rows, [])]
        _check_names(names)
        for cells in rows:
            if not any(cell.strip() for cell in cells):
                continue
            where = f"line {rows.line_num}"
            if len(requests) + len(problems) == _MOST_LINES:
                problems.append(FileProblem(where, f"a file holds at most {_MOST_LINES} requests"))
                break
            try:
                requests.append(_read_line(where, names, cells, defaults))
            except Misread as error:
                problems.append(FileProblem(error.where, error.message))
    except Misread as error:
        problems.append(FileProblem(error.where, error.message))
    # Of the reader itself: a quote that never ends, a NUL.
    except csv.Error as error:
        problems.append(FileProblem(f"line {rows.line_num}", str(error)))
    if not requests:
        return ImportedGroups([], problems or [FileProblem("line 2", "there is no request")])
    operator = GroupOperator.SINGLE if len(requests) == 1 else GroupOperator.MANY
    group = RequestGroup(
        id=NEW, proposal=defaults.proposal, operator=operator, requests=tuple(requests)
    )
    return ImportedGroups([group], problems)


def _check_names(names: list[str]) -> None:
    unknown = [name for name in names if name not in COLUMNS]
    if unknown:
        raise Misread(
            "line 1", f"there is no column {unknown[0][:40]!r}; expected {', '.join(COLUMNS)}"
        )
    missing = [name for name in _NEEDED if name not in names]
    if missing:
        raise Misread("line 1", f"the column {missing[0]!r} is missing")
    if len(set(names)) != len(names):
        raise Misread("line 1", "a column stands there twice")


def _read_line(where: str, names: list[str], cells: list[str], defaults: ImportDefaults) -> Request:
    if len(cells) > len(names):
        raise Misread(where, f"expected {len(names)} cells, found {len(cells)}")
    said = {name: cell.strip() for name, cell in zip(names, cells, strict=False) if cell.strip()}
    for name in _NEEDED:
        if name not in said:
            raise Misread(where, f"{name}: expected a coordinate, found nothing")
    target = IcrsTarget(
        name=said.get("name", "")[:100],
        ra=read_right_ascension(f"{where}, ra", said["ra"]),
        dec=read_declination(f"{where}, dec", said["dec"]),
        position_angle=read_angle(f"{where}, position_angle", said.get("position_angle")),
    )
    return make_request(
        where,
        target,
        configurations=_configurations(where, said, defaults),
        constraints=_constraints(where, said, defaults.constraints),
        windows=(_window(where, said, defaults.window),),
    )


def _configurations(
    where: str, said: Mapping[str, str], defaults: ImportDefaults
) -> tuple[Configuration, ...]:
    if not said.keys() & {"filter", "exposure", "count", "binning"}:
        return defaults.configurations
    before = defaults.configurations[0]
    changed: dict[str, float | int | str] = {}
    if "filter" in said:
        changed["filter"] = said["filter"]
    if "exposure" in said:
        changed["exposure"] = read_number(f"{where}, exposure", said["exposure"])
    for name in ("count", "binning"):
        if name in said:
            value = read_number(f"{where}, {name}", said[name])
            if value != int(value):
                raise Misread(f"{where}, {name}", f"expected a whole number, found {value:g}")
            changed[name] = int(value)
    return (msgspec.structs.replace(before, **changed),)


def _constraints(where: str, said: Mapping[str, str], before: Constraints) -> Constraints:
    changed = {
        name: read_number(f"{where}, {name}", said[name])
        for name in ("min_altitude", "min_moon_distance")
        if name in said
    }
    return msgspec.structs.replace(before, **changed)


def _window(where: str, said: Mapping[str, str], before: Window) -> Window:
    times = {"start": before.start, "end": before.end}
    for name in times.keys() & said.keys():
        times[name] = read_moment(f"{where}, {name}", said[name])
    if times["end"] <= times["start"]:
        raise Misread(where, "its window ends before it begins")
    return Window(**times)


def read_moment(where: str, text: str, zone: dt.tzinfo = dt.UTC) -> float:
    """Read a date and time (ISO 8601; without a zone: in ``zone``); gives s since the epoch.

    Raises:
        Misread: it is none.

    """
    try:
        moment = dt.datetime.fromisoformat(text.strip())
        if moment.tzinfo is None:
            moment = moment.replace(tzinfo=zone)
        return moment.timestamp()
    except (ValueError, OverflowError) as error:
        raise Misread(
            where, f"expected a date and time as 2026-12-04T21:30:00, found {text[:40]!r}"
        ) from error
