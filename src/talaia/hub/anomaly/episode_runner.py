"""What judges at the hub, one signal or several: its score, its anomalies and their reasons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import msgspec

from talaia.hub.anomaly.budget.score_tail import ScoreTail
from talaia.hub.anomaly.episodes import Episodes, EpisodeTurn

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.anomaly.groups.whitening import SignalShare
    from talaia.hub.anomaly.kinds import RegisteredDetector

__all__ = [
    "SCORES",
    "AnomalyBegan",
    "AnomalyEnded",
    "EpisodeRunner",
    "excess_of",
    "score_address",
    "shares_of",
    "signal_of",
    "tail_word",
]

# Between a signal's address and the detector; no other address holds it.
SCORES = "~"
# A score is written down when it has moved so far, and at least this often (µs).
_MOVED = 0.05
_EVERY_US = 60_000_000


def score_address(address: str, detector: str) -> str:
    """Name the channel on which a detector's scores are kept, beside the signal's own."""
    return f"{address}{SCORES}{detector}"


def tail_word(word: str) -> str:
    """Name what is kept beside a detector: the greatest of what it has said."""
    return f"{word}{SCORES}tail"


def signal_of(address: str) -> str:
    """Give the signal's address for a channel of scores; every other address as it is."""
    return address.partition(SCORES)[0]


def excess_of(runner: EpisodeRunner, score: float) -> float:
    """Say how far a score is beyond its detector's bar, of what is left up to 1: 0 to 1."""
    bar = runner.episodes.bar
    return min(1.0, max(0.0, (score - bar) / max(1e-9, 1.0 - bar)))


def shares_of(runner: EpisodeRunner) -> tuple[tuple[str, float], ...]:
    """Give what each signal of a group has to do with its newest anomaly, by address."""
    return tuple((runner.members[one.place], one.share) for one in runner.shares)


@dataclass(frozen=True, slots=True)
class AnomalyBegan:
    """An anomaly begins: when (µs), its score and why."""

    time_us: int
    score: float
    why: str


@dataclass(frozen=True, slots=True)
class AnomalyEnded:
    """An anomaly is over: from its first to its last high sample (µs), its greatest score, why."""

    began_us: int
    ended_us: int
    score: float
    why: str


class EpisodeRunner:
    """A detector at work; what it looks at is told by those derived from it.

    Attributes:
        address: of the signal, or of the group.
        word: the detector's name.
        kind: what is known of such detectors.
        episodes: when an anomaly begins and ends.
        score: the newest.
        why: of the anomaly that is on, or of the last one.
        says_why: whether anybody asks for it; without it ``why`` stays empty.
        from_us: when the newest anomaly began (µs); 0 before the first.
        to_us: its last high sample (µs); 0 while it is on.
        forgiven: whether a person said that the newest anomaly was none.
        confirmed: whether a person said that it was one.
        known: of the newest anomaly, by which word of a person nobody is told; empty: they are.
        changed: whether it has learned since it was kept last.
        late: samples that were older than the newest, and not looked at.
        members: addresses of the signals of a group; of a single signal none.
        needs: for each of its `magnitudes`, from where on an anomaly may begin; empty: the score
            alone tells.
        tail: the greatest magnitudes of the past, by which `needs` are set; None: nobody asks.
        shares: what each of them had to do with the newest anomaly, the greatest first.
        mode: the way of running that a group is in, in words; empty where it has one.

    """

    members: Sequence[str] = ()

    def __init__(
        self, address: str, word: str, *, kind: RegisteredDetector, episodes: Episodes
    ) -> None:
        """Begin with nothing seen."""
        self.address, self.word, self.kind, self.episodes = address, word, kind, episodes
        self.score, self.why, self.changed, self.late = 0.0, "", False, 0
        self.from_us, self.to_us, self.forgiven, self.confirmed = 0, 0, False, False
        self.known, self.says_why = "", True
        self.needs: tuple[float, ...] = ()
        self.tail: ScoreTail | None = None
        self.shares: list[SignalShare] = []
        # Its learning has ended, or other signals lead, since `take_change` was last asked.
        self._stands_otherwise = False
        # When the last score was written (µs), and which; -1 differs from every score.
        self._written_us, self._written = -1, -1.0

    @property
    def mode(self) -> str:
        """The way of running that it is in, in words; empty where it has one."""
        return ""

    @property
    def asked(self) -> bytes:
        """What it was asked to look for: by something else it has learned nothing."""
        return b""

    @property
    def learning(self) -> int:
        """So many samples until it has learned; before, it tells of what is clear at the most."""
        return self.episodes.learning

    def reason(self) -> str:
        """Say in words what the newest score stands on."""
        return ""

    def dump_state(self) -> bytes:
        """Give what is to be kept over a restart."""
        return b""

    def score_silence(self, time_us: int) -> AnomalyBegan | AnomalyEnded | None:
        """Look at the clock: some detectors are about what does not come."""
        return None

    def dismiss_peak(self) -> bool:
        """Learn that the newest peak was no anomaly; false where nothing can be learned."""
        return False

    def take_change(self) -> bool:
        """Tell once that it stands otherwise, though no anomaly began or ended."""
        changed, self._stands_otherwise = self._stands_otherwise, False
        return changed

    def update_score(self, time_us: int, score: float) -> AnomalyBegan | AnomalyEnded | None:
        """Take the next score in; tell when an anomaly begins or ends with it."""
        self.score = score
        learning = self.episodes.learning
        turn = self.episodes.update_score(
            time_us, score, may_begin=self._is_strong(time_us, score, learning)
        )
        # True in the one step in which the learning ends.
        self._stands_otherwise |= learning > 0 and not self.episodes.learning
        if turn is EpisodeTurn.BEGAN:
            self.why = self.reason() if self.says_why else ""
            self.from_us, self.to_us, self.forgiven, self.confirmed = time_us, 0, False, False
            return AnomalyBegan(time_us, score, self.why)
        return self._close_episode() if turn is EpisodeTurn.ENDED else None

    def magnitudes(self) -> tuple[float, ...]:
        """Give what the newest score stands on; empty where no budget can be kept with it."""
        return ()

    def set_needs(self, needs: tuple[float, ...]) -> None:
        """Let an anomaly begin only with such a magnitude; empty: by its score alone."""
        self.needs = needs

    def counts_peak(self, score: float) -> bool:
        """Tell whether an anomaly would begin with such a score, if all magnitudes were enough."""
        return score >= self.episodes.bar

    def dump_tail(self) -> bytes:
        """Give the tail to be kept over a restart; the runner has one."""
        return msgspec.msgpack.encode((self.asked, self.tail))

    def restore_tail(self, kept: bytes) -> None:
        """Go on with a tail that was kept, if it is of the same question."""
        try:
            asked, tail = msgspec.msgpack.decode(kept, type=tuple[bytes, ScoreTail])
        except msgspec.MsgspecError:
            # Of another version: it is filled from the history again.
            return
        if asked == self.asked:
            self.tail = tail

    def _is_strong(self, time_us: int, score: float, learning: int) -> bool:
        if self.tail is not None and not learning:
            self.tail.see_time(time_us)
        if not self.counts_peak(score):
            # Most samples: nothing begins with them anyway.
            return True
        rated = self.magnitudes()
        if self.tail is not None and not learning and rated:
            self.tail.record_magnitudes(time_us, rated)
        if len(self.needs) != len(rated):
            return True
        return not rated or any(one >= need for one, need in zip(rated, self.needs, strict=True))

    def pass_calm(self, score: float, many: int) -> None:
        """Take so many scores in at once of which none is an anomaly; ``score`` is the newest."""
        self.score, learning = score, self.episodes.learning
        self.episodes.pass_calm(many)
        self._stands_otherwise |= learning > 0 and not self.episodes.learning

    def end_anomaly(self) -> AnomalyEnded | None:
        """End an anomaly that is on, because nobody watches any more."""
        return None if self.episodes.began_us < 0 else self._close_episode()

    def _close_episode(self) -> AnomalyEnded:
        ended = AnomalyEnded(*self.episodes.end_episode(), self.why)
        self.to_us = ended.ended_us
        return ended

    def worth_writing(self, time_us: int) -> bool:
        """Tell whether the newest score is news against the one written last, and take it so."""
        moved = abs(self.score - self._written) >= _MOVED
        if not moved and time_us - self._written_us < _EVERY_US:
            return False
        self._written, self._written_us = self.score, time_us
        return True
