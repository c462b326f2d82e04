"""The detectors of one site, and which of its samples each of them looks at."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import numpy as np

from talaia.hub.anomaly.episode_runner import tail_word
from talaia.hub.anomaly.groups.group_runner import GroupRunner
from talaia.hub.anomaly.runner import DetectorRunner
from talaia.hub.anomaly.selection import MOST_BY_DEFAULT, wanted_detectors
from talaia.hub.live.detection.thinning import Thinning
from talaia.model.alarms.signal_groups import MOST_IN_GROUPS, groups_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.typing import NDArray

    from talaia.hub.anomaly.episode_runner import EpisodeRunner
    from talaia.hub.live.sites import LiveSite
    from talaia.model.alarms.anomaly import Watch
    from talaia.model.alarms.signal_groups import GroupSignals
    from talaia.wire.columns import Columns

__all__ = ["SiteWatch", "watch_site"]

_LOG = logging.getLogger(__name__)
# The place of what tells a group's way of running.
_STATE = -1


class SiteWatch:
    """The detectors of one site.

    Attributes:
        description: as it was when this was made; another object means another description.
        watched: detectors of single signals, by the address of their signal.
        groups: those of several signals.
        members: by the address of a signal: the groups that look at it, and its place in each.
        ready: what was learned before the start has been read from the database.
        chosen: whether each channel is watched, by its place; `addresses` are theirs.
        thinning: looks at signals of which one sample a second is enough.
        places: a score's address to its number among the channels that a page may subscribe to.
        fresh: scores that pages have not been shown yet: number, time (µs), score.

    """

    def __init__(self, live: LiveSite) -> None:
        """Begin without any detector."""
        self.description = live.description
        self.watched: dict[str, list[DetectorRunner]] = {}
        self.groups: list[GroupRunner] = []
        self.members: dict[str, list[tuple[GroupRunner, int]]] = {}
        self.ready = False
        self.chosen = np.zeros(0, bool)
        self.addresses: list[str] = []
        self.thinning = Thinning(np.zeros(0, bool))
        scores = range(len(live.channels), len(live.every))
        self.places = {live.every[at].address: at for at in scores}
        self.fresh: list[tuple[int, int, float]] = []

    @property
    def any_runners(self) -> bool:
        """Whether there is any detector."""
        return bool(self.watched or self.groups)

    def all_runners(self) -> list[EpisodeRunner]:
        """List all detectors: those of single signals, then the groups."""
        return [*(runner for some in self.watched.values() for runner in some), *self.groups]

    def find_runner(self, address: str, word: str) -> EpisodeRunner | None:
        """Find a detector by its address and its name."""
        for runner in self.all_runners():
            if runner.address == address and runner.word == word:
                return runner
        return None

    def take_groups(self, groups: list[GroupRunner]) -> None:
        """Let these groups look at their signals, in place of those before."""
        self.groups, self.members = groups, {}
        for runner in groups:
            for place, address in enumerate(runner.watched):
                self.members.setdefault(address, []).append((runner, place))
            state = runner.group.group.state
            if state:
                self.members.setdefault(state, []).append((runner, _STATE))

    def choose_channels(self, live: LiveSite, thin: set[str]) -> None:
        """Find the channels that anybody looks at; of those in ``thin`` one sample a second."""
        some = bool(self.watched or self.members)
        self.addresses = [channel.address for channel in live.channels] if some else []
        looked = self.watched.keys() | self.members.keys()
        self.chosen = np.array([address in looked for address in self.addresses], bool)
        # A group looks at a second as a whole; who watches a signal by itself decides for it.
        thin = thin | (self.members.keys() - self.watched.keys() - self._states())
        self.thinning = Thinning(np.array([address in thin for address in self.addresses], bool))

    def pick_samples(self, columns: Columns) -> NDArray[np.intp]:
        """Give the places of the samples of a batch that anybody looks at."""
        # A link that is being replaced may still speak of another list of channels.
        if int(columns.channel.max()) >= len(self.addresses):
            return np.empty(0, np.intp)
        at = np.flatnonzero(self.chosen[columns.channel])
        return self.thinning.pick_samples(columns, at)

    def _states(self) -> set[str]:
        """Name the states: each change of them counts."""
        return {runner.group.group.state for runner in self.groups} - {""}

    def restore(self, kept: Mapping[tuple[str, str], bytes]) -> None:
        """Go on with what was learned before the hub was started, by address and detector."""
        for address, some in self.watched.items():
            for at, runner in enumerate(some):
                state = kept.get((address, runner.word))
                if state is not None:
                    some[at] = DetectorRunner(address, runner.unit, runner.watch, state)
        groups = [
            GroupRunner(runner.group, kept.get((runner.address, runner.word)))
            for runner in self.groups
        ]
        self.take_groups(groups)
        for one in self.all_runners():
            tail = kept.get((one.address, tail_word(one.word)))
            if tail is not None:
                one.restore_tail(tail)


def watch_site(live: LiveSite, before: SiteWatch | None) -> tuple[SiteWatch, list[EpisodeRunner]]:
    """Make the detectors that a description asks for.

    Returns:
        Them, those of before taken over where they are asked for alike; and those of before that
        nobody asks for any more.

    """
    fresh = SiteWatch(live)
    single = {} if before is None else dict(_keyed(before))
    thin = set()
    wishes, left_out = wanted_detectors(live.description)
    for wish in wishes:
        fresh.watched[wish.address] = [
            _same_detector(single, (wish.address, wanted))
            or DetectorRunner(wish.address, wish.unit, wanted)
            for wanted in wish.watches
        ]
        if wish.thin:
            thin.add(wish.address)
    grouped = {} if before is None else {runner.address: runner for runner in before.groups}
    groups, groups_left_out = groups_of(live.description)
    fresh.take_groups([_same_group(grouped, group) for group in groups])
    fresh.choose_channels(live, thin)
    fresh.ready = not fresh.all_runners() or (before is not None and before.ready)
    _log_left_out(live.name, left_out, groups_left_out)
    return fresh, [*single.values(), *grouped.values()]


def _keyed(watch: SiteWatch) -> Iterator[tuple[tuple[str, Watch], DetectorRunner]]:
    for some in watch.watched.values():
        for runner in some:
            yield (runner.address, runner.watch), runner


def _same_detector(
    before: dict[tuple[str, Watch], DetectorRunner], key: tuple[str, Watch]
) -> DetectorRunner | None:
    """Take a detector over from the description of before, if it is asked for alike."""
    return before.pop(key) if key in before else None


def _same_group(before: dict[str, GroupRunner], group: GroupSignals) -> GroupRunner:
    """Take a group over from the description of before, if it learns from the same."""
    fresh, known = GroupRunner(group), before.get(group.address)
    if known is None or known.asked != fresh.asked:
        return fresh
    del before[group.address]
    known.redescribe(group)
    return known


def _log_left_out(site: str, signals: int, groups: int) -> None:
    if signals:
        _LOG.warning(
            "anomaly detection of %s: the first %d signals are watched, %d more are not",
            site,
            MOST_BY_DEFAULT,
            signals,
        )
    if groups:
        _LOG.warning(
            "anomaly detection of %s: the devices of the first %d signals are judged together,"
            " %d more are not",
            site,
            MOST_IN_GROUPS,
            groups,
        )
