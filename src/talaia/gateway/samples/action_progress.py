"""How far an action is by its feedback, that counts up or, as Nav2's distance, down. Pure."""

from __future__ import annotations

import math

__all__ = ["ActionProgress"]


class ActionProgress:
    """The share of one goal that is done."""

    def __init__(self, end: float) -> None:
        """Begin at none.

        ``end``: the value that means done; 0: it counts down from the greatest that it says.
        """
        self._end, self._greatest = end, 0.0

    def share_of(self, value: float) -> float:
        """Give the share, 0 to 1, by the newest value; 0 for what is no number."""
        if self._end:
            share = value / self._end
        else:
            # Before a path is found Nav2 says 0, which is not the end.
            self._greatest = max(self._greatest, value)
            share = 1 - value / self._greatest if self._greatest > 0 else 0.0
        return min(max(share, 0.0), 1.0) if math.isfinite(share) else 0.0
