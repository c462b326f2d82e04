"""STOP (software): latched until reset in two steps, confirmed by the robot itself. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["LatchedStop", "StandstillProof", "StopLatch"]

# Long enough for a second press, short enough that a page left open cannot release by a stray one.
TOKEN_NS = 10 * SECOND


class LatchedStop(NamedTuple):
    """Who stopped the device, by which ask, and when (wall time)."""

    id: str
    who: str
    time_us: int


class StandstillProof(NamedTuple):
    """A reading that tells whether the robot stands still.

    Attributes:
        value: newest reading, in its unit.
        mono_ns: when it came.
        max_age_ns: older than this it proves nothing.

    """

    value: float
    mono_ns: int
    max_age_ns: int


class StopLatch:
    """The STOP of one device.

    Asking again changes nothing but is answered each time. It opens only with the token that the
    same session was given at most ten seconds before, once.
    """

    def __init__(self, below: float, latched: LatchedStop | None = None) -> None:
        """Take how near zero counts as standing still, and the state kept on disk."""
        self._below = below
        # Session, token and until when it may be used (monotonic); one at a time, used once.
        self._token: tuple[str, str, int] | None = None
        # When STOP came: readings from before it prove no standstill.
        self._since_ns = 0
        self.latched = latched
        # The robot itself has shown that it stands; never taken from what was sent.
        self.confirmed = False

    def request_stop(self, latched: LatchedStop, now_ns: int) -> bool:
        """Latch; tell whether it was open before. The first who asked stays on record."""
        # A STOP while a reset is being prepared undoes the preparation.
        self._token = None
        if self.latched is not None:
            return False
        self.latched = latched
        self._since_ns = now_ns
        self.confirmed = False
        return True

    def judge_standstill(self, proofs: Iterable[StandstillProof | None], now_ns: int) -> bool:
        """Confirm or unconfirm by the newest readings; tell whether that changed.

        All must have come after STOP, be fresh, and be within ``below`` of zero. With no reading
        named in the description nothing can be confirmed. NaN proves nothing.
        """
        seen = list(proofs)
        still = bool(seen) and all(
            proof is not None
            # All comparisons in one clock; a reading from before STOP shows how it drove, not that
            # it stands.
            and proof.mono_ns >= self._since_ns
            and now_ns - proof.mono_ns <= proof.max_age_ns
            # NaN compares false, so it proves nothing.
            and abs(proof.value) <= self._below
            for proof in seen
        )
        # Readings go on after the reset; they confirm nothing then.
        still = still and self.latched is not None
        changed = still is not self.confirmed
        self.confirmed = still
        return changed

    def offer_token(self, session: str, token: str, now_ns: int) -> str:
        """Keep a fresh token for ``session``; give the reason when there is nothing to reset."""
        if self.latched is None:
            return "STOP is not on"
        self._token = (session, token, now_ns + TOKEN_NS)
        return ""

    def check_token(self, session: str, token: str, now_ns: int) -> str:
        """Use up the token; give the reason when it does not open. The latch itself stays."""
        # Used up by any attempt: a wrong guess costs the token.
        kept, self._token = self._token, None
        if self.latched is None:
            return "STOP is not on"
        if kept is None or kept[0] != session or kept[1] != token:
            return "this reset was not prepared; begin again"
        if now_ns >= kept[2]:
            return "the reset was prepared too long ago; begin again"
        return ""

    def release_latch(self) -> None:
        """Release it. This starts no motion: the driver must press anew."""
        self.latched = None
        self.confirmed = False
        self._token = None
