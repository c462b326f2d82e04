"""Fairness to allocations: what a proposal's minutes count for, by the share that it lacks.

A search that only adds up priorities gives most of a night to whoever asks with the highest ones.
Here the minutes of a proposal that will get less than its share count for more, and the others'
for less, until shares and dues agree well enough.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from talaia.planner.sky import Floats

__all__ = ["EVEN_HANDED", "INDIFFERENT", "FairnessRule", "adjust_merits"]


# Power of a merit that is left of it at each step in which nothing is lacking.
_FADING = 0.95


class FairnessRule(NamedTuple):
    """How strongly shares are held to what is due.

    Attributes:
        gain: of each step; 0: priorities alone count.
        slack: a difference of shares up to this is no matter.
        most: no minute counts for more than this many times its priority, nor less than one over.

    """

    gain: float = 0.8
    slack: float = 0.1
    most: float = 2.0


EVEN_HANDED = FairnessRule()
INDIFFERENT = FairnessRule(gain=0.0)


def adjust_merits(rule: FairnessRule, merits: Floats, *, due: Floats, shutter_s: Floats) -> Floats:
    """Give what a proposal's minutes count for from now on.

    Args:
        rule: see `FairnessRule`.
        merits: what they counted for so far (1: their priority).
        due: share of the shutter time that each proposal is due (0 to 1).
        shutter_s: what each has got and will get by the plan (s).

    """
    total = float(shutter_s.sum())
    if rule.gain <= 0.0 or total <= 0.0:
        return merits
    lack = due - shutter_s / total
    lack = np.sign(lack) * np.maximum(np.abs(lack) - rule.slack, 0.0)
    # What is well enough goes back to its priority, slowly.
    rest = np.where(lack == 0.0, merits**_FADING, merits)
    adjusted = np.clip(rest * np.exp(rule.gain * lack), 1.0 / rule.most, rule.most)
    # Nothing is due to a proposal of rapid requests: their priority alone counts.
    return np.where(due > 0.0, adjusted, 1.0)
