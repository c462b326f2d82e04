"""What belongs to one cause: anomalies that began together, and the last time it was so. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

__all__ = ["ONE_CAUSE_US", "Beginning", "Episode", "gather_episodes", "most_similar"]

# What begins within a minute of each other has one cause.
ONE_CAUSE_US = 60_000_000
# Fewer than a third of the names in common is another matter.
_LEAST_LIKE = 0.34


class Beginning(NamedTuple):
    """An anomaly began: when (µs), on which device, and what it is called there."""

    time_us: int
    device: str
    name: str


class Episode(NamedTuple):
    """Anomalies of one cause: when the first began (µs), and what was unusual."""

    began_us: int
    last_us: int
    names: frozenset[tuple[str, str]]


def gather_episodes(beginnings: Iterable[Beginning]) -> list[Episode]:
    """Make episodes of anomalies, the first one first; each begins soon after the one before."""
    episodes: list[Episode] = []
    for one in sorted(beginnings):
        name = frozenset({(one.device, one.name)})
        newest = episodes[-1] if episodes else None
        if newest is not None and one.time_us - newest.last_us <= ONE_CAUSE_US:
            episodes[-1] = Episode(newest.began_us, one.time_us, newest.names | name)
        else:
            episodes.append(Episode(one.time_us, one.time_us, name))
    return episodes


def most_similar(
    names: frozenset[tuple[str, str]], before: Sequence[Episode]
) -> tuple[Episode, float] | None:
    """Find the episode that is most like one of these names; of several alike the last.

    Returns:
        It, and how much they have in common: the names of both against those of either, 0 to 1.

    """
    found: tuple[Episode, float] | None = None
    for episode in before:
        like = len(names & episode.names) / max(1, len(names | episode.names))
        if like >= _LEAST_LIKE and (found is None or like >= found[1]):
            found = episode, like
    return found
