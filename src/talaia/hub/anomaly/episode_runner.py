"""What judges at the hub, one signal or several: its score, its anomalies and their reasons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

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
    "score_address",
    "signal_of",
]

# Between a signal's address and the detector; no other address holds it.
SCORES = "~"
# A score is written down when it has moved so far, and at least this often (µs).
_MOVED = 0.05
_EVERY_US = 60_000_000


def score_address(address: str, detector: str) -> str:
    """Name the channel on which a detector's scores are kept, beside the signal's own."""
    return f"{address}{SCORES}{detector}"


def signal_of(address: str) -> str:
    """Give the signal's address for a channel of scores; every other address as it is."""
    return address.partition(SCORES)[0]


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
        from_us: when the newest anomaly began (µs); 0 before the first.
        to_us: its last high sample (µs); 0 while it is on.
        forgiven: whether a person said that the newest anomaly was none.
        changed: whether it has learned since it was kept last.
        late: samples that were older than the newest, and not looked at.
        members: addresses of the signals of a group; of a single signal none.
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
        self.from_us, self.to_us, self.forgiven = 0, 0, False
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
        turn = self.episodes.update_score(time_us, score)
        # True in the one step in which the learning ends.
        self._stands_otherwise |= learning > 0 and not self.episodes.learning
        if turn is EpisodeTurn.BEGAN:
            self.why = self.reason()
            self.from_us, self.to_us, self.forgiven = time_us, 0, False
            return AnomalyBegan(time_us, score, self.why)
        return self._close_episode() if turn is EpisodeTurn.ENDED else None

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
