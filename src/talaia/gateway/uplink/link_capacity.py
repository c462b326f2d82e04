"""How much room the link to the hub has for pictures, by how long they are under way. Pure."""

from __future__ import annotations

__all__ = ["LinkCapacity"]

# Longer than usual under way by this (µs): the link is full, and nothing is encoded for it.
FULL_US = 150_000
# Until the first receipt nobody knows how far away the hub is.
_UNKNOWN_US = 350_000
# µs over the least time: slower than the first gives bits back, faster than the second takes some.
_SLOW_US, _FAST_US = 80_000, 30_000
# Down in larger steps than up: a full link must empty.
_FEWER, _MORE = 0.7, 1.2
_LEAST = 0.1
# Changes come no faster than this (µs): what one does must be seen first.
_DOWN_US, _UP_US = 400_000, 3_000_000
# The least time forgets itself slowly, for paths change (part of itself a second).
_FORGET = 0.02


class LinkCapacity:
    """Watches pictures go and their receipts come back, and gives the share of the bits to use."""

    def __init__(self) -> None:
        """Begin with all the room there is."""
        self.clear()

    def clear(self) -> None:
        """Forget what is under way, since the connection is a new one."""
        # Pictures under way: number to when it was given to the socket (µs), oldest first.
        self._under: dict[int, int] = {}
        # The least time that a picture and its receipt took (µs); 0 before the first receipt.
        self._least_us = 0.0
        self._heard_us = 0  # When the last receipt came (µs).
        self._changed_us = 0  # When the share was last changed (µs).
        self._share = 1.0  # Share of the bits to use, 0.1 to 1.

    def sent(self, n: int, now_us: int) -> None:
        """Note that picture ``n`` of this connection was given to the socket."""
        self._under[n] = now_us

    def arrived(self, n: int, now_us: int) -> None:
        """Note the receipt for picture ``n``; one for a picture never sent changes nothing."""
        sent_us = self._under.pop(n, None)
        if sent_us is None:
            return
        # Receipts come in order: those before it were lost with a former picture.
        for older in [sequence for sequence in self._under if sequence < n]:
            del self._under[older]
        took = now_us - sent_us
        if not self._least_us:
            self._least_us = took
        # The path may have become longer for good; then the least time follows by 2 % a second.
        since_s = (now_us - self._heard_us) / 1e6
        self._heard_us = now_us
        self._least_us = min(took, self._least_us * (1 + _FORGET * min(since_s, 1.0)))
        over = took - self._least_us
        if over > _SLOW_US and now_us - self._changed_us > _DOWN_US:
            self._share, self._changed_us = max(_LEAST, self._share * _FEWER), now_us
        elif over < _FAST_US and self._share < 1 and now_us - self._changed_us > _UP_US:
            self._share, self._changed_us = min(1.0, self._share * _MORE), now_us

    def share(self, now_us: int) -> float:
        """Give the share of the bits to use now (0.1 to 1), or 0 while the link is full."""
        if self._under:
            oldest = next(iter(self._under.values()))
            # Nothing came back for longer than a full link would take.
            if now_us - oldest > (self._least_us or _UNKNOWN_US) + FULL_US:
                return 0.0
        return self._share
