"""All digital twins of a site: where what is driven in them goes. Pure.

The one place that decides whether a frame from a twin reaches the robot. It does only when the
frame says so itself, live is on for its session and epoch, and the robot's controller takes it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.driving.twin_controller import LiveHolder, TwinController, drive_frame_of
from talaia.model.twins.twin_topics import twins_of
from talaia.wire.frames import TwinOp

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.gateway.driving.drive_controller import DriveController
    from talaia.gateway.driving.drive_service import DriveService
    from talaia.gateway.ports import ControlOutput, ReadingSource
    from talaia.model.site import Site
    from talaia.wire.frames import TwinFrame, TwinRequest

__all__ = ["TwinService"]

NOT_LIVE = "live is off: nothing reached the robot"
NOT_HELD = "only who holds the lease of the robot may drive its twin"


class TwinService:
    """Twins by the device that each is of. Keeps the time of driving as well as its own."""

    def __init__(
        self,
        *,
        site: Site,
        driving: DriveService,
        readings: ReadingSource,
        output: ControlOutput,
        clock: Clock,
    ) -> None:
        """Begin with nothing live."""
        self._driving, self._readings, self._output = driving, readings, output
        self._clock = clock
        self._twins = self._made_twins(site)

    def _made_twins(self, site: Site) -> dict[str, TwinController]:
        made = {}
        for device, (name, twin) in twins_of(site).items():
            real = site.devices.get(device)
            if real is not None and real.drive is not None:
                made[device] = TwinController(
                    name=name,
                    twin=twin,
                    real=real.drive,
                    readings=self._readings,
                    output=self._output,
                )
        return made

    def redescribe(self, site: Site) -> None:
        """Take another description: live ends, and what was driven in a twin stands still."""
        now = self._clock.monotonic_ns()
        for twin in self._twins.values():
            self._end_live(twin, "its description was changed", now)
            twin.halt_twin(now, "")
        self._twins = self._made_twins(site)

    # ── from the hub ──

    def handle_frame(self, frame: TwinFrame) -> None:
        """Take what is driven in a twin; what is accepted is published before this returns."""
        twin = self._twins.get(frame.device)
        controller = self._driving.controllers.get(frame.device)
        if twin is None or controller is None:
            return
        now = self._clock.monotonic_ns()
        held = controller.lease.holder_at(now)
        if held is None or held.session != frame.session:
            twin.tell_reason(NOT_HELD)
        elif controller.latch.latched is not None:
            # A person who pressed STOP wants to see nothing move.
            twin.halt_twin(now, "STOP is on")
        elif not frame.live:
            # Whoever means the twin alone ends live by it: the two must not be mixed.
            self._end_live(twin, "the twin was driven alone", now)
            twin.drive_alone(frame, held.epoch, self._driving.ticks.age_ns(frame.tick, now), now)
        elif why := self._not_live(twin, frame, now):
            twin.tell_reason(why)
        else:
            # From here on it is a frame as any other, with every test that such a frame meets.
            self._driving.handle_frame(drive_frame_of(frame))
        twin.report_state(now)

    def handle_request(self, ask: TwinRequest) -> None:
        """Switch a twin live or alone, or forget its rehearsal."""
        twin = self._twins.get(ask.device)
        controller = self._driving.controllers.get(ask.device)
        if twin is None or controller is None:
            return
        now = self._clock.monotonic_ns()
        held = controller.lease.holder_at(now)
        if ask.op is TwinOp.ALONE:
            # Whoever may use the device may end it: that moves nothing.
            self._end_live(twin, f"switched off by {ask.who}", now)
        elif held is None or held.session != ask.session or held.epoch != ask.epoch:
            twin.tell_reason(NOT_HELD)
        elif ask.op is TwinOp.CLEAR:
            twin.clear_rehearsal()
        elif why := self._live_problem(twin, controller, now):
            self._output.record_event("twin_live_refused", ask.device, why, ask.who, good=False)
            twin.tell_reason(why)
        elif twin.live is None:
            # What is held down now was meant for the twin: it is let go before the robot moves.
            controller.driving.demand_rest(now)
            twin.switch_live(LiveHolder(held.session, held.epoch, held.who))
        twin.report_state(now, at_once=True)

    def stop_device(self, device: str) -> None:
        """Hear that STOP was pressed for the robot, after the robot was stopped."""
        twin = self._twins.get(device)
        if twin is not None:
            now = self._clock.monotonic_ns()
            self._end_live(twin, "STOP", now)
            twin.halt_twin(now, "STOP is on")
            twin.report_state(now, at_once=True)

    def link_up(self) -> None:
        """Tell a new link how things stand."""
        now = self._clock.monotonic_ns()
        for twin in self._twins.values():
            twin.report_state(now, at_once=True)

    def link_lost(self) -> None:
        """End live, and what was driven in twins."""
        now = self._clock.monotonic_ns()
        for twin in self._twins.values():
            self._end_live(twin, "the link to the hub was lost", now)
            twin.halt_twin(now, "")

    # ── time ──

    def due_ns(self) -> int | None:
        """Give when `run_due` wants to be called next, of driving and of twins."""
        now = self._clock.monotonic_ns()
        times = [self._driving.due_ns(), *(twin.due_ns(now) for twin in self._twins.values())]
        return min((one for one in times if one is not None), default=None)

    def run_due(self) -> None:
        """Do what is due now: of driving first."""
        self._driving.run_due()
        now = self._clock.monotonic_ns()
        for device, twin in self._twins.items():
            controller = self._driving.controllers.get(device)
            if twin.run_due(now) and controller is not None:
                if twin.live is not None and (why := self._live_problem(twin, controller, now)):
                    self._end_live(twin, why, now)
                if twin.is_sampling(now):
                    why = self._driving.barred_reason(device, now)
                    twin.sample_rehearsal(why, self._driving.speed_share(device, now), now)
            twin.report_state(now)

    # ── rules ──

    def _not_live(self, twin: TwinController, frame: TwinFrame, now_ns: int) -> str:
        live = twin.live
        if live is None or (live.session, live.epoch) != (frame.session, frame.epoch):
            return NOT_LIVE
        # Judged at each frame, and not only ten times a second.
        controller = self._driving.controllers[frame.device]
        if why := self._live_problem(twin, controller, now_ns):
            self._end_live(twin, why, now_ns)
        return why

    def _live_problem(self, twin: TwinController, controller: DriveController, now_ns: int) -> str:
        held = controller.lease.holder_at(now_ns)
        live = twin.live
        if held is None:
            return "nobody holds the lease"
        if live is not None and (held.session, held.epoch) != (live.session, live.epoch):
            return "the lease went to somebody else"
        if controller.latch.latched is not None:
            return "STOP is on"
        return twin.live_problem(now_ns)

    def _end_live(self, twin: TwinController, why: str, now_ns: int) -> None:
        if not twin.end_live(why):
            return
        controller = self._driving.controllers.get(twin.device)
        if controller is not None:
            # Zeros now, and nothing before the driver has let go; the reason stands no longer.
            controller.bar_driving(why, now_ns)
            controller.bar_driving("", now_ns)
            controller.driving.demand_rest(now_ns)
