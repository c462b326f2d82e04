"""What the routes of detectors and of their back-tests have in common."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.anomaly_schemas import ShareShape

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.clock import Clock
    from talaia.hub.anomaly.episode_runner import EpisodeRunner
    from talaia.hub.anomaly.groups.whitening import SignalShare

__all__ = ["check_past_window", "share_shapes"]


def check_past_window(from_us: int, to_us: int, clock: Clock) -> None:
    """Refuse (422) what is no stretch of the past (µs since the epoch, UTC)."""
    if not from_us < to_us <= clock.wall_ns() // 1000:
        raise ApiProblem(
            422, "invalid", "expected from_us before to_us, and to_us not in the future"
        )


def share_shapes(runner: EpisodeRunner, shares: Iterable[SignalShare]) -> list[ShareShape]:
    """Tell by their addresses what the signals of a group had to do with an anomaly."""
    return [
        ShareShape(signal=runner.members[one.place], share=one.share, spreads=one.spreads)
        for one in shares
    ]
