"""Which critical things stand, and when the gateway itself tells people of them. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND

if TYPE_CHECKING:
    from talaia.gateway.notices.settings import NoticeSettings

__all__ = ["HUB_AWAY", "GatewayNotice", "StandingNotices"]

HUB_AWAY = "Told by the site's gateway itself, for its hub is away."


class GatewayNotice(NamedTuple):
    """One message.

    Attributes:
        key: names it; each repetition has another.
        message: what stands, or what has become of it.
        time_us: since when it stands, or stands no longer (UTC).
        over: it stands no longer.
        teller: the sentence that says who tells.

    """

    key: str
    what: str
    message: str
    time_us: int
    over: bool = False
    teller: str = HUB_AWAY


@dataclass(slots=True)
class _Standing:
    message: str  # What is said now; may change while it stands.
    time_us: int  # Since when it stands (µs, UTC), for people.
    # When it began to stand, or the hub went away: whichever was later.
    alone_ns: int
    # When it is told next (monotonic); None: to be counted from `alone_ns`.
    due_ns: int | None = None
    wait_ns: int = 0  # How long it was waited after the last telling; 0: not told yet.
    told: int = 0  # How often it was told; part of the next notice's key.


class StandingNotices:
    """Keeps time for what stands. The hub, while it has a link, tells people by itself."""

    def __init__(self, settings: NoticeSettings, teller: str = HUB_AWAY) -> None:
        """Begin with nothing; ``teller`` is the sentence that says who tells."""
        self._settings = settings
        self._teller = teller
        self._standing: dict[str, _Standing] = {}  # By what it is about.
        # What is over, and was told while it stood; until the next `due_notices`.
        self._over: list[GatewayNotice] = []
        self._linked = False  # How it was at the last `due_notices`.

    def raise_notice(self, what: str, message: str, time_us: int, now_ns: int) -> None:
        """Take that something stands (again with other words: it goes on)."""
        known = self._standing.get(what)
        if known is None:
            self._standing[what] = _Standing(message, time_us, now_ns)
        else:
            known.message = message

    def clear_notice(self, what: str, time_us: int, message: str = "") -> None:
        """Take that it stands no longer: whoever was told of it is told that, too.

        ``message`` says what has become of it, where *over* is not all.
        """
        known = self._standing.pop(what, None)
        # Only those who were told of it: the others never heard that anything stood.
        if known is not None and known.told and not self._linked:
            key = f"{what}-{known.time_us}-over"
            said = message or f"over: {known.message}"
            self._over.append(
                GatewayNotice(key, what, said, time_us, over=True, teller=self._teller)
            )

    def due_notices(self, now_ns: int, *, linked: bool) -> list[GatewayNotice]:
        """Give what is to be told now; nothing while the hub has a link."""
        if linked:
            self._linked = True
            # The hub tells of it by itself.
            self._over.clear()
            return []
        if self._linked:
            # The hub has heard of all that stood; what stands on is counted anew.
            self._linked = False
            for notice in self._standing.values():
                notice.alone_ns, notice.due_ns, notice.wait_ns = now_ns, None, 0
        told, self._over = self._over, []
        for what, notice in self._standing.items():
            if notice.due_ns is None:
                # Not at once: the link may be back before anybody could act.
                notice.due_ns = notice.alone_ns + round(self._settings.after * SECOND)
            if now_ns < notice.due_ns:
                continue
            longest = round(self._settings.longest * SECOND)
            first = round(self._settings.repeat * SECOND)
            notice.wait_ns = (
                # Twice as long each time, up to the longest: told again, but nobody is worn out.
                min(longest, 2 * notice.wait_ns) if notice.wait_ns else min(longest, first)
            )
            notice.due_ns = now_ns + notice.wait_ns
            notice.told += 1
            key = f"{what}-{notice.time_us}-{notice.told}"
            told.append(
                GatewayNotice(key, what, notice.message, notice.time_us, teller=self._teller)
            )
        return told
