"""A group of signals as the hub runs it: rows out of samples, anomalies, and who made them so."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.hub.anomaly.base import AnomalyDetector, dump_detector, load_detector
from talaia.hub.anomaly.episode_runner import EpisodeRunner
from talaia.hub.anomaly.episodes import Episodes
from talaia.hub.anomaly.groups.group import score_of_distance
from talaia.hub.anomaly.groups.modal_group import ModalGroup
from talaia.hub.anomaly.kinds import RegisteredDetector
from talaia.model.alarms.signal_groups import GROUP_DETECTOR

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.anomaly.episode_runner import AnomalyBegan, AnomalyEnded
    from talaia.model.alarms.signal_groups import GroupSignals

__all__ = ["NAMED_SHARE", "GroupRunner", "new_modal_group"]

# A signal with a smaller share of a distance is not named.
NAMED_SHARE = 0.1
# While an anomaly is on it is told at most this often that other signals lead (µs).
_TOLD_AGAIN_US = 10_000_000
# Of how it is called alone; it is made for a whole group.
_KIND = RegisteredDetector(AnomalyDetector, 0.5, "signals together")
# What is kept: what was asked for, the detector, and since when no anomaly began.
_KEPT = tuple[bytes, bytes, int]


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
        detector: what judges it.

    """

    def __init__(self, group: GroupSignals, kept: bytes | None = None) -> None:
        """Go on with what was ``kept``; begin anew where there is nothing, or it does not fit."""
        # The detector leaves an anomaly by a lower bar of its own: there is no rest besides.
        episodes = Episodes(bar=group.group.bar, rest=1)
        super().__init__(group.address, GROUP_DETECTOR, kind=_KIND, episodes=episodes)
        self.group, self.members = group, group.signals
        self.detector = new_modal_group(group)
        # Names of the signals that were told to lead, and when (µs).
        self._told: tuple[str, ...] = ()
        self._told_us = -1
        if kept is not None:
            self._restore_detector(kept)

    @property
    def asked(self) -> bytes:
        """What it has learned by: by something else it learns anew."""
        # Labels and the bar may change without that.
        learned_by = msgspec.structs.replace(self.group.group, name="", bar=0.5)
        return msgspec.msgpack.encode((learned_by, self.group.signals))

    def _restore_detector(self, kept: bytes) -> None:
        try:
            asked, state, since = msgspec.msgpack.decode(kept, type=_KEPT)
            if asked == self.asked:
                self.detector = load_detector(ModalGroup, state)
                self.detector.rename_signals(self.group.labels)
                self.episodes.since = since
        except (msgspec.MsgspecError, ValueError):
            # Of another version: it learns anew.
            return

    def redescribe(self, group: GroupSignals) -> None:
        """Take other names and another bar; what is learned from is the same."""
        self.group = group
        self.set_needs(self.needs)
        self.detector.rename_signals(group.labels)

    def dump_state(self) -> bytes:
        """Give what is to be kept over a restart."""
        self.changed = False
        kept = dump_detector(self.detector)
        return msgspec.msgpack.encode((self.asked, kept, self.episodes.since))

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
        """Give the squared distance, in the greatest ones of the learning stretch."""
        current = self.detector.current
        judged = current is not None and self.detector.score > 0.0
        return (current.distance if current is not None and judged else 0.0,)

    def set_needs(self, needs: tuple[float, ...]) -> None:
        """See `EpisodeRunner.set_needs`; the bar goes with it, for the distance is all there is."""
        self.needs = needs
        self.episodes.bar = self.group.group.bar
        if needs:
            self.episodes.bar = min(self.episodes.bar, score_of_distance(needs[0]))

    def counts_peak(self, score: float) -> bool:
        """See `EpisodeRunner.counts_peak`: from the lowest bar on that a budget may set."""
        return score > 0.0

    def reason(self) -> str:
        """Say in words what the newest score stands on."""
        why = self.detector.why()
        return f"{self.mode}: {why}" if self.group.states and self.mode else why

    def score_sample(
        self, place: int, time_us: int, value: float
    ) -> AnomalyBegan | AnomalyEnded | None:
        """Look at one sample of the signal at ``place``; -1: of the state."""
        if not -float("inf") < value < float("inf"):
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
        """Look at a whole row of the past, NaN where nothing came."""
        learning = self.detector.learning
        self.detector.see_row(time_us, values, state)
        return self._take_judged(time_us, learning)

    def _take_judged(self, time_us: int, learning: int) -> AnomalyBegan | AnomalyEnded | None:
        detector = self.detector
        turn = self.update_score(time_us, detector.score)
        self._stands_otherwise |= learning > 0 and detector.learning == 0
        if self.episodes.began_us >= 0 and self.score >= self.episodes.top:
            # Named as at its worst: when it begins little is to be seen of it.
            self.shares = detector.list_shares()
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
        self.forgiven = self.detector.forgive()
        return self.forgiven

    def take_learned(self, detector: ModalGroup) -> AnomalyEnded | None:
        """Go on with what was learned from a stretch of the past; an anomaly that is on ends."""
        ended = self.end_anomaly()
        self.detector, self.changed, self._stands_otherwise = detector, True, True
        self.score = 0.0
        return ended
