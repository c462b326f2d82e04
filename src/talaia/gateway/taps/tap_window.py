"""How many bytes of raw topics may be under way to the hub at once. Pure.

Taps take what the line has to spare: once receipts come later than they might, fewer bytes go, so
that nothing waits behind them in the buffers on the way, neither pictures nor driving frames on
their own connection.
"""

from __future__ import annotations

__all__ = ["TapWindow"]

_LEAST, _MOST = 32 * 1024, 4 * 1024 * 1024
_BEGIN = 256 * 1024
# A receipt that comes later than the soonest by this (µs): something waits on the way.
_LATE_US = 40_000
_FEWER = 0.7
# What is added for each window that came soon, after the first late one.
_MORE = 32 * 1024
# The soonest forgets itself slowly, for paths change.
_FORGET = 1.0005
_LEAST_PIECE, _MOST_PIECE = 16 * 1024, 64 * 1024
# Between two receipts (bytes): each costs the hub a frame, and the window is counted in them.
_MOST_UNMARKED = 256 * 1024
# Pieces of a window: so many may be under way one behind the other.
_PIECES = 4


class TapWindow:
    """Counts bytes that go and receipts that come back."""

    def __init__(self) -> None:
        """Begin with a line that nobody knows."""
        self.clear()

    def clear(self) -> None:
        """Forget all, since the connection is a new one."""
        self._window = float(_BEGIN)
        # Sent, without a receipt yet.
        self._under_way = 0
        # Of them those that no receipt has been asked for yet.
        self._unmarked = 0
        # By the number of a receipt: when it was asked for (µs), and for how many bytes.
        self._marks: dict[int, tuple[int, int]] = {}
        self._numbers = 0
        # The soonest receipt took this (µs); 0 before the first.
        self._soonest_us = 0.0
        # When the window last shrank (µs).
        self._shrunk_us = 0
        # Until the first late receipt it doubles with each window.
        self._probing = True
        # More would have gone: only then receipts say that the window may grow.
        self._limited = False

    def piece(self) -> int:
        """Give how many bytes one frame may have now."""
        return max(_LEAST_PIECE, min(_MOST_PIECE, int(self._window) // _PIECES))

    def has_room(self) -> bool:
        """Tell whether another piece may go now; if not, the next receipt makes room."""
        room = self._under_way < self._window
        self._limited = self._limited or not room
        return room

    def sent(self, size: int, now_us: int) -> int | None:
        """Count bytes that go; give the number of a receipt to ask for behind them, if any."""
        self._under_way += size
        self._unmarked += size
        if self._unmarked < min(_MOST_UNMARKED, self._window / _PIECES):
            return None
        self._numbers += 1
        self._marks[self._numbers] = now_us, self._unmarked
        self._unmarked = 0
        return self._numbers

    def arrived(self, number: int, now_us: int) -> None:
        """Take a receipt; one that was not asked for on this connection changes nothing."""
        if number not in self._marks:
            return
        sent_us, size = self._marks[number]
        # They come in order.
        for older in [mark for mark in self._marks if mark <= number]:
            self._under_way -= self._marks.pop(older)[1]
        took = max(1, now_us - sent_us)
        self._soonest_us = min(took, self._soonest_us * _FORGET) if self._soonest_us else took
        if took - self._soonest_us > _LATE_US:
            self._probing = False
            # Once for all that was under way: what this does must be seen first.
            if sent_us >= self._shrunk_us:
                self._window = max(_LEAST, self._window * _FEWER)
                self._shrunk_us = now_us
        elif self._limited:
            self._window += size if self._probing else _MORE * size / self._window
            self._window = min(_MOST, self._window)
            self._limited = False
