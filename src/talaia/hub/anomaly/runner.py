"""One signal with one detector as the hub runs them: scores in, anomalies and their reasons out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import msgspec

from talaia.extensions.declarations import DetectorExtension
from talaia.extensions.installed import installed_extensions
from talaia.hub.anomaly.base import AnomalyDetector, dump_detector, load_detector
from talaia.hub.anomaly.baseline import Quartiles
from talaia.hub.anomaly.episodes import Episodes, EpisodeTurn
from talaia.hub.anomaly.guarded import GuardedDetector, extension_detector
from talaia.hub.anomaly.kinds import KINDS, RegisteredDetector, kind_of
from talaia.hub.anomaly.simple_rules import LimitsDetector, Missing, RateOfChange, Still
from talaia.model.alarms.anomaly import DetectorKind

if TYPE_CHECKING:
    from talaia.model.alarms.anomaly import Watch

__all__ = [
    "SCORES",
    "AnomalyBegan",
    "AnomalyEnded",
    "DetectorRunner",
    "detector_of",
    "score_address",
    "signal_of",
]

# Between a signal's address and the detector; no other address holds it.
SCORES = "~"
# An extension that is not installed here: nobody judges by it.
_MISSING = RegisteredDetector(AnomalyDetector, 1.0, "not installed at this hub", learns=False)
# A score is written down when it has moved so far, and at least this often (µs).
_MOVED = 0.05
_EVERY_US = 60_000_000
# What is kept: the watch, the detector, and the counts of its episodes: since, quiet, learning.
_KEPT = tuple[bytes, bytes, tuple[int, int, int]]


def score_address(address: str, detector: str) -> str:
    """Name the channel on which a detector's scores are kept, beside the signal's own."""
    return f"{address}{SCORES}{detector}"


def signal_of(address: str) -> str:
    """Give the signal's address for a channel of scores; every other address as it is."""
    return address.partition(SCORES)[0]


def detector_of(watch: Watch, unit: str) -> AnomalyDetector | GuardedDetector:
    """Make a new detector as a description asks for it.

    One of an extension that is not installed, or that cannot be made, sees nothing.
    """
    match watch.detector:
        case DetectorKind.EXTENSION:
            return _of_extension(watch, unit)
        case "iqr":
            return Quartiles(unit=unit, k=watch.k)
        case "still":
            return Still(unit=unit, within=watch.within, after_s=watch.after)
        case "missing":
            return Missing(unit=unit, after_s=watch.after)
        case "rate":
            return RateOfChange(unit=unit, most=watch.most)
        case "limits":
            return LimitsDetector(unit=unit, minimum=watch.minimum, maximum=watch.maximum)
        case _:
            return KINDS[watch.detector].make(unit=unit)


def _of_extension(watch: Watch, unit: str) -> GuardedDetector:
    def fail(problem: str) -> None:
        installed_extensions().note_failure(DetectorExtension, watch.extension, problem)

    found = installed_extensions().detectors_by_name().get(watch.extension)
    guarded = GuardedDetector(AnomalyDetector(unit=unit), fail)
    if found is None:
        guarded.off = "it is not installed at this hub"
        fail(f"{guarded.off}, and a site asks for it")
        return guarded
    try:
        guarded.detector = extension_detector(watch, unit, found)
    except Exception as error:  # noqa: BLE001 - whatever it raises, it is named
        guarded.off = f"it cannot be made: {type(error).__name__}: {error}"
        fail(guarded.off)
    return guarded


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


class DetectorRunner:
    """A detector at work.

    Attributes:
        address: of the signal.
        watch: as the description has it.
        word: the detector's name.
        kind: what is known of such detectors.
        score: the newest.
        why: of the anomaly that is on, or of the last one.
        from_us: when the newest anomaly began (µs); 0 before the first.
        to_us: its last high sample (µs); 0 while it is on.
        forgiven: whether a person said that the newest anomaly was none.
        changed: whether it has learned since it was kept last.
        late: samples that were older than the newest, and not looked at.

    """

    def __init__(self, address: str, unit: str, watch: Watch, kept: bytes | None = None) -> None:
        """Go on with what was ``kept``; begin anew where there is nothing, or it does not fit."""
        self.address, self.unit, self.watch = address, unit, watch
        self.word = watch.detector_name()
        self.detector = detector_of(watch, unit)
        self.kind = kind = kind_of(watch, installed_extensions().detectors_by_name()) or _MISSING
        self.episodes = Episodes(
            bar=watch.bar or kind.bar,
            rest=watch.rest,
            quiet=kind.quiet,
            learning=kind.learning,
        )
        self.score, self.why, self.changed, self.late = 0.0, "", False, 0
        self.from_us, self.to_us, self.forgiven = 0, 0, False
        # Its learning has ended since `take_learned` was last asked.
        self._learned = False
        # Times of the newest sample and of the last score that was written (µs); -1: none.
        self._newest_us = self._written_us = -1
        # The last score that was written; -1 differs from every score.
        self._written = -1.0
        if kept is not None:
            self._restore_detector(kept)

    def _restore_detector(self, kept: bytes) -> None:
        try:
            asked, state, counts = msgspec.msgpack.decode(kept, type=_KEPT)
            # Only for the same watch: by other settings it has learned something else.
            if asked == msgspec.msgpack.encode(self.watch):
                if isinstance(self.detector, GuardedDetector):
                    inner = self.detector.detector
                    self.detector.detector = load_detector(type(inner), state)
                else:
                    self.detector = load_detector(type(self.detector), state)
                episodes = self.episodes
                episodes.since, episodes.quiet, episodes.learning = counts
        except (msgspec.MsgspecError, ValueError):
            # Of another version: it learns anew.
            return

    def dump_state(self) -> bytes:
        """Give what is to be kept over a restart."""
        self.changed = False
        asked = msgspec.msgpack.encode(self.watch)
        counts = (self.episodes.since, self.episodes.quiet, self.episodes.learning)
        return msgspec.msgpack.encode((asked, self._detector_state(), counts))

    def _detector_state(self) -> bytes:
        if not isinstance(self.detector, GuardedDetector):
            return dump_detector(self.detector)
        try:
            return dump_detector(self.detector.detector)
        except Exception as error:  # noqa: BLE001 - whatever it raises, it is named
            self.detector.record_failure(f"what it has learned cannot be kept: {error}")
            return b""

    @property
    def learning(self) -> int:
        """So many samples until it has learned; before, it tells of what is clear at the most."""
        return self.episodes.learning

    def score_sample(self, time_us: int, value: float) -> AnomalyBegan | AnomalyEnded | None:
        """Look at one sample; those that are not numbers or not newer are passed over."""
        if time_us <= self._newest_us:
            self.late += 1
            return None
        # NaN compares false both ways; infinities would spoil every mean.
        if not -float("inf") < value < float("inf"):
            return None
        self._newest_us = time_us
        self.changed = True
        return self._update_score(time_us, self.detector.see(time_us, value))

    def score_silence(self, time_us: int) -> AnomalyBegan | AnomalyEnded | None:
        """Look at the clock: some detectors are about what does not come."""
        score = self.detector.idle(time_us)
        # Silence tells something only if it is an anomaly: other scores stay those of samples.
        if score < self.episodes.bar or time_us <= self._newest_us:
            return None
        return self._update_score(time_us, score)

    def dismiss_peak(self) -> bool:
        """Learn that the newest peak was no anomaly; false where nothing can be learned."""
        self.changed = True
        self.forgiven = self.detector.forgive()
        return self.forgiven

    def take_learned(self) -> bool:
        """Tell once that it has seen enough to tell of anomalies."""
        learned, self._learned = self._learned, False
        return learned

    def _update_score(self, time_us: int, score: float) -> AnomalyBegan | AnomalyEnded | None:
        self.score = score
        learning = self.episodes.learning
        turn = self.episodes.update_score(time_us, score)
        # True in the one step in which the learning ends.
        self._learned = self._learned or (learning > 0 and not self.episodes.learning)
        if turn is EpisodeTurn.BEGAN:
            self.why = self.detector.why()
            self.from_us, self.to_us, self.forgiven = time_us, 0, False
            return AnomalyBegan(time_us, score, self.why)
        return self._close_episode() if turn is EpisodeTurn.ENDED else None

    def end_anomaly(self) -> AnomalyEnded | None:
        """End an anomaly that is on, because its signal is no longer watched."""
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
