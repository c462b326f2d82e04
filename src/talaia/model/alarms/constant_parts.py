"""What an expression divides by that is always 0. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.alarms.expression import Expression, ExpressionNode

__all__ = ["ZERO_REMEDY", "zero_division_problem"]

ZERO_REMEDY = "divide by a number that is not 0, or multiply"


def zero_division_problem(found: Expression) -> str:
    """Say where it divides by what is always 0, so that it never has a value; empty if nowhere."""
    at = next(_zero_divisions(found.tree), None)
    return "" if at is None else f"at letter {at + 1}: it divides by 0, so it never has a value"


def _zero_divisions(node: ExpressionNode) -> Iterator[int]:
    if node.form == "/":
        below = node.parts[1]
        # Without signals all is known of it now.
        if not _has_signal(below) and below.evaluate_node({}) == 0:
            yield node.at
    for part in node.parts:
        yield from _zero_divisions(part)


def _has_signal(node: ExpressionNode) -> bool:
    return node.form == "signal" or any(_has_signal(part) for part in node.parts)
