"""Who may drive a device: one holder at a time, each grant with a higher epoch. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["Holder", "Lease"]


class Holder(NamedTuple):
    """Who has it, under which epoch, and until when (ns, monotonic)."""

    session: str
    who: str
    epoch: int
    until_ns: int


class Lease:
    """The lease of one device.

    Every question takes the time, and an overdue lease is gone by that alone: no timer has to
    run for it to end.
    """

    def __init__(self, duration_ns: int, next_epoch: Callable[[], int]) -> None:
        """Start free.

        Args:
            duration_ns: a lease ends so long after it was granted or last renewed.
            next_epoch: gives a number higher than every one before, also across restarts.

        """
        self._duration_ns = duration_ns
        self._next_epoch = next_epoch
        self._holder: Holder | None = None

    def holder(self, now_ns: int) -> Holder | None:
        """Give the holder, or none."""
        if self._holder is not None and now_ns >= self._holder.until_ns:
            self._holder = None
        return self._holder

    def take(self, session: str, who: str, now_ns: int) -> str:
        """Grant it, or give the reason why not (empty when granted).

        A holder that asks again gets a new epoch: it may be a page that was loaded anew, whose
        frames count from zero, and the frames of its former life must not pass any more.
        """
        held = self.holder(now_ns)
        if held is not None and held.session != session:
            return f"{held.who} is driving"
        self._holder = Holder(session, who, self._next_epoch(), now_ns + self._duration_ns)
        return ""

    def renew(self, session: str, now_ns: int) -> str:
        """Prolong it, or give the reason why not. Too late is too late: ask anew."""
        held = self.holder(now_ns)
        if held is None:
            return "the lease has ended; take it again"
        if held.session != session:
            return f"{held.who} is driving"
        self._holder = held._replace(until_ns=now_ns + self._duration_ns)
        return ""

    def free(self, session: str, now_ns: int) -> bool:
        """Give it up; tell whether ``session`` had it."""
        held = self.holder(now_ns)
        if held is None or held.session != session:
            return False
        self._holder = None
        return True

    def until_ns(self) -> int | None:
        """Give when it ends by itself, or none while free."""
        return None if self._holder is None else self._holder.until_ns

    def drop(self) -> Holder | None:
        """End it whoever holds it, and give who did."""
        held, self._holder = self._holder, None
        return held
