"""Why a change of the description does not take place, in words and for the hub."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.model.checks.identifiers import Finding, finding_of
from talaia.wire.frames import ChangePhase, ChangeState, DescriptionProblem

if TYPE_CHECKING:
    from talaia.model.errors import DescriptionError

__all__ = ["ChangeRefused", "refusal_of"]

# The wire's bound; a person mends the first of them first.
MOST_PROBLEMS = 50


class ChangeRefused(NamedTuple):
    """Why a change does not take place."""

    message: str
    problems: tuple[Finding, ...] = ()

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
                )
                for problem in self.problems[:MOST_PROBLEMS]
            ],
        )


def refusal_of(error: DescriptionError) -> ChangeRefused:
    """Make a refusal of a text that cannot be read as a description."""
    finding = finding_of(error)
    return ChangeRefused("the description cannot be used as written", (finding,))
