"""How much a gateway may say: an allowance for each kind of frame, refilled with time. Pure.

Whoever is over one is slowed: the hub reads on only when the allowance has refilled. Whoever stays
over it is cut off, and held off for a while. The allowances belong to the site and not to the
link, so that to dial again brings no new ones.

Samples are slowed at the most. A gateway that comes back after a long break sends what it has kept
as fast as it is acknowledged, which may be for hours, and that is as it should be.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.wire import frames

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.wire.message import Message

__all__ = [
    "DIALS",
    "DIALS_BACK",
    "HELD_S",
    "LONGEST_OVER_S",
    "ROWS",
    "UNKNOWN",
    "Allowance",
    "FrameLimits",
    "Verdict",
    "frame_kind",
]


class Allowance(NamedTuple):
    """How many of a kind may come.

    Attributes:
        rate: in the long run (1/s).
        burst: at once, after a time in which fewer came.
        per_thing: by so much the rate is higher for each thing that is described (1/s).
        cuts: who stays over it is cut off; else it is slowed at the most.

    """

    rate: float
    burst: float
    per_thing: float = 0.0
    cuts: bool = True


class Verdict(NamedTuple):
    """What becomes of a frame: read on after ``wait_s``; end the link by ``cut_off``."""

    wait_s: float = 0.0
    slowed: bool = False
    cut_off: bool = False


# Rows of the audit log. A gateway keeps at most some thousands over a lost link.
ROWS = Allowance(rate=10.0, burst=5_000.0)
# Some tens of frames a second come live; what was kept comes in frames of thousands of samples.
_SAMPLES = Allowance(rate=2_000.0, burst=20_000.0, cuts=False)
# Beats are said once a second, and time marks for drivers twenty times.
_BEATS = Allowance(rate=100.0, burst=2_000.0)
# States of devices, interlocks and enclosures: all of them at once on a new link, then by changes.
_STATES = Allowance(rate=200.0, burst=5_000.0, per_thing=20.0)
# Each is up to 4 MiB, and is read, stored and told.
_DESCRIPTIONS = Allowance(rate=0.5, burst=30.0)
# Sightings and nights have limits of their own, too.
_REPORTS = Allowance(rate=100.0, burst=5_000.0)

# Connections that are opened: three for each link. A line that flaps is let in as often as it can.
_DIALS = Allowance(rate=3.0, burst=300.0)
# Of kinds that this hub does not know, and skips: a newer gateway says some on each link.
_UNKNOWN = Allowance(rate=10.0, burst=1_000.0)
# Tens a second for each camera, and what is seen on each.
_PICTURES = Allowance(rate=1_000.0, burst=5_000.0)
# Messages of raw topics come as fast as the line takes them; they are thinned behind this.
_TAPS = Allowance(rate=5_000.0, burst=50_000.0, cuts=False)
# Lists of topics, definitions, and what cannot be shown or heard.
_ABOUT_TAPS = Allowance(rate=50.0, burst=2_000.0)
# Each makes a file and a row; a gateway that comes back has a night's pictures.
_OFFERS = Allowance(rate=20.0, burst=2_000.0)
# Each is answered before the next one comes.
_PIECES = Allowance(rate=2_000.0, burst=20_000.0, cuts=False)

_KINDS: dict[type[Message], tuple[str, Allowance]] = {
    frames.SampleBatch: ("samples", _SAMPLES),
    frames.NewestBatch: ("samples", _SAMPLES),
    frames.SampleGap: ("gaps", _SAMPLES),
    frames.Beat: ("beats", _BEATS),
    frames.BeatReply: ("beats", _BEATS),
    frames.DescriptionUpdate: ("descriptions", _DESCRIPTIONS),
    frames.SightingReport: ("sightings", _REPORTS),
    frames.RobotLogBatch: ("robot log", _REPORTS),
    frames.NightState: ("night", _REPORTS),
    frames.NightPlan: ("night", _REPORTS),
    frames.RequestRevision: ("night", _REPORTS),
    frames.ObservationUpdate: ("night", _REPORTS),
    frames.PictureFrame: ("pictures", _PICTURES),
    frames.DetectedBoxes: ("boxes", _PICTURES),
    frames.ModelOverlay: ("overlays", _PICTURES),
    frames.StreamError: ("topics", _ABOUT_TAPS),
    frames.TapMessage: ("taps", _TAPS),
    frames.TopicList: ("topics", _ABOUT_TAPS),
    frames.TapSchema: ("topics", _ABOUT_TAPS),
    frames.TapError: ("topics", _ABOUT_TAPS),
    frames.FileOffer: ("files", _OFFERS),
    frames.FilmOffer: ("films", _OFFERS),
    frames.ArchiveOffer: ("pictures for the archive", _OFFERS),
    frames.FilePiece: ("pieces of files", _PIECES),
    frames.ReleaseRequest: ("pieces of releases", _PIECES),
    frames.ReleaseState: ("releases", _ABOUT_TAPS),
    frames.AssetState: ("meshes", _ABOUT_TAPS),
}
DIALS, UNKNOWN = "connections", "unknown messages"
DIALS_BACK = "connections of the gateway that was here before"
_ALLOWANCES = {
    **dict(_KINDS.values()),
    DIALS: _DIALS,
    DIALS_BACK: _DIALS,
    UNKNOWN: _UNKNOWN,
}
# Nobody owes more than what comes back in so long (s).
_MOST_OWED_S = 10.0
# So long over an allowance without a pause, and the link ends (s).
LONGEST_OVER_S = 20.0
# And so long nobody is let in by its key (s).
HELD_S = 60.0
# When to come back if only the log has no room for it (s).
_ROWS_OVER_S = 10.0


def frame_kind(message: Message) -> str:
    """Name the kind by which a message is counted."""
    known = _KINDS.get(type(message))
    return str(type(message).__struct_config__.tag) if known is None else known[0]


class FrameLimits:
    """What one site's gateways have left of each allowance.

    Attributes:
        rows: the last row that was over; taken by whoever reads the link.

    """

    def __init__(
        self,
        rows: Allowance = ROWS,
        *,
        longest_over_s: float = LONGEST_OVER_S,
        others: Mapping[str, Allowance] = _ALLOWANCES,
    ) -> None:
        """Begin with all of it; ``rows`` is that of the audit log, ``others`` are by kind."""
        self._rows = rows
        self._others = others
        self._longest_over_s = longest_over_s
        # Nobody is let in before (monotonic), for what the gateway of this lineage did.
        self._held_until_ns = 0
        self._held_by = 0
        # The lowest lineage that was shown, and that of who was linked last.
        self._oldest = self._linked = 0
        self.rows: Verdict | None = None
        # By kind: what is left (negative: owed), when that was reckoned, since when it is over.
        self._left: dict[str, float] = {}
        self._reckoned: dict[str, int] = {}
        self._over_since: dict[str, int] = {}
        self._told_ns = -SECOND * 10**6

    def charge(self, kind: str, now_ns: int, *, described: int = 0) -> Verdict:
        """Count one of ``kind``.

        ``described`` is how many devices, interlocks and enclosures the site has.
        """
        allowance = self._rows if kind == "rows" else self._others.get(kind, _STATES)
        rate = allowance.rate + allowance.per_thing * described
        burst = allowance.burst + allowance.per_thing * described
        passed_s = (now_ns - self._reckoned.get(kind, now_ns)) / SECOND
        left = min(burst, self._left.get(kind, burst) + passed_s * rate) - 1.0
        # Bounded, for one flood must not be paid for all night.
        left = max(left, -_MOST_OWED_S * rate)
        self._left[kind], self._reckoned[kind] = left, now_ns
        if left >= 0:
            # What a second brings has to be left again before a flood counts as over: who is
            # slowed is never over by much.
            if left > rate:
                self._over_since.pop(kind, None)
            return Verdict()
        # The first moment counts: a flood with short pauses is one flood.
        since = self._over_since.setdefault(kind, now_ns)
        over_s = (now_ns - since) / SECOND
        cut_off = allowance.cuts and over_s > self._longest_over_s
        return Verdict(-left / rate, slowed=True, cut_off=cut_off)

    def recognise_oldest(self, lineage: int) -> bool:
        """Tell whether who shows this lineage was here before all others; remember the oldest.

        A thief of the key has a younger one, or none: hubs number them by time.
        """
        if not lineage or 0 < self._oldest < lineage:
            return False
        if lineage != self._oldest:
            self._oldest = lineage
            # What a younger one has used up is not its debt.
            self._forget_kind(DIALS_BACK)
        return True

    def begin_link(self, shown: int, issued: int) -> None:
        """Begin anew for who was here before all others, after another was linked.

        ``shown`` is the lineage that it has shown (0: none), ``issued`` that of its place now.
        """
        if self.recognise_oldest(shown) and shown != self._linked:
            # A list: kinds are taken out while it is gone through.
            for kind in [kind for kind in self._left if kind not in {DIALS, DIALS_BACK}]:
                self._forget_kind(kind)
            self.rows = None
        self._linked = issued

    def hold(self, now_ns: int, lineage: int) -> None:
        """Let nobody in for a while, for what the gateway of a lineage did (0: of none)."""
        self._held_until_ns = now_ns + int(HELD_S * SECOND)
        self._held_by = lineage
        # When it comes back, the time that it is over begins anew.
        self._over_since.clear()

    def held_s(self, now_ns: int, lineage: int) -> float:
        """Give for how long a gateway is not let in yet; 0: it is.

        Who was here before all others does not wait for what another did with its key.
        """
        if self.recognise_oldest(lineage) and lineage != self._held_by:
            return 0.0
        held_s = max(0.0, (self._held_until_ns - now_ns) / SECOND)
        # Comings and goings are written down as well: one that dials without end fills the log.
        return max(held_s, _ROWS_OVER_S if self._is_over("rows", now_ns) else 0.0)

    def _forget_kind(self, kind: str) -> None:
        for ledger in (self._left, self._reckoned, self._over_since):
            ledger.pop(kind, None)

    def _is_over(self, kind: str, now_ns: int) -> bool:
        """Tell whether there is none left of an allowance that is the same for every site."""
        allowance = self._rows if kind == "rows" else self._others[kind]
        passed_s = (now_ns - self._reckoned.get(kind, now_ns)) / SECOND
        return self._left.get(kind, allowance.burst) + passed_s * allowance.rate < 0

    def first_told(self, now_ns: int) -> bool:
        """Tell whether people are to be told of a flood: once in a while."""
        # As long as a hold lasts: who floods anew after it is told of anew.
        if now_ns - self._told_ns < HELD_S * SECOND:
            return False
        self._told_ns = now_ns
        return True
