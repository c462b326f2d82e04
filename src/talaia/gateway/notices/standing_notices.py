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
    message: str
    time_us: int
    # When it began to stand, or the hub went away: whichever was later.
    alone_ns: int
    due_ns: int | None = None
    wait_ns: int = 0
    told: int = 0


class StandingNotices:
    """Keeps time for what stands. The hub, while it has a link, tells people by itself."""

    def __init__(self, settings: NoticeSettings, teller: str = HUB_AWAY) -> None:
        """Begin with nothing; ``teller`` is the sentence that says who tells."""
        self._settings = settings
        self._teller = teller
        self._standing: dict[str, _Standing] = {}
        self._over: list[GatewayNotice] = []
        self._linked = False

    def stand(self, what: str, message: str, time_us: int, now_ns: int) -> None:
        """Take that something stands (again with other words: it goes on)."""
        known = self._standing.get(what)
        if known is None:
            self._standing[what] = _Standing(message, time_us, now_ns)
        else:
            known.message = message

    def clear(self, what: str, time_us: int, message: str = "") -> None:
        """Take that it stands no longer: whoever was told of it is told that, too.

        ``message`` says what has become of it, where *over* is not all.
        """
        known = self._standing.pop(what, None)
        if known is not None and known.told and not self._linked:
            key = f"{what}-{known.time_us}-over"
            said = message or f"over: {known.message}"
            self._over.append(
                GatewayNotice(key, what, said, time_us, over=True, teller=self._teller)
            )

    def due(self, now_ns: int, *, linked: bool) -> list[GatewayNotice]:
        """Give what is to be told now; nothing while the hub has a link."""
        if linked:
            self._linked = True
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
                notice.due_ns = notice.alone_ns + round(self._settings.after * SECOND)
            if now_ns < notice.due_ns:
                continue
            longest = round(self._settings.longest * SECOND)
            first = round(self._settings.repeat * SECOND)
            notice.wait_ns = (
                min(longest, 2 * notice.wait_ns) if notice.wait_ns else min(longest, first)
            )
            notice.due_ns = now_ns + notice.wait_ns
            notice.told += 1
            key = f"{what}-{notice.time_us}-{notice.told}"
            told.append(
                GatewayNotice(key, what, notice.message, notice.time_us, teller=self._teller)
            )
        return told
