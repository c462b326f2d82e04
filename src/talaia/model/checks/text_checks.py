"""All mistakes of a description's text in one run, each with its line, as a compiler tells them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

from talaia.model.boards.board_checks import board_notes, tile_type_findings
from talaia.model.checks.connection_checks import NO_CONNECTION
from talaia.model.checks.extension_rules import NO_RULES
from talaia.model.checks.identifiers import finding_of
from talaia.model.checks.ros_types.ros_type_checks import ros_type_findings
from talaia.model.checks.site_checks import check_site
from talaia.model.checks.unit_checks import unit_notes
from talaia.model.errors import DescriptionError
from talaia.model.yaml_text.document import read_on
from talaia.model.yaml_text.load import mapping_in, require_own_keys, require_short
from talaia.model.yaml_text.shape_errors import list_shape_errors
from talaia.model.yaml_text.source_lines import SourcePositions
from talaia.model.yaml_text.version import FORMAT, require_current

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from talaia.model.checks.extension_rules import ExtensionRules
    from talaia.model.checks.identifiers import Finding
    from talaia.model.checks.ros_types.field_walk import KnownTypes
    from talaia.model.site import Site

__all__ = ["Mistake", "TextReport", "check_text", "place_findings"]


class Mistake(NamedTuple):
    """One mistake and where it stands.

    Attributes:
        where: its path, ``$.devices.base.name``.
        line, column: of the text, from 1; 0 where that is not known.
        problem: what is wrong; ``remedy``: what to do, or nothing.

    """

    where: str
    line: int
    column: int
    problem: str
    remedy: str


class TextReport(NamedTuple):
    """What a check found.

    Attributes:
        mistakes: in the order of the text.
        site: the description; None if it has mistakes.
        notes: what is worth a word and is no mistake.

    """

    mistakes: list[Mistake]
    site: Site | None
    notes: list[Mistake]


def check_text(
    text: str,
    rules: ExtensionRules = NO_RULES,
    complete: Callable[[Site], Site] = lambda site: site,
    known: KnownTypes | None = None,
) -> TextReport:
    """Check a description's text: its shape, and what does not fit together. See `load_site`.

    Args:
        text: of the description.
        rules: what extensions that are installed here ask for.
        complete: takes in what the description names beside it, or raises `DescriptionError`.
        known: what knows types of ROS; none: they are not looked for.

    """
    errors: list[DescriptionError] = []
    try:
        require_short(text)
        read = read_on(text)
        errors += read.errors
        if not read.is_whole:
            return _only(errors, text)
        # Its parts stand where they stand in the text, as far as lines go.
        text = read.text
        document = mapping_in(read.document)
        require_own_keys(document)
        try:
            require_current(document.get("talaia"))
        except DescriptionError as error:
            # Of another format nothing can be said; one that is not named is most likely this one.
            if type(document.get("talaia")) is int:
                raise
            errors.append(error)
            document["talaia"] = FORMAT
    except DescriptionError as error:
        return _only([*errors, error], text)
    of_shape, site, renamed, follows = list_shape_errors(document)
    errors += of_shape
    notes: list[Finding] = []
    findings = [finding_of(error) for error in errors]
    if site is not None:
        try:
            site = complete(site)
        except DescriptionError as error:
            return TextReport(place_findings([*findings, finding_of(error)], text), None, [])
        # Of what is left, some is only there, or only missing, because of what was found before.
        wrong = [error.where for error in errors]
        # What refers to a device that is there twice is told once there is one of it.
        found = [] if read.is_joined else check_site(site, rules)
        notes += unit_notes(site)
        notes += board_notes(site)
        found += tile_type_findings(site)
        if known is not None:
            of_types = ros_type_findings(site, known)
            found += of_types.mistakes
            notes += of_types.notes
        findings += [finding for finding in found if not _follows(finding, wrong, follows)]
    findings = [_as_written(finding, renamed) for finding in _without_offers(findings)]
    placed = place_findings(_without_parts(findings), text)
    # Of a line that was read as it was most likely meant, what is told of the text is enough.
    mended = {mistake.line for mistake in placed if "$" not in mistake.where}
    placed = [one for one in placed if "$" not in one.where or one.line not in mended]
    return TextReport(placed, None if findings else site, place_findings(notes, text))


def _only(errors: list[DescriptionError], text: str) -> TextReport:
    return TextReport(place_findings(map(finding_of, errors), text), None, [])


def _without_parts(findings: list[Finding]) -> Iterator[Finding]:
    """Leave out what is said of the parts of something that has to be another thing as a whole."""
    wrong = [
        (f"{finding.where}.", f"{finding.where}[")
        for finding in findings
        if finding.problem.startswith("expected ") and ", found a " in finding.problem
    ]
    return (one for one in findings if not any(one.where.startswith(both) for both in wrong))


def _without_offers(findings: list[Finding]) -> Iterator[Finding]:
    """Leave out what offers a device whose own name is told as wrong."""
    wrong = [
        f"did you mean '{finding.where.rpartition('.')[2]}/"
        for finding in findings
        if finding.where.count(".") == 2 and finding.where.startswith("$.devices.")
    ]
    return (one for one in findings if not one.remedy.startswith(tuple(wrong)))


def _as_written(finding: Finding, renamed: dict[str, str]) -> Finding:
    """Give a finding with its path as it stands in the text, where keys were misspelt."""
    where = finding.where
    # The last first: the ones before it may be a part of its path.
    for meant, written in reversed(renamed.items()):
        if where == meant or where.startswith((f"{meant}.", f"{meant}[")):
            where = written + where[len(meant) :]
    return finding._replace(where=where)


def place_findings(findings: Iterable[Finding], text: str) -> list[Mistake]:
    """Find each in the text, and sort them by where they stand."""
    places = SourcePositions(text)
    placed = []
    for finding in findings:
        line, column = places.position_of(finding.where)
        placed.append(Mistake(finding.where, line, column, finding.problem, finding.remedy))
    return sorted(placed, key=lambda mistake: (mistake.line, mistake.column))


_WORD = re.compile(r"\w+")
# Of what is unsafe, each of these says all: where it is wrong, no signal is missing beside it.
_WHOLE_CONDITIONS = {"all", "link_lost", "sun"}
# What a device, or a part of one, is called by others.
_ADDRESSED = re.compile(
    r"\$\.devices(?:\.(?P<device>[^.]+)(?:\.(?:signals|streams|commands)(?:\.(?P<part>[^.]+))?)?)?\Z"
)


def _follows(finding: Finding, wrong: list[str], follows: list[str]) -> bool:
    """Tell whether a finding is only of what was taken out, or put there, for an earlier one."""
    # Beside a kind that was put there for one that nobody knows.
    if finding.where.startswith(tuple(follows)):
        return True
    # It asks for, or speaks of, what stands beside it and was taken out.
    said = set(_WORD.findall(f"{finding.problem} {finding.remedy}"))
    for where in wrong:
        above, _, key = where.rpartition(".")
        beside = finding.where in (above, f"{above}.{finding.where.rpartition('.')[2]}")
        if beside and (key in said or key in _WHOLE_CONDITIONS):
            return True
    return any(
        finding.where.startswith(where)
        # It asks for something that is there, but is wrong.
        or repr(where.rpartition(".")[2]) in finding.problem
        or (where.startswith(("$.connections", "$.ros2")) and NO_CONNECTION in finding.problem)
        or _is_about(finding.problem, where)
        for where in wrong
    )


def _is_about(problem: str, where: str) -> bool:
    """Tell whether a problem names what stood at ``where``, or a part of it, by its address."""
    # Of ``$.devices`` alone every address is a part.
    found = _ADDRESSED.match(where)
    if found is None:
        return False
    return (
        f"'{found['device'] or ''}{'/' if found['device'] else ''}{found['part'] or ''}" in problem
    )
