"""One signal with one detector as the hub runs them: scores in, anomalies and their reasons out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from talaia.extensions.declarations import DetectorExtension
from talaia.extensions.installed import installed_extensions
from talaia.hub.anomaly.base import (
    AnomalyDetector,
    copy_detector,
    dump_detector,
    load_detector,
)
from talaia.hub.anomaly.baseline import Quartiles
from talaia.hub.anomaly.episode_runner import EpisodeRunner
from talaia.hub.anomaly.episodes import Episodes
from talaia.hub.anomaly.guarded import GuardedDetector, extension_detector
from talaia.hub.anomaly.kinds import KINDS, RegisteredDetector, kind_of
from talaia.hub.anomaly.simple_rules import LimitsDetector, Missing, RateOfChange, Still
from talaia.model.alarms.anomaly import DetectorKind

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.hub.anomaly.base import Floats
    from talaia.hub.anomaly.budget.score_tail import ScoreTail
    from talaia.hub.anomaly.episode_runner import AnomalyBegan, AnomalyEnded
    from talaia.model.alarms.anomaly import Watch

__all__ = ["DetectorRunner", "detector_of"]

# An extension that is not installed here: nobody judges by it.
_MISSING = RegisteredDetector(AnomalyDetector, 1.0, "not installed at this hub", learns=False)
# What is kept: the watch, the detector, and the counts of its episodes: since, quiet, learning.
_KEPT = tuple[bytes, bytes, tuple[int, int, int]]


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


class DetectorRunner(EpisodeRunner):
    """A detector of one signal at work.

    Attributes:
        watch: as the description has it.
        unit: of the signal.
        detector: what judges it.

    """

    def __init__(self, address: str, unit: str, watch: Watch, kept: bytes | None = None) -> None:
        """Go on with what was ``kept``; begin anew where there is nothing, or it does not fit."""
        kind = kind_of(watch, installed_extensions().detectors_by_name()) or _MISSING
        episodes = Episodes(
            bar=watch.bar or kind.bar,
            rest=watch.rest,
            quiet=kind.quiet,
            learning=kind.learning,
        )
        super().__init__(address, watch.detector_name(), kind=kind, episodes=episodes)
        self.unit, self.watch = unit, watch
        self.detector = detector_of(watch, unit)
        # The time of the newest sample (µs); -1: none.
        self._newest_us = -1
        if kept is not None:
            self._restore_detector(kept)

    @property
    def asked(self) -> bytes:
        """See `EpisodeRunner.asked`."""
        return msgspec.msgpack.encode(self.watch)

    def _restore_detector(self, kept: bytes) -> None:
        try:
            asked, state, counts = msgspec.msgpack.decode(kept, type=_KEPT)
            # Only for the same watch: by other settings it has learned something else.
            if asked == self.asked:
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
        counts = (self.episodes.since, self.episodes.quiet, self.episodes.learning)
        return msgspec.msgpack.encode((self.asked, self._detector_state(), counts))

    def _detector_state(self) -> bytes:
        if not isinstance(self.detector, GuardedDetector):
            return dump_detector(self.detector)
        try:
            return dump_detector(self.detector.detector)
        except Exception as error:  # noqa: BLE001 - whatever it raises, it is named
            self.detector.record_failure(f"what it has learned cannot be kept: {error}")
            return b""

    def magnitudes(self) -> tuple[float, ...]:
        """See `EpisodeRunner.magnitudes`."""
        return () if isinstance(self.detector, GuardedDetector) else self.detector.magnitudes()

    def rate_past(self, times: NDArray[np.int64], values: Floats, tail: ScoreTail) -> None:
        """Look at samples of the past for their magnitudes alone, which go into ``tail``.

        Args:
            times: rising, and newer than all that came before (µs) (n,).
            values: finite numbers (n,).
            tail: takes what could begin an anomaly.

        """
        if isinstance(self.detector, GuardedDetector) or not len(times):
            return
        scores, rated = self.detector.rate_many(times, values)
        learned = min(self.learning, len(scores))
        self.episodes.pass_calm(len(scores))
        strong = scores >= self.episodes.bar
        tail.record_many(times[learned:], strong[learned:], rated[learned:])

    def reason(self) -> str:
        """Say in words what the newest score stands on."""
        return self.detector.why()

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
        return self.update_score(time_us, self.detector.see(time_us, value))

    def score_many(
        self, times: NDArray[np.int64], values: Floats
    ) -> tuple[Floats, list[AnomalyBegan | AnomalyEnded]]:
        """Look at samples as `score_sample` does one by one, many times faster.

        Args:
            times: rising, and newer than all that came before (µs) (n,).
            values: finite numbers (n,).

        Returns:
            The scores (n,), and what began and ended with them.

        """
        turns: list[AnomalyBegan | AnomalyEnded] = []
        # Magnitudes are those of the newest sample, so with a tail each is looked at by itself.
        one_by_one = self.tail is not None or bool(self.needs)
        if (
            isinstance(self.detector, GuardedDetector)
            or not self.detector.faster_many
            or one_by_one
        ):
            scores = np.empty(len(values))
            for place, pair in enumerate(zip(times.tolist(), values.tolist(), strict=True)):
                turn = self.score_sample(*pair)
                turns += [] if turn is None else [turn]
                scores[place] = self.score
            return scores, turns
        if not len(times):
            return np.empty(0), turns
        before, at = copy_detector(self.detector) if self.says_why else self.detector, 0
        scores = self.detector.see_many(times, values)
        while (begins := at + self._pass_scores(times[at:], scores[at:], turns)) < len(scores):
            time_us, after = int(times[begins]), self.detector
            if self.says_why:
                # It is said of the very moment: the copy is brought there.
                if begins > at:
                    before.see_many(times[at:begins], values[at:begins])
                scores[begins] = before.see(time_us, float(values[begins]))
                self.detector = before
            turn = self.update_score(time_us, float(scores[begins]))
            turns += [] if turn is None else [turn]
            self.detector, at = after, begins + 1
        self._newest_us, self.changed = int(times[-1]), True
        return scores, turns

    def _pass_scores(
        self, times: NDArray[np.int64], scores: Floats, turns: list[AnomalyBegan | AnomalyEnded]
    ) -> int:
        """Take scores in up to where an anomaly begins; give how many."""
        at = 0
        while at < len(scores):
            if self.episodes.began_us < 0 and float(scores[at:].max()) < self.episodes.bar:
                self.pass_calm(float(scores[-1]), len(scores) - at)
                return len(scores)
            for time_us, score in zip(times[at:].tolist(), scores[at:].tolist(), strict=True):
                if self.episodes.would_begin(score):
                    return at
                turn = self.update_score(time_us, score)
                at += 1
                if turn is not None:
                    # Over: all that follows may be calm.
                    turns.append(turn)
                    break
        return at

    def score_silence(self, time_us: int) -> AnomalyBegan | AnomalyEnded | None:
        """Look at the clock: some detectors are about what does not come."""
        score = self.detector.idle(time_us)
        # Silence tells something only if it is an anomaly: other scores stay those of samples.
        if score < self.episodes.bar or time_us <= self._newest_us:
            return None
        return self.update_score(time_us, score)

    def dismiss_peak(self) -> bool:
        """Learn that the newest peak was no anomaly; false where nothing can be learned."""
        self.changed = True
        self.forgiven = self.detector.forgive()
        return self.forgiven
