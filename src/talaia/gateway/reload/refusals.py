"""Why a change of the description does not take place, in words and for the hub."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.model.checks.identifiers import finding_of
from talaia.model.checks.text_checks import Mistake, place_findings
from talaia.wire.frames import ChangePhase, ChangeState, DescriptionProblem

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.model.checks.identifiers import Finding
    from talaia.model.errors import DescriptionError

__all__ = ["ChangeRefused", "mistake_line", "refusal_of", "without_lines", "wrong_text"]

# The wire's bound; a person mends the first of them first.
MOST_PROBLEMS = 50


class ChangeRefused(NamedTuple):
    """Why a change does not take place."""

    message: str
    problems: tuple[Mistake, ...] = ()

    def change_state(self, change_id: str) -> ChangeState:
        """Give what the hub is told."""
        return ChangeState(
            id=change_id,
            phase=ChangePhase.REFUSED,
            message=self.message[:2000],
            problems=[
                DescriptionProblem(
                    where=problem.where[:2000],
                    problem=problem.problem[:2000],
                    remedy=problem.remedy[:2000],
                    line=problem.line,
                    column=problem.column,
                )
                for problem in self.problems[:MOST_PROBLEMS]
            ],
        )


def refusal_of(error: DescriptionError, text: str = "") -> ChangeRefused:
    """Make a refusal of a text that cannot be read as a description; empty where there is none."""
    return wrong_text([finding_of(error)], text)


def wrong_text(findings: Iterable[Finding], text: str) -> ChangeRefused:
    """Make a refusal of all that is wrong with a text, each with its line; reads the text."""
    placed = tuple(place_findings(findings, text))
    return ChangeRefused("the description cannot be used as written", placed)


def without_lines(findings: Iterable[Finding]) -> tuple[Mistake, ...]:
    """Give what is not about a text, but about what it would do."""
    return tuple(Mistake(one.where, 0, 0, one.problem, one.remedy) for one in findings)


def mistake_line(mistake: Mistake, file: str = "") -> str:
    """Say a mistake in one line: in a file with its line, else by its path."""
    where = f"{file}:{mistake.line}:{mistake.column}" if mistake.line and file else mistake.where
    return f"{where}: {mistake.problem}" + (f"; {mistake.remedy}" if mistake.remedy else "")
