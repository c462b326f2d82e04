"""Which pictures belong to which observation. Pure.

A gateway reports when an observation began and how it went on; a picture says when its exposure
began and of what. A telescope observes one thing at a time, so time and target tell which; a
picture of the same target that somebody took between two observations is nobody's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

__all__ = ["ObservationSpan", "assign_frames"]

# Clocks of camera and gateway differ by so much at the most; headers often have whole seconds.
SLACK_US = 2_000_000
# As much of a target's name as a camera is told.
_NAME = 60


class _TakenFrame(Protocol):
    """What is asked of a picture: its number, when it began and of what it is."""

    @property
    def id(self) -> int: ...

    @property
    def time_us(self) -> int: ...

    @property
    def target(self) -> str: ...


class ObservationSpan(NamedTuple):
    """An observation, as far as its pictures are told by it.

    Attributes:
        end_us: of its last report; None while it goes on.

    """

    id: str
    request: int
    proposal: str
    target: str
    begin_us: int
    end_us: int | None


def assign_frames(
    frames: Iterable[_TakenFrame], spans: Sequence[ObservationSpan]
) -> dict[int, ObservationSpan]:
    """Give the observation of each picture that has one, by the picture's id."""
    # Of several the one that began last: it interrupted the others.
    latest_first = sorted(spans, key=lambda span: span.begin_us, reverse=True)
    found: dict[int, ObservationSpan] = {}
    for frame in frames:
        for span in latest_first:
            if _is_of(frame, span):
                found[frame.id] = span
                break
    return found


def _is_of(frame: _TakenFrame, span: ObservationSpan) -> bool:
    if frame.time_us < span.begin_us - SLACK_US:
        return False
    if span.end_us is not None and frame.time_us > span.end_us + SLACK_US:
        return False
    # A camera that is not told of targets writes none.
    return frame.target in ("", _as_written(span.target))


def _as_written(name: str) -> str:
    # FITS holds plain ASCII only; a camera's driver or our gateway puts a question mark.
    plain = "".join(letter if " " <= letter <= "~" else "?" for letter in name[:_NAME])
    return plain.strip()
