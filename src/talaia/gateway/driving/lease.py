"""Who may drive a device: one holder at a time, each grant with a higher epoch. Pure.

Somebody else gets it by asking the holder, who has five seconds to say yes or no. Only after a no,
or no answer, may it be forced; that whoever forces has the right to is the hub's matter.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["ANSWER_NS", "FORCE_NS", "DeviceLease", "LeaseHolder", "LeaseRival"]

# The holder's time to answer an ask.
ANSWER_NS = 5 * SECOND
# An ask that was in vain may be followed by force for so long; after that, ask again.
FORCE_NS = 30 * SECOND


class LeaseHolder(NamedTuple):
    """Who has it, under which epoch, and until when (ns, monotonic)."""

    session: str
    who: str
    epoch: int
    until_ns: int


class LeaseRival(NamedTuple):
    """Who asks the holder for it, and until when the holder may answer (ns, monotonic)."""

    session: str
    who: str
    until_ns: int


class DeviceLease:
    """The lease of one device.

    Every question takes the time, and an overdue lease is gone by that alone: no timer has to
    run for it to end. It passes to who asks for it only inside a call that says so (`take`,
    `accept_rival`, `force_lease`, `pass_on`), so that nobody becomes the driver by a mere look.
    """

    def __init__(self, duration_ns: int, next_epoch: Callable[[], int]) -> None:
        """Start free.

        Args:
            duration_ns: a lease ends so long after it was granted or last renewed.
            next_epoch: gives a number higher than every one before, also across restarts.

        """
        self._duration_ns = duration_ns  # From the description, ns.
        # Shared by all devices, kept on disk; raises OSError where no number can be reserved.
        self._next_epoch = next_epoch
        # May be overdue: only `holder_at` says whether there is one.
        self._holder: LeaseHolder | None = None
        # Who asks the holder for it; overdue as well until `rival_at` is asked.
        self._rival: LeaseRival | None = None
        # Sessions whose ask of the present holder was in vain, and until when they may force it.
        self._in_vain: dict[str, int] = {}

    def holder_at(self, now_ns: int) -> LeaseHolder | None:
        """Give the holder, or none."""
        # `>=`: a lease of 2 s is over at 2 s, so that nobody can hold it at the instant another
        # gets it.
        if self._holder is not None and now_ns >= self._holder.until_ns:
            self._holder = None
            self._in_vain.clear()
        return self._holder

    def rival_at(self, now_ns: int) -> LeaseRival | None:
        """Give who asks the holder for it, or none."""
        rival = self._rival
        if rival is not None and now_ns >= rival.until_ns:
            # Silence counts as no. Who asked may force from the moment the answer was due, not from
            # when somebody looked.
            self._rival = None
            if self.holder_at(now_ns) is not None:
                self._in_vain[rival.session] = rival.until_ns + FORCE_NS
        return self._rival

    def may_force(self, session: str, now_ns: int) -> bool:
        """Tell whether ``session`` asked the present holder in vain, not long ago."""
        self.rival_at(now_ns)
        # `get(…, now_ns)`: for one who never asked the comparison is false.
        return self.holder_at(now_ns) is not None and now_ns < self._in_vain.get(session, now_ns)

    def take_lease(self, session: str, who: str, now_ns: int) -> str:
        """Grant it, or give the reason why not (empty when granted).

        A holder that asks again gets a new epoch: it may be a page that was loaded anew, whose
        frames count from zero, and the frames of its former life must not pass any more.

        Raises:
            OSError: no new epoch can be had; all is as it was.

        """
        held, rival = self.holder_at(now_ns), self.rival_at(now_ns)
        if held is not None and held.session != session:
            return f"{held.who} is driving"
        # Free, but asked for: the one who waited gets it by `pass_on`, not whoever is quicker now.
        if held is None and rival is not None and rival.session != session:
            return f"{rival.who} has asked for it first"
        self._grant_lease(session, who, now_ns)
        return ""

    def request_lease(self, session: str, who: str, now_ns: int) -> str:
        """Ask the holder for it (or take it, if it is free); give the reason why not.

        Raises:
            OSError: as `take`.

        """
        held, rival = self.holder_at(now_ns), self.rival_at(now_ns)
        if held is None or held.session == session:
            return self.take_lease(session, who, now_ns)
        if rival is not None and rival.session != session:
            return f"{rival.who} has asked for it already"
        if rival is None:
            # A new ask gives the holder a new chance to answer; the right to force from the last is
            # gone.
            self._in_vain.pop(session, None)
            self._rival = LeaseRival(session, who, now_ns + ANSWER_NS)
        return ""

    def accept_rival(self, session: str, now_ns: int) -> str:
        """Let the holder hand it to who asks; give the reason why not.

        Raises:
            OSError: as `take`.

        """
        held, rival = self.holder_at(now_ns), self.rival_at(now_ns)
        if held is None or held.session != session:
            return "only who has control can hand it over"
        if rival is None:
            return "nobody asks for it any more"
        self._grant_lease(rival.session, rival.who, now_ns)
        return ""

    def deny_rival(self, session: str, now_ns: int) -> LeaseRival | None:
        """Let the holder say no; give who was refused, or none when there was nobody to refuse."""
        held, rival = self.holder_at(now_ns), self.rival_at(now_ns)
        if held is None or held.session != session or rival is None:
            return None
        self._rival = None
        self._in_vain[rival.session] = now_ns + FORCE_NS
        return rival

    def force_lease(self, session: str, who: str, now_ns: int) -> str:
        """Take it from the holder, whom ``session`` asked in vain; give the reason why not.

        Raises:
            OSError: as `take`.

        """
        held = self.holder_at(now_ns)
        if held is None or held.session == session:
            return self.take_lease(session, who, now_ns)
        if not self.may_force(session, now_ns):
            return f"ask {held.who} first; it can be forced after a no, or 5 s without an answer"
        self._grant_lease(session, who, now_ns)
        return ""

    def pass_on(self, now_ns: int) -> bool:
        """Give a lease that has become free to who asks for it; tell whether that was so.

        Raises:
            OSError: as `take`.

        """
        held, rival = self.holder_at(now_ns), self.rival_at(now_ns)
        if held is not None or rival is None:
            return False
        self._grant_lease(rival.session, rival.who, now_ns)
        return True

    def renew_lease(self, session: str, now_ns: int) -> str:
        """Prolong it, or give the reason why not. Too late is too late: ask anew."""
        held = self.holder_at(now_ns)
        if held is None:
            return "the lease has ended; take it again"
        if held.session != session:
            return f"{held.who} is driving"
        # Only the end moves: renewing keeps the epoch, so frames on their way stay valid.
        self._holder = held._replace(until_ns=now_ns + self._duration_ns)
        return ""

    def free_lease(self, session: str, now_ns: int) -> bool:
        """Give it up, or no longer ask for it; tell whether ``session`` had it."""
        held, rival = self.holder_at(now_ns), self.rival_at(now_ns)
        self._in_vain.pop(session, None)
        if rival is not None and rival.session == session:
            self._rival = None
        if held is None or held.session != session:
            return False
        self._holder = None
        self._in_vain.clear()
        return True

    def until_ns(self) -> int | None:
        """Give when it, or an ask for it, ends by itself; none while free."""
        times = [holder.until_ns for holder in (self._holder, self._rival) if holder is not None]
        return min(times, default=None)

    def drop_lease(self) -> LeaseHolder | None:
        """End it whoever holds it or asks for it, and give who held it."""
        held, self._holder, self._rival = self._holder, None, None
        self._in_vain.clear()
        return held

    def withdraw_rival(self) -> None:
        """Forget who asks."""
        self._rival = None

    def _grant_lease(self, session: str, who: str, now_ns: int) -> None:
        # The number first: when the disk refuses, nothing below has changed yet.
        before, epoch = self._holder, self._next_epoch()
        self._holder = LeaseHolder(session, who, epoch, now_ns + self._duration_ns)
        if self._rival is not None and self._rival.session == session:
            self._rival = None
        # The same session took it anew: who was refused by it was refused by this very holder.
        if before is not None and before.session == session:
            return
        # Another holder was asked nothing yet: who still waits asks this one, with all its time.
        self._in_vain.clear()
        if self._rival is not None:
            self._rival = self._rival._replace(until_ns=now_ns + ANSWER_NS)
