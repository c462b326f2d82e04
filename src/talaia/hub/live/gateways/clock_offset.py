"""How far another machine's monotonic clock is from ours, told from beats. Pure."""

from __future__ import annotations

from collections import deque

__all__ = ["ClockOffset"]

# Beats; older ones are given up, since two clocks drift apart.
_KEPT = 60


class ClockOffset:
    """The offset seen by the quickest of the last beats: the less time under way, the less error.

    All times are microseconds.
    """

    def __init__(self) -> None:
        """Start without an estimate."""
        # Time there and back, and offset, of the last beats.
        self._seen: deque[tuple[int, int]] = deque(maxlen=_KEPT)
        # Time there and back of the last beat.
        self.loop_us = 0
        # Beats that came back, so that the one who sends them sees how many did not.
        self.heard = 0

    def add_beat(self, sent_us: int, received_us: int, peer_us: int) -> None:
        """Take a beat sent and received on our clock, answered at ``peer_us`` on theirs."""
        self.heard += 1
        loop = received_us - sent_us
        # No beat comes back before it is sent: this answer belongs to none of ours.
        if loop < 0:
            return
        self.loop_us = loop
        # As if the way there and the way back take equally long.
        self._seen.append((loop, peer_us - (sent_us + received_us) // 2))

    @property
    def known(self) -> bool:
        """Whether any beat has come back."""
        return bool(self._seen)

    def to_ours(self, peer_us: int) -> int | None:
        """Turn a moment on their clock into one on ours; None while nothing is known."""
        if not self._seen:
            return None
        return peer_us - min(self._seen)[1]
