"""How much may be under way to a peer that takes it slowly. Pure."""

from __future__ import annotations

__all__ = ["CreditWindow", "TakenCount"]


class CreditWindow:
    """The sender's side: bytes that were sent and not taken yet."""

    def __init__(self, limit: int) -> None:
        """Let at most ``limit`` bytes be under way, and one message besides."""
        self._limit = limit
        self._under_way = 0

    @property
    def has_room(self) -> bool:
        """Whether something may be sent: a message of any size, once the rest was taken."""
        return self._under_way < self._limit

    def spend_bytes(self, size: int) -> None:
        """Count what is sent."""
        self._under_way += size

    def earn_bytes(self, size: int) -> None:
        """Count what the peer says it has taken."""
        # Not below nothing: a peer must not earn itself an endless window.
        self._under_way = max(0, self._under_way - size)


class TakenCount:
    """The receiver's side: what was taken, told in portions so that few frames are needed."""

    def __init__(self, limit: int) -> None:
        """Tell at each quarter of ``limit``."""
        self._portion = max(1, limit // 4)
        self._taken = 0

    def add_taken(self, size: int) -> int:
        """Count what was taken; give how much is to be told now, 0 for nothing yet."""
        self._taken += size
        if self._taken < self._portion:
            return 0
        told, self._taken = self._taken, 0
        return told
