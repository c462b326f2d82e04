"""Anomalies of one cause are one episode: which belong together, and how much each has of it. Pure.

A site falls into parts: a device, or the devices that a group of signals joins. What becomes
unusual in one part while an episode of it is open is of that episode, in whatever order it is
told; what is of another part never is. All is bounded by the number of detectors.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.hub.anomaly.causes import ONE_CAUSE_US

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = [
    "AGAIN_US",
    "GROWS_US",
    "LONGEST_US",
    "Cause",
    "CauseMember",
    "SharedCauses",
    "SignalPart",
]

# An episode takes in what begins up to an hour after it did; what comes later is told anew.
GROWS_US = 3_600_000_000
# After so long without anything new what still goes on holds an episode no more.
LONGEST_US = 24 * 3_600_000_000
# So long after a start of the hub detectors may find again what was on before.
AGAIN_US = 180_000_000
# One that is just at its bar is still a part of what happened.
_LEAST = 0.02


class SignalPart(NamedTuple):
    """What one signal has of an episode: its address, its share (0 to 1), whether it is on."""

    address: str
    share: float
    on: bool


class CauseMember(msgspec.Struct, kw_only=True):
    """What one detector says within an episode.

    Attributes:
        address: of its signal, or of its group.
        detector: its word.
        began_us: when its newest anomaly began, by the site's time.
        score: the greatest.
        excess: how far beyond its bar it was, at the most, of what is left up to 1.
        shares: of a group: what each of its signals (by address) has of it; else none.
        why: in words.
        on: it goes on.
        times: how many of its anomalies are in this episode.
        carried: it went on from the episode before this one, and is counted there.
        unsure: it was on when the hub ended, and was not found again yet.

    """

    address: str
    detector: str
    began_us: int
    score: float = 0.0
    excess: float = 0.0
    shares: tuple[tuple[str, float], ...] = ()
    why: str = ""
    on: bool = True
    times: int = 1
    carried: bool = False
    unsure: bool = False

    @property
    def key(self) -> tuple[str, str]:
        """Its signal and detector: one of each is on at a time."""
        return self.address, self.detector


class Cause(msgspec.Struct, kw_only=True):
    """One episode of a part.

    Attributes:
        began_us: when its first anomaly was told of, by the hub's clock; it names the episode.
        newest_us: when the newest one was.
        members: by signal and detector.
        told_over: it was written down that it ended; what joins later has no such line.

    """

    began_us: int
    newest_us: int
    told_over: bool = False
    members: list[CauseMember] = []

    @property
    def on(self) -> bool:
        """Whether anything of it goes on."""
        return any(one.on for one in self.members)

    def find_member(self, address: str, detector: str) -> CauseMember | None:
        """Find what a detector says within it."""
        return next((one for one in self.members if one.key == (address, detector)), None)

    @property
    def first(self) -> CauseMember:
        """The one by which it is named: the first of its own."""
        return min(self.members, key=lambda one: (one.carried, one.began_us, one.key))

    @property
    def worst(self) -> CauseMember:
        """The one that is farthest beyond its bar; of those that are on, if any is."""
        return max(self.members, key=lambda one: (one.on, one.excess, one.key))

    def signal_parts(self) -> list[SignalPart]:
        """Say what each signal has of it, the greatest first; together 1.

        A signal counts by the detector that says most of it: how far that one is beyond its bar,
        of a group the part that the signal has of that.
        """
        weights: dict[str, float] = {}
        going: set[str] = set()
        for one in self.members:
            excess = max(one.excess, _LEAST)
            for address, share in one.shares or ((one.address, 1.0),):
                weights[address] = max(weights.get(address, 0.0), excess * share)
                if one.on:
                    going.add(address)
        total = sum(weights.values()) or 1.0
        found = [SignalPart(key, weight / total, key in going) for key, weight in weights.items()]
        return sorted(found, key=lambda one: (-one.share, one.address))


class SharedCauses(msgspec.Struct, kw_only=True):
    """The open episodes of one site, by part.

    Attributes:
        open: one of a part at the most.

    """

    open: dict[str, Cause] = {}

    def begin_member(self, part: str, member: CauseMember, now_us: int) -> tuple[Cause, bool]:
        """Take it that an anomaly began.

        Returns:
            Its episode, and whether the episode began with it.

        """
        cause = self.open.get(part)
        if cause is None or now_us - cause.began_us > GROWS_US:
            # What goes on from the one before keeps this one open, and is counted there.
            carried = [] if cause is None else [one for one in cause.members if one.on]
            cause = Cause(began_us=now_us, newest_us=now_us)
            cause.members = [
                msgspec.structs.replace(one, carried=True, times=0)
                for one in carried
                if one.key != member.key
            ]
            cause.members.append(member)
            self.open[part] = cause
            return cause, True
        known = cause.find_member(*member.key)
        cause.newest_us = now_us
        if known is None:
            cause.members.append(member)
        elif known.unsure or (known.on and known.began_us == member.began_us):
            # Found again after a start of the hub, or told twice: it is the same one.
            _continue_member(known, member)
        else:
            _continue_member(known, member)
            known.times += 1
            known.carried = False
        return cause, False

    def end_member(self, part: str, address: str, detector: str) -> Cause | None:
        """Take it that an anomaly ended; give its episode, None if it is in none."""
        cause = self.open.get(part)
        known = None if cause is None else cause.find_member(address, detector)
        if known is not None:
            known.on = known.unsure = False
        return None if known is None else cause

    def close_over(self, now_us: int) -> list[tuple[str, Cause]]:
        """Take out the episodes that are over: nothing goes on, or nothing new came for a day."""
        over = [
            (part, cause)
            for part, cause in self.open.items()
            if now_us - cause.newest_us > LONGEST_US
            # What begins within a minute of the one before is of one cause.
            or (not cause.on and now_us - cause.newest_us > ONE_CAUSE_US)
        ]
        for part, _ in over:
            del self.open[part]
        return over

    def mark_unsure(self, now_us: int) -> None:
        """Take it that the hub was started now: what was on must be found again."""
        for cause in self.open.values():
            # A clock that was set back must not keep it open for ever.
            cause.began_us = min(cause.began_us, now_us)
            cause.newest_us = min(cause.newest_us, now_us)
            for one in cause.members:
                one.unsure = one.on

    def end_unsure(self) -> bool:
        """End what was not found again; tell whether there was any."""
        lost = [one for cause in self.open.values() for one in cause.members if one.unsure]
        for one in lost:
            one.on = one.unsure = False
        return bool(lost)

    def keep_parts(self, parts: Mapping[str, str], places: Iterable[str]) -> None:
        """Go on with another description: what is of no part any more is dropped.

        Args:
            parts: the part of each address that is looked at.
            places: the parts that there are.

        """
        known = set(places)
        for part in [part for part in self.open if part not in known]:
            moved = self.open.pop(part)
            goals = [parts[one.address] for one in moved.members if one.address in parts]
            if goals and goals[0] in self.open:
                _merge_cause(self.open[goals[0]], moved)
            elif goals:
                self.open[goals[0]] = moved


def _continue_member(known: CauseMember, news: CauseMember) -> None:
    known.began_us, known.on, known.unsure = news.began_us, True, False
    known.score = max(known.score, news.score)
    if news.excess >= known.excess:
        known.excess, known.shares, known.why = news.excess, news.shares, news.why


def _merge_cause(into: Cause, other: Cause) -> None:
    into.began_us = min(into.began_us, other.began_us)
    into.newest_us = max(into.newest_us, other.newest_us)
    for one in other.members:
        known = into.find_member(*one.key)
        if known is None:
            into.members.append(one)
        else:
            known.times += one.times
