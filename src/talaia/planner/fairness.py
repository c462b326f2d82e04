"""Fairness to allocations: what a second of each proposal earns or pays, by the share it lacks.

A search that only adds up priorities gives most of a night to whoever asks with the highest ones.
"No share is further from what is due than so much" is a constraint as others are, and has prices as
they have: each second of a proposal that would get too little earns something beside its priority,
and each of one that would get too much pays. They are found with the prices of time, so that no
more value is given for shares than shares need. Since the largest difference is what counts, all of
them share one limit (the dual of a maximum): what nobody can mend is not paid for once for each.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from talaia.planner.night_problem import Ints
    from talaia.planner.sky import Floats

__all__ = ["EVEN_HANDED", "INDIFFERENT", "FairnessRule", "ShareProblem"]

# From now on to ends of the night that may come sooner than its own (s).
_ENDS_S = (3600, 7200, 14_400)


class FairnessRule(NamedTuple):
    """How strongly shares are held to what is due.

    Attributes:
        slack: a difference of shares up to this is no matter.
        most: a second by which the largest difference is less is worth at most so many times what
            one is usually worth; 0: priorities alone count.
        early: how likely the night ends before its end, so that shares have to be even by then.

    """

    slack: float = 0.09
    most: float = 4.0
    early: float = 0.4

    def ends_from(self, second: int, length_s: int) -> tuple[Ints, Floats]:
        """Give ends of the night that may come behind a second (s), and how likely each is."""
        sooner = second + np.array(_ENDS_S)
        sooner = sooner[sooner < length_s] if self.early > 0.0 else sooner[:0]
        if not sooner.size:
            return np.array([length_s]), np.ones(1)
        likely = np.full(len(sooner), self.early / len(sooner))
        return np.append(sooner, length_s), np.append(likely, 1.0 - self.early)


EVEN_HANDED = FairnessRule()
INDIFFERENT = FairnessRule(most=0.0)


class ShareProblem(NamedTuple):
    """Whose shares are to come near to what, as arrays over proposals.

    Nights may end sooner than the Sun says. Shares are held to what is due at each of some ends,
    each as strongly as it is likely.

    Attributes:
        due: share of the shutter time that each is due (0 to 1); 0: its priority alone counts.
        got_s: shutter time that each has got (s).
        slack: see `FairnessRule`.
        most: of each end, a second of the largest difference costs at most so much.
        ends: of the night, that may come (s).

    """

    due: Floats
    got_s: Floats
    slack: float
    most: Floats
    ends: Ints

    def tilts(self, pulls: Floats) -> Floats:
        """Give what a second of each proposal earns by these prices; it pays where below zero.

        By the end up to which it counts (ends × proposals): one that begins early counts for all
        ends behind it.
        """
        above, below = pulls
        # Each second of anybody makes what is due to all the others more.
        common = (above * (self.due + self.slack) - below * (self.due - self.slack)).sum(axis=1)
        tilts = np.where(self.due > 0.0, below - above + common[:, None], 0.0)
        return np.asarray(np.cumsum(tilts[::-1], axis=0)[::-1])

    def excess(self, planned_s: Floats) -> Floats:
        """Give by how much each share would be too much, and too little (s; below zero: not).

        Of planned shutter time up to each end (ends × proposals).
        """
        whole = self.got_s + planned_s
        total = whole.sum(axis=1, keepdims=True)
        above = whole - (self.due + self.slack) * total
        below = (self.due - self.slack) * total - whole
        # Nothing is due to a proposal of rapid requests.
        return np.asarray(np.where(self.due > 0.0, np.stack([above, below]), -np.inf))

    def paid(self, pulls: Floats) -> float:
        """Give what the shares that there are already add to a bound by these prices."""
        nothing = np.zeros((len(self.ends), len(self.due)))
        excess = np.where(pulls > 0.0, self.excess(nothing), 0.0)
        return -float((pulls * excess).sum())

    def moved(self, pulls: Floats, step_s: Floats) -> Floats:
        """Give the prices after a step; none is below zero, those of an end at most its `most`.

        Only the largest difference counts: what one proposal pays for it no other pays again.
        """
        moved = np.maximum(pulls + step_s, 0.0)
        for end, most in enumerate(self.most):
            part = moved[:, end]
            if part.sum() > most:
                # The nearest prices that hold: all less by the same, none below zero.
                falling = np.sort(part, axis=None)[::-1]
                less = (np.cumsum(falling) - most) / np.arange(1, falling.size + 1)
                part -= less.max()
        return np.asarray(np.maximum(moved, 0.0))
