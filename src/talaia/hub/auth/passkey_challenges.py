"""Challenges that wait for the answer of a passkey; each is good once. Pure but for chance.

Kept in memory only: a ceremony that a restart interrupts is begun again.
"""

from __future__ import annotations

import secrets
from dataclasses import dataclass
from enum import Enum, auto

from talaia.clock import SECOND

__all__ = ["ChallengeUse", "PasskeyChallenge", "PasskeyChallenges"]

_BYTES = 32
# Browsers wait for a person for about as long.
_LIFE_NS = 300 * SECOND
# Beyond so many the oldest are forgotten: anybody may ask for one.
_MOST = 10_000


class ChallengeUse(Enum):
    """What the answer is for; one for another purpose is refused."""

    REGISTER = auto()
    # After the right password: having the key is enough.
    SECOND_FACTOR = auto()
    # In place of the password: the key's device must have verified who uses it.
    PASSWORDLESS = auto()
    CONFIRM = auto()


@dataclass(frozen=True, slots=True)
class PasskeyChallenge:
    """One that was handed out.

    Attributes:
        value: 32 random bytes.
        use: what the answer may be used for.
        user: whose key has to answer; 0: anybody's.
        session: in which the answer counts; empty: in none, it begins one.
        begun_ns: when it was handed out.

    """

    value: bytes
    use: ChallengeUse
    user: int
    session: str
    begun_ns: int


class PasskeyChallenges:
    """Hands out challenges, and takes each back once."""

    def __init__(self) -> None:
        """Begin with none."""
        # In the order in which they were handed out.
        self._waiting: dict[bytes, PasskeyChallenge] = {}

    def begin(self, use: ChallengeUse, now_ns: int, *, user: int = 0, session: str = "") -> bytes:
        """Hand out a challenge."""
        value = secrets.token_bytes(_BYTES)
        self._waiting[value] = PasskeyChallenge(value, use, user, session, now_ns)
        while len(self._waiting) > _MOST:
            del self._waiting[next(iter(self._waiting))]
        return value

    def redeem(
        self, value: bytes, uses: frozenset[ChallengeUse], now_ns: int, session: str = ""
    ) -> PasskeyChallenge | None:
        """Take one back; None when it is unknown, used, too old, or for something else."""
        # Gone whatever comes of it: an answer that was wrong is not tried once more.
        found = self._waiting.pop(value, None)
        if found is None or found.use not in uses or found.session != session:
            return None
        return found if now_ns - found.begun_ns <= _LIFE_NS else None
