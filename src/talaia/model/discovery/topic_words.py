"""Words for addresses and people, made of the names of topics and fields. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.discovery.ros_units import readable_name

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["free_word", "last_part", "path_in_words"]

# Axes and parts of a quaternion (REP-103): people write them small.
_AXES = {"x", "y", "z", "w"}
# The longest word of an address; see `ros_units.word_of`.
_MAX_WORD = 63


def path_in_words(path: str) -> str:
    """Say a path in words, without what repeats: ``pose.pose.position.x`` → Pose position x."""
    words: list[str] = []
    for step in path.replace("[", " ").replace("]", "").replace(".", " ").split():
        word = step if step in _AXES else readable_name(step).lower()
        # A stamped message has its content in a field of the same name: `pose.pose`.
        if word and (not words or words[-1] != word):
            words.append(word)
    joined = " ".join(words)
    return joined[:1].upper() + joined[1:]


def last_part(topic: str, skip: Iterable[str] = ()) -> str:
    """Give the telling last part of a topic; the part before it where the last says nothing."""
    parts = topic.strip("/").split("/")
    while len(parts) > 1 and parts[-1] in skip:
        parts.pop()
    return parts[-1]


def free_word(word: str, taken: Iterable[str]) -> str:
    """Give the word, or with a number behind where it is taken."""
    if word not in taken:
        return word
    for number in range(2, 10_000):
        tail = f"_{number}"
        # Cut before the number, so that the word stays within what an address may have.
        other = word[: _MAX_WORD - len(tail)] + tail
        if other not in taken:
            return other
    return word
