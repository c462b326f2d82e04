"""How long to wait before dialling again. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["Backoff"]


class Backoff:
    """Doubling waits with jitter, so that five hundred gateways do not return as one.

    A handshake that succeeds proves little: a hub that falls over under its load accepts and
    dies. Only a link that stayed for `STABLE_S` starts the waits from the beginning.
    """

    FIRST_S = 0.5
    LONGEST_S = 30.0
    REFUSED_S = 30.0
    STABLE_S = 10.0

    def __init__(self, random: Callable[[], float]) -> None:
        """Take a source of numbers in [0, 1)."""
        self._random = random
        self._failures = 0

    def after(self, lasted_s: float, *, refused: bool = False) -> float:
        """Give the wait (s) after a link that lasted ``lasted_s`` (0 when it never stood)."""
        if lasted_s >= self.STABLE_S:
            self._failures = 0
        # The exponent is bounded, for a gateway may be away for a year.
        longest = min(self.LONGEST_S, self.FIRST_S * 2.0 ** min(self._failures, 16))
        self._failures += 1
        if refused:
            return self.REFUSED_S * (1.0 + self._random())
        return longest * (0.5 + 0.5 * self._random())
