"""Whether the other side is still there: a beat each second, three unanswered are enough. Pure."""

from __future__ import annotations

from talaia.clock import SECOND
from talaia.wire.frames import Beat, BeatReply

__all__ = ["HeartbeatMonitor", "reply_to"]


class HeartbeatMonitor:
    """The beats of one connection, ours and its answers."""

    # s; three unanswered make 3 s, in which a robot has stopped by its own watchdog long before.
    PERIOD_S = 1.0
    MISSED = 3

    def __init__(self, now_ns: int) -> None:
        """Begin with nothing asked."""
        self._asked = 0  # Number of the newest beat of ours.
        # The newest that the peer answered; answers that were overtaken do not lower it.
        self._answered = 0
        self._turn_ns = now_ns  # When this process last showed that it runs (monotonic ns).
        self.round_trip_ms = 0.0  # Of the newest answered beat, ms.

    @property
    def dead(self) -> bool:
        """Tell whether the peer counts as gone."""
        return self._asked - self._answered >= self.MISSED

    def next(self, now_ns: int) -> Beat:
        """Ask."""
        self._asked += 1
        self._turn_ns = now_ns
        return Beat(n=self._asked, mono_us=now_ns // 1000)

    def answered(self, reply: BeatReply, now_ns: int) -> None:
        """Note an answer. One to a beat we never sent changes nothing."""
        if self._answered < reply.n <= self._asked:
            self._answered = reply.n
            self.round_trip_ms = (now_ns // 1000 - reply.mono_us) / 1000

    def pulse(self, now_ns: int) -> None:
        """Note that this process runs; once it has stood still, that is not forgotten."""
        # A freeze stays visible: setting the time anew here would hide it from `_check_awake`.
        if self.stood_still_s(now_ns) == 0:
            self._turn_ns = now_ns

    def stood_still_s(self, now_ns: int) -> float:
        """Tell how long this process has not run (s), beyond what is usual.

        After a freeze, what waits in the socket may be as old as the freeze, and says nothing of
        its age: it must not be acted on.
        """
        return max(0.0, (now_ns - self._turn_ns) / SECOND - 2 * self.PERIOD_S)


def reply_to(beat: Beat, now_ns: int) -> BeatReply:
    """Answer the peer's beat."""
    return BeatReply(n=beat.n, mono_us=beat.mono_us, peer_us=now_ns // 1000)
