"""One driven device: its lease, its velocity and its STOP together, under one clock. Pure.

Long, because the arbitration of the safety rules is decided in one place: STOP before the lease
holder, and nobody else. A controller holds no timer; it says when it wants to be called (`due_ns`).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.clock import MS, SECOND
from talaia.gateway.driving.drive_keys import KeyCounter
from talaia.gateway.driving.lease_protocol import LeaseProtocol
from talaia.gateway.driving.stop_latch import LatchedStop, StopLatch
from talaia.gateway.driving.velocity_limits import VelocityDemand, VelocityLimiter
from talaia.model.site import DriveMessage
from talaia.wire.frames import DriveState, StopState

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.driving.lease import DeviceLease
    from talaia.gateway.driving.stop_latch import StandstillProof
    from talaia.gateway.ports import ControlOutput
    from talaia.model.site import Drive as DriveRule
    from talaia.wire.frames import DriveFrame, LeaseForceRequest, LeaseRequest, LeaseState

__all__ = ["DriveController"]

# A page draws no faster, and a report per frame (25 a second) would crowd the control lane.
REPORT_NS = 100 * MS
# For this long after STOP its message goes with every zero, afterwards once in `STOP_SELDOM_NS`.
STOP_OFTEN_NS = SECOND
# Discovery takes a robot a few seconds; what is published before it listens is lost.
HALT_UNKNOWN_S = 10.0
STOP_SELDOM_NS = SECOND
# As long as robots wait before they stop by themselves: the vehicle stands between two drivers.
BETWEEN_DRIVERS_NS = SECOND // 2


class DriveController:
    """Who drives one device, and what it is told."""

    def __init__(
        self,
        *,
        device: str,
        rule: DriveRule,
        output: ControlOutput,
        next_epoch: Callable[[], int],
        stopped: LatchedStop | None,
    ) -> None:
        """Start with no lease and nothing moving; STOP as it was kept on disk."""
        self.device = device  # Name in the description; every message carries it.
        # The description's `drive`; never changed: another rule makes another controller.
        self.rule = rule
        self._output = output  # Robot, hub and record, see `ControlOutput`.
        lease_ns = round(rule.lease * SECOND)
        self.lease_protocol = LeaseProtocol(
            device=device,
            duration_ns=lease_ns,
            next_epoch=next_epoch,
            output=output,
            changed=self._handle_change,
        )
        self.driving = VelocityLimiter(rule)
        # Of a robot that is driven by characters: what was sent, and what comes next.
        self._keys = KeyCounter(rule) if rule.message is DriveMessage.KEYS else None
        # What such a robot says of its own motion, where the description names that.
        self.measured: tuple[float, float] = (math.nan, math.nan)
        # Outlives this controller on disk: a restarted gateway begins stopped where it was stopped.
        self.latch = StopLatch(rule.stop.below, stopped)
        # Between two messages to the robot at the control rate.
        self._period_ns = round(SECOND / rule.rate)
        # While STOP is on (all monotonic): when a zero and STOP itself were last sent, and since
        # when it is on. It is repeated often at first, for one message may be lost.
        self._zero_ns = 0
        self._told_robot_ns = 0
        self._stopped_ns = 0
        # Who drove last, for the record of the end: the lease may be another's by then.
        self._driver = ""
        # What the hub was last told, and when: only changes are told, and not at every frame.
        self._told: tuple[VelocityDemand, float, str, str] | None = None
        # Long enough ago that the first report goes out at once.
        self._reported_ns = -REPORT_NS
        # Why the last frame was refused; empty when it was accepted.
        self._why = ""
        # Why nobody may drive now: interlock, robot away, description being changed.
        self._barred = ""
        # A refusal is written down once for a hold.
        self._noted_refusal = False

    @property
    def lease(self) -> DeviceLease:
        """Who may drive it."""
        return self.lease_protocol.lease

    # ── lease ──

    def on_lease(self, ask: LeaseRequest | LeaseForceRequest, now_ns: int) -> None:
        """Take, renew, free, ask for, hand over or force the lease, and answer.

        Raises:
            OSError: a new epoch could not be kept on disk; nobody has got anything.

        """
        self.lease_protocol.on_ask(ask, now_ns)

    def lease_state(self, now_ns: int, asked: str = "", refused: str = "") -> LeaseState:
        """Say who holds the device."""
        return self.lease_protocol.lease_state(now_ns, asked, refused)

    def _handle_change(self, now_ns: int, why: str, *, over: bool) -> None:
        """Pass through zero: no driver, not even the same one anew, goes on from another's hold."""
        self._end_hold(now_ns, why)
        self._why = ""
        self._noted_refusal = False
        # While STOP is on the zeros come from `_step_stopped`, and no pause has to be added.
        if over and self.latch.latched is None:
            self.driving.halt_motion(now_ns)
            self.driving.demand_pause(now_ns + BETWEEN_DRIVERS_NS)
            self._publish_demand(now_ns)

    # ── driving ──

    def on_drive(self, frame: DriveFrame, age_ns: int, now_ns: int) -> None:
        """Take one frame; a wish that is accepted is published before this returns."""
        # The order of these tests is the safety rule: STOP, then interlocks, then the lease.
        held = self.lease.holder_at(now_ns)
        if self.latch.latched is not None:
            self.driving.demand_rest(now_ns)
            why = "STOP is on"
        elif self._barred:
            # Whoever still holds a key down when it is safe again has to let go first.
            self.driving.demand_rest(now_ns)
            why = self._barred
        elif held is None:
            why = "nobody holds the lease"
        # By session, not by person: two pages of one person must not drive in turns.
        elif held.session != frame.session:
            why = f"{held.who} holds the lease"
        else:
            was_moving = self.driving.moving
            why = self.driving.offer_frame(frame, held.epoch, age_ns, now_ns)
            if not why:
                self._driver = held.who
                if not was_moving:
                    self._noted_refusal = False
                    self._why = ""
                    self._output.record_event("drive_started", self.device, "", held.who, good=True)
                if self.driving.is_prompt(now_ns):
                    self._publish_demand(now_ns)
                self._report_demand(now_ns)
                return
        # What `offer` refused it has counted itself; these never reached it.
        if why in {"STOP is on", self._barred} or held is None or held.session != frame.session:
            self.driving.refused += 1
        self._record_refusal(why, "" if held is None else held.who)
        self._report_demand(now_ns)

    def bar_driving(self, why: str, now_ns: int) -> None:
        """Let nobody drive it while an interlock gives this reason; none when it is empty."""
        self._barred = why
        if why and self.driving.moving:
            self._end_hold(now_ns, why)

    def limit_speed(self, share: float) -> None:
        """Let it be driven at this share of its limits, 0 to 1; from the next demand on."""
        self.driving.share = share

    def _record_refusal(self, why: str, who: str) -> None:
        changed, self._why = why != self._why, why
        if changed and not self._noted_refusal:
            # Once for a hold: a page that drives on in vain must not fill the record.
            self._noted_refusal = True
            self._output.record_event("drive_refused", self.device, why, who, good=False)

    def _publish_demand(self, now_ns: int) -> None:
        was_moving = self.driving.moving
        demand = self.driving.next_demand(now_ns)
        if demand is not None:
            self._send_demand(demand)
        if was_moving and not self.driving.moving:
            self._note_end("no fresh frame")

    def _send_demand(self, demand: VelocityDemand) -> None:
        """Tell the robot a velocity, or the next character towards it if there is one."""
        if self._keys is None:
            self._output.drive(self.device, demand)
        elif key := self._keys.next_key(
            (demand.linear, demand.angular), self.driving.cap, self.measured
        ):
            self._output.drive(self.device, demand, key)

    def robot_back(self, now_ns: int) -> None:
        """Halt a robot that keeps its velocity by itself: what it was sent before is not known.

        Also at the gateway's start, for the one before may have been killed while it drove.
        """
        if self._keys is not None and not self.driving.moving:
            self.driving.halt_motion(now_ns, HALT_UNKNOWN_S)

    def _end_hold(self, now_ns: int, why: str) -> None:
        """End a hold, if one is on, with zeros."""
        if self.driving.moving:
            self.driving.halt_motion(now_ns)
            self._note_end(why)
        if not self.driving.silent:
            self._publish_demand(now_ns)

    def _note_end(self, why: str) -> None:
        count = f"{self.driving.accepted} frames, {self.driving.refused} refused"
        self.driving.refused = 0
        self._output.record_event(
            "drive_ended", self.device, f"{why}; {count}", self._driver, good=True
        )

    def _report_demand(self, now_ns: int) -> None:
        """Tell the hub what the robot is told, when it changed, at most ten times a second."""
        driving = self.driving
        linear, angular = driving.output[:2] if self._keys is None else self._keys.velocity
        sent = "" if self._keys is None else self._keys.sent
        why = self._why or driving.joint_reason
        told = (driving.output, driving.cap, why, sent)
        if told == self._told or now_ns - self._reported_ns < REPORT_NS:
            return
        self._told, self._reported_ns = told, now_ns
        self._output.send(
            DriveState(
                device=self.device,
                linear=linear,
                angular=angular,
                lateral=driving.output.lateral,
                steering=driving.output.steering,
                joints=list(driving.output.joints),
                sent=sent,
                cap=driving.cap,
                loop_ms=driving.loop_ms,
                accepted=driving.accepted,
                refused=driving.refused,
                why=why,
            )
        )

    # ── STOP ──

    def on_stop(self, latched: LatchedStop, now_ns: int) -> bool:
        """Stop now and answer; tell whether it was open before, so that it is kept on disk."""
        # Zeros first, then disk and record: nothing may stand before stopping.
        fresh = self.latch.request_stop(latched, now_ns)
        self._end_hold(now_ns, "STOP")
        if fresh:
            self._stopped_ns = now_ns
            self.driving.demand_rest(now_ns)
            self._say_stop(now_ns)
            self._say_zero(now_ns)
            self._output.record_event(
                "stop", self.device, "STOP (software)", latched.who, good=False
            )
        self._output.send(self.stop_state(latched.id))
        return fresh

    def on_reset(self, who: str, now_ns: int) -> None:
        # Only the latch opens here; `DriveService.reset_stop` has checked token and disk.
        """Release STOP, after token and disk; nothing moves by this."""
        self.latch.release_latch()
        self.driving.halt_motion(now_ns)
        self.driving.demand_rest(now_ns)
        self._output.stop(self.device, stopped=False)
        self._output.record_event("stop_reset", self.device, "", who, good=True)
        self._output.send(self.stop_state())

    def stop_state(self, asked: str = "") -> StopState:
        """Say whether it is stopped, answering the ask with this id if any."""
        latched = self.latch.latched
        if latched is None:
            return StopState(device=self.device, latched=False, id=asked)
        return StopState(
            device=self.device,
            latched=True,
            confirmed=self.latch.confirmed,
            who=latched.who,
            time_us=latched.time_us,
            id=asked or latched.id,
        )

    def _say_stop(self, now_ns: int) -> None:
        self._told_robot_ns = now_ns
        self._output.stop(self.device, stopped=True)

    def _say_zero(self, now_ns: int) -> None:
        self._zero_ns = now_ns
        self._send_demand(self.driving.zero)

    # ── time and link ──

    def end_lease(self, now_ns: int, why: str, *, stop_robot: bool) -> None:
        """End lease and hold; where the description says so, zeros even if nobody drove."""
        self.lease_protocol.end_lease()
        was_moving = self.driving.moving
        self._end_hold(now_ns, why)
        # Somebody who moved has had zeros from `_end_hold`; this is for a robot nobody drove.
        if stop_robot and not was_moving:
            self.driving.halt_motion(now_ns)
            self._publish_demand(now_ns)

    def due_ns(self) -> int | None:
        """Give when `run_due` wants to be called next, or none."""
        times = []
        if self.latch.latched is not None:
            times += [self._zero_ns + self._period_ns]
        elif (turn := self.driving.due_ns()) is not None:
            times.append(turn)
        # A report held back by `REPORT_NS` still has to go out when frames cease.
        if self._told is not None and self._told[0] != self.driving.output:
            times.append(self._reported_ns + REPORT_NS)
        if (until := self.lease.until_ns()) is not None:
            times.append(until)
        return min(times, default=None)

    def run_due(self, now_ns: int, proofs: Callable[[], list[StandstillProof | None]]) -> None:
        """Do what is due: lease that ends, zeros, STOP repeated and judged, reports."""
        self.lease_protocol.settle_due(now_ns)
        if self.latch.latched is not None:
            self._step_stopped(now_ns, proofs)
        else:
            turn = self.driving.due_ns()
            if turn is not None and now_ns >= turn:
                self._publish_demand(now_ns)
        self._report_demand(now_ns)

    def _step_stopped(
        self, now_ns: int, proofs: Callable[[], list[StandstillProof | None]]
    ) -> None:
        # The zeros keep the control rate: a robot's own watchdog must see them as from a driver.
        if now_ns - self._zero_ns >= self._period_ns:
            self._say_zero(now_ns)
            self.driving.next_demand(now_ns)
            early = now_ns - self._stopped_ns <= STOP_OFTEN_NS
            if early or now_ns - self._told_robot_ns >= STOP_SELDOM_NS:
                self._say_stop(now_ns)
        if self.latch.judge_standstill(proofs(), now_ns):
            self._output.send(self.stop_state())
