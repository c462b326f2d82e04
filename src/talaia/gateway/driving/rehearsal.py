"""The path of a rehearsal and what would have been said of it, in bounded room. Pure."""

from __future__ import annotations

import math
from typing import NamedTuple

from talaia.clock import SECOND
from talaia.wire.frames import MOST_POSES, MOST_VERDICTS, RehearsalVerdict

__all__ = ["Rehearsal", "TwinPose"]

# Poses nearer than this to the last that was kept add nothing to a line (m, rad).
STEP_M = 0.02
STEP_RAD = 0.1


class TwinPose(NamedTuple):
    """A place on the floor: m and rad."""

    x: float
    y: float
    yaw: float


class Rehearsal:
    """What was driven in the twin alone since it was forgotten last."""

    def __init__(self) -> None:
        """Begin with nothing driven."""
        self._kept: list[TwinPose] = []
        self._newest: TwinPose | None = None
        # Doubled each time the path is thinned, so that a long one stays as long as a short one.
        self._coarseness = 1
        self._verdicts: list[RehearsalVerdict] = []
        self._began_ns = 0
        self._seconds = 0.0
        self.metres = 0.0

    @property
    def seconds(self) -> float:
        """How long it lasted, from the first pose to the newest (s)."""
        return self._seconds

    @property
    def path(self) -> list[TwinPose]:
        """The way that it went: at most `MOST_POSES` poses, the newest last."""
        newest = [] if self._newest is None or self._newest in self._kept[-1:] else [self._newest]
        return [*self._kept, *newest]

    @property
    def verdicts(self) -> list[RehearsalVerdict]:
        """What would have been said, each where it changed."""
        return list(self._verdicts)

    def add_pose(self, pose: TwinPose, now_ns: int) -> None:
        """Take where the twin is; what is no number is left out."""
        if not all(map(math.isfinite, pose)):
            return
        if self._newest is None:
            self._began_ns = now_ns
        else:
            self.metres += math.hypot(pose.x - self._newest.x, pose.y - self._newest.y)
        self._newest, self._seconds = pose, (now_ns - self._began_ns) / SECOND
        if not self._kept or self._is_farther(self._kept[-1], pose):
            self._kept.append(pose)
        # One place is left for the newest pose, which is where the robot will be sent.
        if len(self._kept) > MOST_POSES - 1:
            self._thin_path()

    def add_verdict(self, why: str, share: float) -> None:
        """Take what would be said of driving the robot now; only changes are kept."""
        if self._verdicts:
            last = self._verdicts[-1]
            if (last.why, last.share) == (why, share):
                return
        elif not why and share >= 1.0:
            # That all may be driven is what people expect, and needs no word.
            return
        # Beyond that many nobody reads them; the first say where it begins.
        if len(self._verdicts) < MOST_VERDICTS:
            at = max(0, len(self.path) - 1)
            self._verdicts.append(RehearsalVerdict(at=at, why=why, share=share))

    def _is_farther(self, before: TwinPose, pose: TwinPose) -> bool:
        moved = math.hypot(pose.x - before.x, pose.y - before.y)
        turned = math.remainder(pose.yaw - before.yaw, 2 * math.pi)
        return moved >= STEP_M * self._coarseness or abs(turned) >= STEP_RAD * self._coarseness

    def _thin_path(self) -> None:
        self._coarseness *= 2
        self._kept = self._kept[::2]
        self._verdicts = [
            RehearsalVerdict(at=one.at // 2, why=one.why, share=one.share) for one in self._verdicts
        ]
