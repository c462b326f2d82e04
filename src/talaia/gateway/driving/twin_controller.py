"""One digital twin at the gateway: its switch, what drives it alone, and its rehearsal. Pure.

What reaches the robot goes through the robot's own controller, which is not known here: this file
can only say whether it may (`live_problem`, `LiveHolder`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import MS, SECOND
from talaia.gateway.driving.rehearsal import Rehearsal, TwinPose
from talaia.gateway.driving.velocity_limits import VelocityLimiter
from talaia.model.twins.twin import TwinMode
from talaia.model.twins.twin_topics import twin_drive
from talaia.wire.frames import DriveFrame, TwinState

if TYPE_CHECKING:
    from talaia.gateway.ports import ControlOutput, ReadingSource
    from talaia.model.site import Drive
    from talaia.model.twins.twin import Twin
    from talaia.wire.frames import TwinFrame

__all__ = ["TwinController", "drive_frame_of"]

# The twin speaks fifty times a second, and of its mode twice.
HEARD_NS = SECOND
MODE_NS = 3 * SECOND // 2
# Pages draw a path no faster.
REPORT_NS = 200 * MS
SAMPLE_NS = 100 * MS


class LiveHolder(NamedTuple):
    """For whom a twin is live: a session and the epoch of its lease."""

    session: str
    epoch: int
    who: str


class TwinController:
    """Event loop only; times are the gateway's monotonic ones (ns)."""

    def __init__(
        self,
        *,
        name: str,
        twin: Twin,
        real: Drive,
        readings: ReadingSource,
        output: ControlOutput,
    ) -> None:
        """Begin with live switched off and nothing driven."""
        self.name, self.device = name, twin.of
        self._twin, self._readings, self._output = twin, readings, output
        self.limiter = VelocityLimiter(twin_drive(real, name))
        # For whom it is live; none: for nobody.
        self.live: LiveHolder | None = None
        self.rehearsal = Rehearsal()
        # Why it is off, or why the last frame was refused.
        self._why = ""
        # The path is of one rehearsal: another begins a new one.
        self._rehearsing = False
        self._sampled_ns = 0
        self._reported_ns = -REPORT_NS
        self._changed = True

    # ── what the twin says ──

    def mode_at(self, now_ns: int) -> TwinMode | None:
        """Give what the twin does; none when it is not heard."""
        mode = self._fresh_value("mode", MODE_NS, now_ns)
        alive = self._fresh_value("pose.x", HEARD_NS, now_ns) is not None
        known = mode is not None and alive and mode in TwinMode.__members__.values()
        return TwinMode(int(mode)) if known and mode is not None else None

    def live_problem(self, now_ns: int) -> str:
        """Say why the twin may not be live now; empty when it may."""
        mode = self.mode_at(now_ns)
        if mode is None:
            return "the twin is not heard"
        if mode is not TwinMode.FOLLOWING:
            return f"the twin is {mode.name.lower()} and does not follow the robot"
        error = self._fresh_value("pose_error", HEARD_NS, now_ns)
        if error is None:
            return "the twin does not say how far it is from the robot"
        # Written so that an error that is no number is one, too.
        if not error <= self._twin.reset_beyond:
            return f"the twin is {error:.2f} m from the robot"
        return ""

    def _fresh_value(self, channel: str, age_ns: int, now_ns: int) -> float | None:
        reading = self._readings.latest(f"{self.name}/{channel}")
        if reading is None or now_ns - reading.mono_ns > age_ns:
            return None
        return reading.value

    # ── its switch ──

    def switch_live(self, holder: LiveHolder) -> None:
        """Let what this session drives in the twin go to the robot, until `end_live`."""
        self.live, self._why, self._changed = holder, "", True
        self._output.record_event("twin_live", self.device, self.name, holder.who, good=True)

    def end_live(self, why: str) -> bool:
        """Let nothing more go to the robot; tells whether it was live."""
        if self.live is None:
            return False
        who, self.live = self.live.who, None
        self._output.record_event("twin_alone", self.device, why, who, good=True)
        self.tell_reason(why)
        return True

    def tell_reason(self, why: str) -> None:
        """Keep what pages are told of why it is off or refused; empty: all is well."""
        if why != self._why:
            self._why, self._changed = why, True

    # ── what drives it alone ──

    def drive_alone(self, frame: TwinFrame, epoch: int, age_ns: int, now_ns: int) -> None:
        """Take a frame of who holds the lease, for the twin and nothing else."""
        why = self.limiter.offer_frame(drive_frame_of(frame), epoch, age_ns, now_ns)
        self.tell_reason(why)
        if not why and self.limiter.is_prompt(now_ns):
            self._publish_demand(now_ns)

    def halt_twin(self, now_ns: int, why: str) -> None:
        """End what drives the twin alone, with zeros to the twin."""
        if self.limiter.moving:
            self.limiter.halt_motion(now_ns)
            self._publish_demand(now_ns)
        self.limiter.demand_rest(now_ns)
        self.tell_reason(why)

    def clear_rehearsal(self) -> None:
        """Forget the path and what would have been said of it."""
        self.rehearsal, self._changed = Rehearsal(), True

    # ── time ──

    def due_ns(self, now_ns: int) -> int | None:
        """Give when `run_due` wants to be called next; none while all rests."""
        times = [self.limiter.due_ns()]
        if self.live is not None or self.limiter.moving or self.is_sampling(now_ns):
            times.append(self._sampled_ns + SAMPLE_NS)
        if self._changed:
            times.append(self._reported_ns + REPORT_NS)
        return min((one for one in times if one is not None), default=None)

    def is_sampling(self, now_ns: int) -> bool:
        """Tell whether a rehearsal is on."""
        return self.mode_at(now_ns) is TwinMode.REHEARSING

    def run_due(self, now_ns: int) -> bool:
        """Publish what is due; tells whether it is time to judge and sample the rehearsal."""
        turn = self.limiter.due_ns()
        if turn is not None and now_ns >= turn:
            self._publish_demand(now_ns)
        if now_ns - self._sampled_ns < SAMPLE_NS:
            return False
        self._sampled_ns = now_ns
        mode = self.mode_at(now_ns)
        if mode is TwinMode.REHEARSING and not self._rehearsing:
            self._rehearsing = True
            self.clear_rehearsal()
        # One that is not heard for a moment still rehearses.
        elif mode is TwinMode.FOLLOWING:
            self._rehearsing = False
        return True

    def sample_rehearsal(self, why: str, share: float, now_ns: int) -> None:
        """Add where the twin is, and what would be said of driving the robot now."""
        values = [self._fresh_value(f"pose.{part}", HEARD_NS, now_ns) for part in ("x", "y", "yaw")]
        x, y, yaw = values
        if x is None or y is None or yaw is None:
            return
        before = (len(self.rehearsal.path), self.rehearsal.metres)
        self.rehearsal.add_pose(TwinPose(x, y, yaw), now_ns)
        self.rehearsal.add_verdict(why, share)
        if before != (len(self.rehearsal.path), self.rehearsal.metres):
            self._changed = True

    def report_state(self, now_ns: int, *, at_once: bool = False) -> None:
        """Tell the hub how it stands, when that changed and not too often."""
        if not at_once and (not self._changed or now_ns - self._reported_ns < REPORT_NS):
            return
        self._changed, self._reported_ns = False, now_ns
        self._output.send(
            TwinState(
                device=self.device,
                twin=self.name,
                live=self.live is not None,
                who="" if self.live is None else self.live.who,
                why=self._why,
                path=[number for pose in self.rehearsal.path for number in pose],
                metres=self.rehearsal.metres,
                seconds=self.rehearsal.seconds,
                verdicts=self.rehearsal.verdicts,
            )
        )

    def _publish_demand(self, now_ns: int) -> None:
        demand = self.limiter.next_demand(now_ns)
        if demand is not None:
            self._output.drive(self.name, demand)


def drive_frame_of(frame: TwinFrame) -> DriveFrame:
    """Give the driving frame that a twin's frame stands for."""
    return DriveFrame(
        device=frame.device,
        session=frame.session,
        epoch=frame.epoch,
        seq=frame.seq,
        tick=frame.tick,
        held_ms=frame.held_ms,
        linear=frame.linear,
        angular=frame.angular,
        picture_ms=frame.picture_ms,
    )
