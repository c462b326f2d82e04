"""Which hubs are there, by what they said last. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["BEAT_S", "SILENT_S", "HubNotice", "KnownHub", "Peers"]

# A hub says so often that it is there (s), and counts as gone after this silence: no later than a
# page takes a lost link for lost.
BEAT_S = 0.5
SILENT_S = 2.0
# A lead that is gone is replaced within this, in most cases (s).
TAKE_OVER_S = 5.0
# One that has gone is shown so long (s).
_SHOWN_S = 86_400.0
_MOST_KNOWN = 200


class HubNotice(msgspec.Struct, frozen=True, kw_only=True):
    """What a hub says of itself.

    Attributes:
        hub: this run of it; another run has another name.
        name: for people, as its start named it.
        leads: it decides, and keeps everything; of two, the one with the higher ``epoch`` does.
        epoch: how often the lead has changed, by the database, when it became the lead.
        leaving: it ends; nothing new is to go there.
        opens: it has the database's lock, and is about to lead.
        losses: how often it has lost the bus: what was under way to it before is over.
        since_us: when it started (UTC, by its own clock).
        cpu: share of a core that it takes.
        memory_bytes: of its process.
        database_ms: how long the database took to answer; 0: not known.
        gateways: links of gateways that came in here.
        sockets: all other sockets that came in here.
        shards: those that this process leads, where sites are divided; said at the main one alone.

    """

    hub: str
    name: str
    version: str
    leads: bool = False
    epoch: int = 0
    leaving: bool = False
    opens: bool = False
    losses: int = 0
    since_us: int = 0
    cpu: float = 0.0
    memory_bytes: int = 0
    database_ms: float = 0.0
    gateways: int = 0
    sockets: int = 0
    shards: tuple[str, ...] = ()


class KnownHub(NamedTuple):
    """A hub, as it was heard last."""

    notice: HubNotice
    heard_ns: int


class Peers:
    """The other hubs."""

    def __init__(self) -> None:
        """Know none."""
        self._known: dict[str, KnownHub] = {}
        # When each handed a request over (monotonic, ns), whether or not it has said more yet.
        self._asked_ns: dict[str, int] = {}

    def __iter__(self) -> Iterator[KnownHub]:
        """Go through all that were heard of, by name."""
        return iter(sorted(self._known.values(), key=lambda known: known.notice.name))

    def hear_notice(self, notice: HubNotice, now_ns: int) -> bool:
        """Take what a hub says (monotonic); tell whether it has lost the bus since it said more."""
        before = self._known.get(notice.hub)
        for hub, known in list(self._known.items()):
            # The same place, started anew; or one of long ago.
            replaced = known.notice.name == notice.name and hub != notice.hub
            forgotten = now_ns - known.heard_ns > _SHOWN_S * 1e9
            if forgotten or (replaced and now_ns - known.heard_ns > SILENT_S * 1e9):
                del self._known[hub]
        if notice.hub in self._known or len(self._known) < _MOST_KNOWN:
            self._known[notice.hub] = KnownHub(notice, now_ns)
        return before is not None and before.notice.losses != notice.losses

    def hear_request(self, hub: str, now_ns: int) -> None:
        """Take a request as a sign of life: once the bus is back it may come before the notice."""
        self._asked_ns.pop(hub, None)
        self._asked_ns[hub] = now_ns
        if len(self._asked_ns) > _MOST_KNOWN:
            # The one that has asked for nothing for the longest.
            del self._asked_ns[next(iter(self._asked_ns))]

    def silence_all(self) -> None:
        """Take all as gone: the bus is, so nobody can be heard."""
        self._asked_ns.clear()
        self._known = {hub: KnownHub(known.notice, -(10**18)) for hub, known in self._known.items()}

    def is_living(self, hub: str, now_ns: int) -> bool:
        """Tell whether a hub was heard a moment ago."""
        known = self._known.get(hub)
        heard_ns = max(known.heard_ns if known else -(10**18), self._asked_ns.get(hub, -(10**18)))
        return now_ns - heard_ns <= SILENT_S * 1e9

    def hears_lead(self, now_ns: int) -> bool:
        """Tell whether a hub leads, or is about to; one without the database will soon not."""
        return any(
            (known.notice.opens or (known.notice.leads and known.notice.database_ms > 0))
            and not known.notice.leaving
            and now_ns - known.heard_ns <= SILENT_S * 1e9
            for known in self._known.values()
        )

    def led_lately(self, now_ns: int) -> bool:
        """Tell whether a hub leads, or did so a moment ago: another one is about to."""
        within_ns = (SILENT_S + TAKE_OVER_S) * 1e9
        return any(
            known.notice.leads and now_ns - known.heard_ns <= within_ns
            for known in self._known.values()
        )

    def find_lead(self, now_ns: int) -> HubNotice | None:
        """Give the hub that leads; None: none is heard that does."""
        # That one has the lock; one that still says that it leads does not know it yet.
        if any(
            known.notice.opens and not known.notice.leaving
            for known in self._known.values()
            if now_ns - known.heard_ns <= SILENT_S * 1e9
        ):
            return None
        leading = [
            known.notice
            for known in self._known.values()
            if known.notice.leads
            and not known.notice.leaving
            and now_ns - known.heard_ns <= SILENT_S * 1e9
        ]
        # After a split two say so for a moment: the database knows only the newer one.
        return max(leading, key=lambda notice: notice.epoch, default=None)
