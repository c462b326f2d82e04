"""A group of signals as the hub runs it: rows out of samples, anomalies, and who made them so.

Long, because rows, the group's own distance and each signal's residual share one state that is
kept over restarts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from talaia.hub.anomaly.base import AnomalyDetector, Floats, dump_detector, load_detector
from talaia.hub.anomaly.budget.score_tail import block_of
from talaia.hub.anomaly.episode_runner import EpisodeRunner
from talaia.hub.anomaly.episodes import Episodes
from talaia.hub.anomaly.groups.group import score_of_distance
from talaia.hub.anomaly.groups.modal_group import ModalGroup
from talaia.hub.anomaly.groups.residuals import SignalResiduals
from talaia.hub.anomaly.groups.whitening import SignalShare
from talaia.hub.anomaly.kinds import RegisteredDetector
from talaia.model.alarms.signal_groups import GROUP_DETECTOR

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from talaia.hub.anomaly.budget.score_tail import ScoreTail
    from talaia.hub.anomaly.episode_runner import AnomalyBegan, AnomalyEnded
    from talaia.hub.anomaly.groups.residuals import StrangeSignal
    from talaia.model.alarms.signal_groups import GroupSignals

__all__ = ["NAMED_SHARE", "GroupRunner", "new_modal_group"]

# A signal with a smaller share of a distance is not named.
NAMED_SHARE = 0.1
# While an anomaly is on it is told at most this often that other signals lead (µs).
_TOLD_AGAIN_US = 10_000_000
# Of how it is called alone; it is made for a whole group.
_KIND = RegisteredDetector(AnomalyDetector, 0.5, "signals together")
# What is kept: what was asked for, the detector, and since when no anomaly began; then of what
# signals residuals are, and these. Versions before those kept the first three.
_KEPT = tuple[bytes, bytes, int, tuple[str, ...], bytes]
_KEPT_BEFORE = tuple[bytes, bytes, int]
# An anomaly of residuals is over below such a part of the threshold.
_LEAVE = 0.5
# No threshold is nothing: of what was never seen to move any move is beyond it.
_LEAST_NEED = 1e-300


def new_modal_group(group: GroupSignals, learn_rows: int = 0) -> ModalGroup:
    """Make what judges a group; with ``learn_rows`` it learns from so many."""
    asked = group.group
    return ModalGroup(
        signals=list(group.labels),
        learn_rows=learn_rows or asked.learn,
        step_us=round(asked.step * 1e6),
        by_state=bool(asked.state),
        most_modes=asked.modes,
    )


class GroupRunner(EpisodeRunner):
    """A group of signals at work.

    Attributes:
        group: as the description has it.
        detector: what judges all signals together.
        residuals: what judges each against the others, where a budget sets thresholds for it.

    """

    def __init__(self, group: GroupSignals, kept: bytes | None = None) -> None:
        """Go on with what was ``kept``; begin anew where there is nothing, or it does not fit."""
        # The detector leaves an anomaly by a lower bar of its own: there is no rest besides.
        episodes = Episodes(bar=group.group.bar, rest=1)
        super().__init__(group.address, GROUP_DETECTOR, kind=_KIND, episodes=episodes)
        self.group, self.members = group, group.signals
        self.detector = new_modal_group(group)
        self.residuals = self._new_residuals()
        # The thresholds as numbers of an array, of each magnitude; and the greatest that were
        # recorded of the newest block of time.
        self._thresholds, self._recorded, self._block = np.empty(0), np.empty(0), -1
        # Names of the signals that were told to lead, and when (µs).
        self._told: tuple[str, ...] = ()
        self._told_us = -1
        if kept is not None:
            self._restore_detector(kept)

    def _new_residuals(self) -> SignalResiduals:
        return SignalResiduals(
            own=len(self.members),
            beside=len(self.group.beside),
            step_us=round(self.group.group.step * 1e6),
        )

    @property
    def watched(self) -> tuple[str, ...]:
        """Addresses of the signals that it looks at: its own, then those beside."""
        return (*self.members, *self.group.beside)

    @property
    def asked(self) -> bytes:
        """What it has learned by: by something else it learns anew."""
        # Labels and the bar may change without that.
        learned_by = msgspec.structs.replace(self.group.group, name="", bar=0.5)
        return msgspec.msgpack.encode((learned_by, self.group.signals))

    def _restore_detector(self, kept: bytes) -> None:
        try:
            asked, state, since, of, residuals = _decode_kept(kept)
            if asked == self.asked:
                self.detector = load_detector(ModalGroup, state)
                self.detector.rename_signals(self.group.labels)
                self.episodes.since = since
            if asked == self.asked and of == self.watched:
                self.residuals = load_detector(SignalResiduals, residuals)
        except (msgspec.MsgspecError, ValueError):
            # Of another version: it learns anew.
            return

    def redescribe(self, group: GroupSignals) -> None:
        """Take other names and another bar; what is learned from is the same."""
        before, self.group = self.watched, group
        if self.watched != before:
            self.residuals = self._new_residuals()
        self.set_needs(self.needs)
        self.detector.rename_signals(group.labels)

    def dump_state(self) -> bytes:
        """Give what is to be kept over a restart."""
        self.changed = False
        kept = dump_detector(self.detector)
        # What is reckoned from the rest is not kept.
        less = msgspec.structs.replace(self.residuals, weights=np.empty(0))
        return msgspec.msgpack.encode(
            (self.asked, kept, self.episodes.since, self.watched, dump_detector(less))
        )

    @property
    def learning(self) -> int:
        """So many steps until it has learned of the way of running that it is in."""
        return self.detector.learning

    @property
    def mode(self) -> str:
        """The way of running that it is in: its state's name, or a number of those found."""
        known, detector = self.group.states, self.detector
        if detector.mode < 0 or (not known and len(detector.members) < 2):
            return ""
        if known:
            return known[detector.mode] if detector.mode < len(known) else ""
        return f"{detector.mode + 1} of {len(detector.members)}"

    def magnitudes(self) -> tuple[float, ...]:
        """Give the squared distance, in the greatest ones of the learning stretch; then residuals.

        See `SignalResiduals.magnitudes`.
        """
        return tuple(self._rate_row().tolist())

    def _rate_row(self) -> Floats:
        return np.concatenate([[self._distance()], self.residuals.magnitudes()])

    def _distance(self) -> float:
        current = self.detector.current
        judged = current is not None and self._distance_score() > 0.0
        return current.distance if current is not None and judged else 0.0

    def _distance_score(self) -> float:
        return 0.0 if self.group.is_single else self.detector.score

    def set_needs(self, needs: tuple[float, ...]) -> None:
        """See `EpisodeRunner.set_needs`; the bar goes with it, for the distance is all there is."""
        self.needs = needs
        self.episodes.bar = self.group.group.bar
        self._thresholds = np.empty(0)
        if needs:
            self.episodes.bar = min(self.episodes.bar, score_of_distance(needs[0]))
            # Residuals that were not seen yet have none.
            self._thresholds = np.full(1 + self.residuals.magnitude_count, np.inf)
            known = self._thresholds[: len(needs)]
            known[:] = np.maximum(needs[: len(known)], _LEAST_NEED)

    def reason(self) -> str:
        """Say in words what the newest score stands on."""
        strange = self._list_strange()
        why = "; ".join(one.why for one in strange[:2] if one.excess >= _LEAVE)
        why = why or ("" if self.group.is_single else self.detector.why())
        return f"{self.mode}: {why}" if self.group.states and self.mode else why

    def score_sample(
        self, place: int, time_us: int, value: float
    ) -> AnomalyBegan | AnomalyEnded | None:
        """Look at one sample of the signal at ``place`` of `watched`; -1: of the state."""
        if not -float("inf") < value < float("inf"):
            return None
        if place >= 0 and self._judges_residuals():
            self.residuals.see(time_us, place, value)
        if place >= len(self.members):
            return None
        detector, step = self.detector, self.detector.held.gathering
        judged, learning = detector.heard, detector.learning
        if not detector.see(time_us, place, value):
            self.late += 1
            return None
        if detector.heard == judged:
            return None
        self.changed = True
        # What was judged is the step before the one that this sample opened.
        return self._take_judged(step * detector.step_us, learning)

    def score_row(
        self, time_us: int, values: Sequence[float], state: int
    ) -> AnomalyBegan | AnomalyEnded | None:
        """Look at a whole row of the past, NaN where nothing came.

        Args:
            time_us: of the row.
            values: of its signals; where a budget is kept also of those beside, see `watched`.
            state: the way of running; -1: not known.

        """
        learning = self.detector.learning
        if self._judges_residuals() and len(values) == len(self.watched):
            self.residuals.see_row(time_us, values)
        self.detector.see_row(time_us, values[: len(self.members)], state)
        return self._take_judged(time_us, learning)

    def rate_past(
        self, times: NDArray[np.int64], rows: Floats, states: Sequence[int], *, tail: ScoreTail
    ) -> None:
        """Look at rows of the past for their magnitudes alone, which go into ``tail``.

        Args:
            times: rising, and newer than all that came before (µs) (n,).
            rows: a value of each signal of `watched`, NaN where nothing came (n, signals).
            states: the way of running at each; -1: not known.
            tail: takes what could begin an anomaly.

        """
        distances = self.detector.see_rows(times, rows[:, : len(self.members)], states)[1]
        if self.group.is_single:
            distances = [0.0] * len(rows)
        found = np.column_stack((distances, self.residuals.see_rows(times, rows)))
        strange: NDArray[np.bool_] = np.any(found > 0.0, axis=1)
        tail.record_many(times, strange, found)

    def _judges_residuals(self) -> bool:
        """Only a budget can say how great they may be."""
        return self.tail is not None or bool(self.needs)

    def _residual_score(self) -> float:
        """Give a score for the residuals: the bar's where one is at its threshold."""
        if not self._thresholds.size or not self.residuals.trusted:
            return 0.0
        excess = float((self.residuals.magnitudes() / self._thresholds[1:]).max())
        if self.episodes.began_us >= 0:
            excess /= _LEAVE
        bar = self.episodes.bar
        return bar * excess if excess < 1.0 else bar + (1.0 - bar) * (1.0 - 1.0 / excess)

    def _list_strange(self) -> list[StrangeSignal]:
        """List what residuals are at their thresholds; empty where the distance makes the score."""
        if self.score <= self._distance_score() or not self._thresholds.size:
            return []
        return self.residuals.list_strange(self._thresholds[1:], self.group.labels)

    def _list_shares(self) -> list[SignalShare]:
        strange = self._list_strange()
        if not strange:
            return self.detector.list_shares()
        total = sum(one.excess for one in strange)
        names = self.group.labels
        return [
            SignalShare(names[one.place], one.excess / total, one.spreads, one.place)
            for one in strange
        ]

    def _is_strong(self, time_us: int, score: float, learning: int) -> bool:
        if not self._judges_residuals():
            return True
        rated = self._rate_row()
        if self.tail is not None:
            self._record_row(self.tail, time_us, rated)
        if not self._thresholds.size:
            return True
        if not self.residuals.trusted:
            rated[1:] = 0.0
        return bool((rated >= self._thresholds).any())

    def _record_row(self, tail: ScoreTail, time_us: int, rated: Floats) -> None:
        """Record what is greater than all of the same block of time: most rows are not."""
        tail.see_time(time_us)
        if block_of(time_us) != self._block or len(self._recorded) != len(rated):
            self._block, self._recorded = block_of(time_us), np.zeros(len(rated))
        if (rated > self._recorded).any():
            self._recorded = np.maximum(rated, self._recorded)
            tail.record_magnitudes(time_us, rated.tolist())

    def _take_judged(self, time_us: int, learning: int) -> AnomalyBegan | AnomalyEnded | None:
        detector = self.detector
        turn = self.update_score(time_us, max(self._distance_score(), self._residual_score()))
        self._stands_otherwise |= learning > 0 and detector.learning == 0
        if self.episodes.began_us >= 0 and self.score >= self.episodes.top:
            # Named as at its worst: when it begins little is to be seen of it.
            self.shares = self._list_shares()
            self.why = self.reason()
            leaders = self.leaders()
            if turn is not None:
                self._told, self._told_us = leaders, time_us
            elif leaders != self._told and time_us - self._told_us >= _TOLD_AGAIN_US:
                self._told, self._told_us, self._stands_otherwise = leaders, time_us, True
        return turn

    def leaders(self) -> tuple[str, ...]:
        """Name the signals that made the newest anomaly so."""
        return tuple(one.name for one in self.shares if one.share >= NAMED_SHARE)

    def dismiss_peak(self) -> bool:
        """Learn that the newest peak was no anomaly; false while it learns."""
        self.changed = True
        if self._thresholds.size:
            self.residuals.excuse_newest(self._thresholds[1:])
        self.forgiven = self.detector.forgive() or self.group.is_single
        return self.forgiven

    def take_residuals(self, past: GroupRunner) -> None:
        """Go on with residuals that were learned from more of the past."""
        if past.watched == self.watched and past.residuals.heard > self.residuals.heard:
            self.residuals, self.changed = past.residuals, True

    def take_learned(self, detector: ModalGroup) -> AnomalyEnded | None:
        """Go on with what was learned from a stretch of the past; an anomaly that is on ends."""
        ended = self.end_anomaly()
        self.detector, self.changed, self._stands_otherwise = detector, True, True
        self.score = 0.0
        return ended


def _decode_kept(kept: bytes) -> tuple[bytes, bytes, int, tuple[str, ...], bytes]:
    try:
        found: tuple[bytes, bytes, int, tuple[str, ...], bytes]
        found = msgspec.msgpack.decode(kept, type=_KEPT)
    except msgspec.MsgspecError:
        asked, state, since = msgspec.msgpack.decode(kept, type=_KEPT_BEFORE)
        return asked, state, since, (), b""
    return found
