"""Raw topics of the robot that may be tapped: which, by whom, and how often."""

from __future__ import annotations

from enum import StrEnum
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from talaia.model.base import Shape

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["TopicRight", "TopicRule", "matches_topic", "rule_of"]


class TopicRight(StrEnum):
    """The right that a person needs to have a raw topic."""

    VIEW = "view"
    USE = "use"
    ADMIN = "admin"
    TAP = "tap"


class TopicRule(Shape, frozen=True, kw_only=True):
    """Who may have the raw topics whose name a pattern fits; of several rules the first counts.

    Attributes:
        pattern: shell-like, over absolute names: ``*`` and ``?`` stay within one part between
            slashes, ``**`` stands for any number of parts: ``/scan``, ``/camera/**``,
            ``/**/diagnostics``.
        right: what a person needs; those with the right ``tap`` have the topic, too, unless it is
            for admins.
        device: on which device the right is needed; on the whole site where it is left out.
        max_rate: at most so many messages a second are handed on (Hz); 0 sets no limit. Topics
            that are latched, or that come a few times a second, are handed on whole.

    """

    pattern: str
    right: TopicRight
    device: str = ""
    max_rate: float = 0.0


def rule_of(rules: Sequence[TopicRule], topic: str) -> TopicRule | None:
    """Give the first rule whose pattern fits a topic's absolute name."""
    return next((rule for rule in rules if matches_topic(rule.pattern, topic)), None)


def matches_topic(pattern: str, topic: str) -> bool:
    """Tell whether a topic's absolute name fits a pattern; see `TopicRule`."""
    parts = topic.split("/")
    # How many parts of the name the pattern so far can stand for: at most one step for each pair
    # of parts, whatever the pattern, so that none can be slow on purpose.
    reached = {0}
    for word in pattern.split("/"):
        if word == "**":
            reached = set(range(min(reached), len(parts) + 1))
        else:
            reached = {at + 1 for at in reached if at < len(parts) and fnmatchcase(parts[at], word)}
        if not reached:
            return False
    return len(parts) in reached
