"""Lists of Ekos' scheduler (``.esl``, XML), read as requests.

What is taken stands in another file (``.esq``), whose path says nothing here: it is taken from the
defaults, as the form has them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.parsers import expat

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
from talaia.model.observing.requests import GroupOperator, RequestGroup, Window
from talaia.model.observing.targets import IcrsTarget

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.hub.request_files.imported import ImportDefaults
    from talaia.model.observing.requests import Constraints, Request

__all__ = ["read_ekos"]

_ROOT = "SchedulerList"
_MOST = 1000
_HALF_TURN = 180.0


class _Job:
    """One job of a list: texts of its elements by their path, and values of its constraints."""

    def __init__(self, line: int) -> None:
        self.line = line
        self.texts: dict[str, str] = {}
        self.constraints: dict[str, str] = {}
        self.start = self.end = ""
        self.steps: set[str] = set()


class _Listener:
    """Collects jobs while expat reads. It knows no entities: a document type is refused."""

    def __init__(self) -> None:
        self.jobs: list[_Job] = []
        self._path: list[str] = []
        self._value = ""
        self._text = ""
        self._parser = expat.ParserCreate()
        self._parser.StartElementHandler = self._begin
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._add_text
        self._parser.StartDoctypeDeclHandler = self._refuse

    def read(self, text: str) -> None:
        self._parser.Parse(text.lstrip("\ufeff"), True)  # noqa: FBT003 - expat's own: it is the end

    def _refuse(self, *_declared: object) -> None:
        raise Misread(f"line {self._parser.CurrentLineNumber}", "a document type is not read")

    def _begin(self, name: str, attributes: Mapping[str, str]) -> None:
        if not self._path and name != _ROOT:
            raise Misread("line 1", f"expected <{_ROOT}>, found <{name[:40]}>")
        self._path.append(name)
        if self._path == [_ROOT, "Job"]:
            self.jobs.append(_Job(self._parser.CurrentLineNumber))
        self._value, self._text = attributes.get("value", ""), ""

    def _add_text(self, text: str) -> None:
        self._text += text

    def _end(self, _name: str) -> None:
        inside = self._path[2:]
        self._path.pop()
        if not self.jobs or not inside or self._path[:2] != [_ROOT, "Job"]:
            return
        job, said = self.jobs[-1], self._text.strip()
        if inside == ["Constraints", "Constraint"]:
            job.constraints[said] = self._value
        elif inside == ["StartupCondition", "Condition"] and said == "At":
            job.start = self._value
        elif inside == ["CompletionCondition", "Condition"] and said == "At":
            job.end = self._value
        elif inside == ["Steps", "Step"]:
            job.steps.add(said)
        else:
            job.texts["/".join(inside)] = said
        self._text = ""


def read_ekos(text: str, defaults: ImportDefaults) -> ImportedGroups:
    """Read a list; each job that cannot be read is a problem of its own."""
    listener = _Listener()
    problems: list[FileProblem] = []
    try:
        listener.read(text)
    except Misread as error:
        return ImportedGroups([], [FileProblem(error.where, error.message)])
    # A lone surrogate cannot be encoded.
    except (expat.ExpatError, UnicodeEncodeError) as error:
        line = getattr(error, "lineno", 1)
        return ImportedGroups([], [FileProblem(f"line {line}", f"this is no XML: {error}"[:300])])
    requests: list[Request] = []
    for job in listener.jobs[:_MOST]:
        try:
            requests.append(_read_job(job, defaults))
        except Misread as error:
            problems.append(FileProblem(error.where, error.message))
    if len(listener.jobs) > _MOST:
        line = listener.jobs[_MOST].line
        problems.append(FileProblem(f"line {line}", f"a file holds at most {_MOST} jobs"))
    if not requests:
        return ImportedGroups([], problems or [FileProblem("line 1", "there is no <Job>")])
    operator = GroupOperator.SINGLE if len(requests) == 1 else GroupOperator.MANY
    group = RequestGroup(
        id=NEW, proposal=defaults.proposal, operator=operator, requests=tuple(requests)
    )
    return ImportedGroups([group], problems)


def _read_job(job: _Job, defaults: ImportDefaults) -> Request:
    where = f"line {job.line}"
    # Hours, and degrees.
    hours = read_number(f"{where}, J2000RA", job.texts.get("Coordinates/J2000RA"))
    degrees = read_number(f"{where}, J2000DE", job.texts.get("Coordinates/J2000DE"))
    if not 0.0 <= hours < 24.0:
        raise Misread(f"{where}, J2000RA", f"expected 0 to 24 h, found {hours:g}")
    return make_request(
        where,
        IcrsTarget(
            name=job.texts.get("Name", "")[:100],
            ra=hours * 15.0,
            dec=degrees,
            position_angle=_read_angle(where, job),
        ),
        configurations=defaults.configurations,
        constraints=_constraints(where, job, defaults.constraints),
        windows=(_read_window(where, job, defaults),),
    )


def _read_window(where: str, job: _Job, defaults: ImportDefaults) -> Window:
    """Give when a job may run; Ekos writes the local time of its observatory, without a zone."""
    window, zone = defaults.window, defaults.zone
    if job.start:
        start = read_moment(f"{where}, StartupCondition", job.start, zone)
        if start >= window.end:
            raise Misread(f"{where}, StartupCondition", "it begins after the window's end")
        window = Window(start=max(start, window.start), end=window.end)
    if job.end:
        end = read_moment(f"{where}, CompletionCondition", job.end, zone)
        if end <= window.start:
            raise Misread(f"{where}, CompletionCondition", "it ends before the window's begin")
        window = Window(start=window.start, end=min(end, window.end))
    return window


def _read_angle(where: str, job: _Job) -> float | None:
    """Give the angle of a job; below -180°, or without the step that aligns, Ekos turns nothing."""
    said = job.texts.get("PositionAngle") if "Align" in job.steps else None
    angle = read_angle(f"{where}, PositionAngle", said)
    # As `read_angle` folds it: below -180° is -181°.
    return None if angle is None or read_number(where, said) < -_HALF_TURN else angle


def _constraints(where: str, job: _Job, before: Constraints) -> Constraints:
    named = {"MinimumAltitude": "min_altitude", "MoonSeparation": "min_moon_distance"}
    changed = {
        ours: read_number(f"{where}, {theirs}", job.constraints[theirs])
        for theirs, ours in named.items()
        if job.constraints.get(theirs)
    }
    return msgspec.structs.replace(before, **changed)
