"""All mistakes of a description's text in one run, each with its line, as a compiler tells them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.model.checks.extension_rules import NO_RULES
from talaia.model.checks.identifiers import finding_of
from talaia.model.checks.ros_type_checks import ros_type_findings
from talaia.model.checks.site_checks import check_site
from talaia.model.checks.unit_checks import unit_notes
from talaia.model.errors import DescriptionError
from talaia.model.yaml_text.load import plain_of_text
from talaia.model.yaml_text.shape_errors import list_shape_errors
from talaia.model.yaml_text.source_lines import SourcePositions

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from talaia.model.checks.extension_rules import ExtensionRules
    from talaia.model.checks.identifiers import Finding
    from talaia.model.checks.ros_type_checks import KnownTypes
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
    try:
        errors, site = list_shape_errors(plain_of_text(text))
    except DescriptionError as error:
        return TextReport(place_findings([finding_of(error)], text), None, [])
    notes: list[Finding] = []
    findings = [finding_of(error) for error in errors]
    if site is not None:
        try:
            site = complete(site)
        except DescriptionError as error:
            return TextReport(place_findings([*findings, finding_of(error)], text), None, [])
        # Of what is left, some is only there, or only missing, because of what was found before.
        wrong = [error.where for error in errors]
        found = check_site(site, rules)
        notes += unit_notes(site)
        if known is not None:
            of_types = ros_type_findings(site, known)
            found += of_types.mistakes
            notes += of_types.notes
        findings += [finding for finding in found if not _follows(finding, wrong)]
    return TextReport(
        place_findings(findings, text), None if findings else site, place_findings(notes, text)
    )


def place_findings(findings: Iterable[Finding], text: str) -> list[Mistake]:
    """Find each in the text, and sort them by where they stand."""
    places = SourcePositions(text)
    placed = []
    for finding in findings:
        line, column = places.position_of(finding.where)
        placed.append(Mistake(finding.where, line, column, finding.problem, finding.remedy))
    return sorted(placed, key=lambda mistake: (mistake.line, mistake.column))


def _follows(finding: Finding, wrong: list[str]) -> bool:
    """Tell whether a finding is only of what was taken out, or put there, for an earlier one."""
    return any(
        finding.where.startswith(where)
        # It asks for something that is there, but is wrong.
        or repr(where.rpartition(".")[2]) in finding.problem
        for where in wrong
    )
