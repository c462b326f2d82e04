"""Who has proved anew, a short while ago, that it is them: for what gives rights away. Pure.

A cookie that was taken, or a page that was left open, does not make tokens, people or roles.
Kept in memory only: after a restart everybody is asked again.
"""

from __future__ import annotations

__all__ = ["FreshConfirmations"]

# Beyond so many the oldest are forgotten.
_MOST = 10_000


class FreshConfirmations:
    """When each session gave the password, and the factor where there is one, last."""

    def __init__(self, life_ns: int) -> None:
        """Let each count for ``life_ns``."""
        self._life_ns = life_ns
        # By the session's hash (monotonic), the oldest first.
        self._given: dict[str, int] = {}

    def confirm(self, session: str, now_ns: int) -> None:
        """Count a session as confirmed from now on."""
        self._given.pop(session, None)
        self._given[session] = now_ns
        while len(self._given) > _MOST:
            del self._given[next(iter(self._given))]

    def is_fresh(self, session: str, now_ns: int) -> bool:
        """Tell whether a session was confirmed a short while ago."""
        given_ns = self._given.get(session)
        if given_ns is None:
            return False
        if now_ns - given_ns > self._life_ns:
            del self._given[session]
            return False
        return True
