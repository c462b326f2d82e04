"""How long to wait before dialling again. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["Backoff"]


class Backoff:
    """Doubling waits with jitter, so that five hundred gateways do not return as one.

    A link that was lost, and a hub that does not answer, say nothing of a crowd: somebody at a
    page waits for this robot, and so the waits end at `QUICK_S`. Only a hub that is there and
    sends us away makes them longer: as long as it says, or doubling up to `LONGEST_S`.

    A handshake that succeeds proves little: a hub that falls over under its load accepts and
    dies. Only a link that stayed for `STABLE_S` starts the waits from the beginning.
    """

    # Seconds. A hub that restarts is back within one or two; half a second finds it soon.
    FIRST_S = 0.5
    QUICK_S = 2.0
    LONGEST_S = 30.0
    REFUSED_S = 30.0
    # Longer than a hub that falls over under its load takes to do so.
    STABLE_S = 10.0

    def __init__(self, random: Callable[[], float]) -> None:
        """Take a source of numbers in [0, 1)."""
        self._random = random  # In [0, 1): spreads gateways that were lost in the same instant.
        self._failures = 0  # Waits since the last link that stayed; sets how long the next is.
        self._sent_away = 0  # How often in a row the hub was there and sent us away.

    def after(
        self, lasted_s: float, *, refused: bool = False, sent_away_s: float | None = None
    ) -> float:
        """Give the wait (s) after a link that lasted ``lasted_s`` (0 when it never stood).

        Args:
            lasted_s: see above.
            refused: the hub does not know our key.
            sent_away_s: the hub sent us away, and said to come back after so long; 0: it did not
                say when; none: it did not send us away.

        """
        if lasted_s >= self.STABLE_S:
            self._failures = self._sent_away = 0
        longest = self._doubled(self._failures, self.QUICK_S)
        self._failures += 1
        if refused:
            # Between 30 and 60 s: a wrong key is mended by a person, not by dialling.
            return self.REFUSED_S * (1.0 + self._random())
        if sent_away_s is None:
            self._sent_away = 0
        else:
            longest = self._doubled(self._sent_away, self.LONGEST_S)
            self._sent_away += 1
            if sent_away_s > 0:
                # The hub's own wait, bounded: a mistake of a hub must not keep a robot away for an
                # hour.
                return min(sent_away_s, 2 * self.LONGEST_S) * (0.5 + self._random())
        return longest * (0.5 + 0.5 * self._random())

    def _doubled(self, times: int, longest: float) -> float:
        # The exponent is bounded, for a gateway may be away for a year.
        return float(min(longest, self.FIRST_S * 2.0 ** min(times, 16)))
