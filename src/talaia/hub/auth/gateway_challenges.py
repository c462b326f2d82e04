"""The hub's numbers that gateways answer: each good for a short time, and answered well once."""

from __future__ import annotations

import hashlib
import hmac
import secrets
from typing import TYPE_CHECKING

from talaia.clock import SECOND

if TYPE_CHECKING:
    from talaia.clock import Clock

__all__ = ["NONCE_S", "GatewayChallenges"]

# A gateway opens its link, and right after it the connections for pictures and files.
NONCE_S = 60
_RANDOM_BYTES = 16
# 128 bits: nobody guesses it within that time.
_SEAL_CHARACTERS = 32


class GatewayChallenges:
    """Makes numbers, and knows its own again.

    Nothing is kept of a number until it was answered well: whoever only asks costs no memory.
    """

    def __init__(self, clock: Clock) -> None:
        """``clock`` says how old a number is."""
        self._clock = clock
        # Of this process alone: a number of before a restart is asked for anew.
        self._key = secrets.token_bytes(32)
        # When each number that was answered ends (monotonic ns); in the order of answering.
        self._used: dict[str, int] = {}

    def make_nonce(self) -> str:
        """Make a number."""
        said = f"{secrets.token_hex(_RANDOM_BYTES)}.{self._clock.monotonic_ns()}"
        return f"{said}.{self._seal_of(said)}"

    def is_open(self, nonce: str) -> bool:
        """Tell whether a number is ours, is not too old, and was not answered yet."""
        said, _, seal = nonce.rpartition(".")
        if not hmac.compare_digest(self._seal_of(said).encode(), seal.encode()):
            return False
        # Ours, so the time in it is a number.
        age_ns = self._clock.monotonic_ns() - int(said.partition(".")[2])
        return age_ns <= NONCE_S * SECOND and nonce not in self._used

    def use_nonce(self, nonce: str) -> None:
        """Count a number as answered."""
        now_ns = self._clock.monotonic_ns()
        for old in [used for used, until_ns in self._used.items() if until_ns < now_ns]:
            del self._used[old]
        # Too old by then in any case.
        self._used[nonce] = now_ns + NONCE_S * SECOND

    def _seal_of(self, said: str) -> str:
        return hmac.new(self._key, said.encode(), hashlib.sha256).hexdigest()[:_SEAL_CHARACTERS]
