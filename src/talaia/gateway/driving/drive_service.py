"""All driven devices of a site: gives each message to its controller, sends ticks, keeps time.

Messages are acted on inside the call that brings them; what must be repeated waits for `run_due`,
which a timer calls at `due_ns`. Only writing STOP to disk leaves the caller's thread, and it
never stands before stopping.

Long, because all that may end a hold (people, link, robot, another description) stands here.
"""

from __future__ import annotations

import secrets
from functools import partial
from typing import TYPE_CHECKING

from talaia.gateway.driving.drive_controller import DriveController
from talaia.gateway.driving.motion_readings import MotionReadings
from talaia.gateway.driving.stop_latch import LatchedStop
from talaia.gateway.driving.tick_clock import TICK_NS, TickClock
from talaia.model.site import LinkLoss
from talaia.wire.frames import ControlTick, ResetToken

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.clock import Clock
    from talaia.gateway.driving.stop_writer import StopWriter
    from talaia.gateway.ports import ControlOutput, ReadingSource
    from talaia.gateway.safety.interlocks import Interlocks
    from talaia.model.site import Site
    from talaia.wire.frames import (
        DriveFrame,
        LeaseForceRequest,
        LeaseRequest,
        OverrideRequest,
        ResetRequest,
        StopRequest,
    )

__all__ = ["DriveService"]

CHANGING = "its description is being changed"


class DriveService:
    """Driving, leases and STOP of a site."""

    def __init__(
        self,
        *,
        site: Site,
        clock: Clock,
        output: ControlOutput,
        readings: ReadingSource,
        next_epoch: Callable[[], int],
        stops: StopWriter,
        interlocks: Interlocks | None = None,
    ) -> None:
        """Make a controller for each driven device.

        Args:
            site: the description.
            clock: monotonic for every decision, wall only for the record.
            output: see `ControlOutput`.
            readings: for the confirmation of STOP.
            next_epoch: see `DeviceLease`.
            stops: latches kept on disk.
            interlocks: say when a device may not be driven; kept in time with the rest.

        """
        self._clock = clock  # Monotonic for each decision; wall time only in records.
        self._output = output  # Where every message to hub and robot goes.
        self._stops = stops  # STOP latches on disk; may lag behind memory, never ahead of it.
        self._interlocks = interlocks  # None where the site has no interlocks.
        self._next_epoch = next_epoch
        self._motion = MotionReadings(site, readings)
        # Sent while anybody holds a lease; drivers echo them.
        self.ticks = TickClock()
        # Say who acts on a device by a command, against a person; set by who makes both.
        self.acting_against: Callable[[str, str], str] = lambda _device, _who: ""
        # Whether there is a hub: a link that was never up cannot be lost.
        self._linked = False
        # Devices whose robot cannot be told anything now.
        self._away: set[str] = set()
        # Devices whose description is about to change: nobody drives them until it has.
        self._changing: frozenset[str] = frozenset()
        # By device. Replaced by `redescribe`; a controller of an unchanged rule is carried over.
        self.controllers = {
            name: DriveController(
                device=name,
                rule=device.drive,
                output=output,
                next_epoch=next_epoch,
                stopped=stops.latched_stop(name),
            )
            for name, device in site.devices.items()
            if device.drive is not None
        }
        for controller in self.controllers.values():
            controller.robot_back(clock.monotonic_ns())

    @property
    def busy(self) -> bool:
        """Whether somebody holds the lease of a device."""
        return self._anyone_holds()

    # ── from the hub ──

    def handle_lease(self, ask: LeaseRequest | LeaseForceRequest) -> None:
        """Take, renew, free, ask for, hand over or force a lease."""
        now = self._clock.monotonic_ns()
        controller = self.controllers.get(ask.device)
        if controller is None:
            self._output.record_event(
                "lease_refused", "", f"no such driven device: {ask.device}", ask.who, good=False
            )
            return
        before = controller.lease.holder_at(now)
        try:
            controller.on_lease(ask, now)
        except OSError as error:
            # No new epoch could be reserved on disk: nobody gets the lease, all else goes on.
            refused = f"the gateway cannot write its disk: {error}"
            self._output.send(controller.lease_state(now, ask.session, refused))
            return
        held = controller.lease.holder_at(now)
        # Not on a renewal: only a new epoch has a driver who has seen no tick yet.
        if held is not None and (before is None or before.epoch != held.epoch):
            # So that the new driver need not wait for a tick to echo.
            self._send_tick(now)

    def handle_frame(self, frame: DriveFrame) -> None:
        """Take a driving frame; what is accepted is published before this returns."""
        controller = self.controllers.get(frame.device)
        if controller is not None:
            now = self._clock.monotonic_ns()
            controller.bar_driving(self._barred_now(controller, now), now)
            controller.limit_speed(self.speed_share(frame.device, now))
            controller.measured = self._motion.measured_velocity(controller.rule, now)
            controller.driving.joint_places = self._motion.joint_places(controller.rule, now)
            controller.on_drive(frame, self.ticks.age_ns(frame.tick, now), now)

    def stop_device(self, ask: StopRequest) -> LatchedStop | None:
        """Stop at once; give what `keep_stop` is to write when it was not stopped before."""
        controller = self.controllers.get(ask.device)
        if controller is None:
            problem = f"STOP for {ask.device}, which is not a driven device"
            self._output.record_event("stop_refused", "", problem, ask.who, good=False)
            return None
        latched = LatchedStop(ask.id, ask.who, self._clock.wall_ns() // 1000)
        return latched if controller.on_stop(latched, self._clock.monotonic_ns()) else None

    async def keep_stop(self, device: str, latched: LatchedStop) -> None:
        """Write a STOP to disk, so that it survives a restart."""
        await self._stops.write_stop(device, latched)

    async def write_waiting(self) -> None:
        """Try again to write each STOP that the disk did not take."""
        await self._stops.write_waiting()

    async def reset_stop(self, ask: ResetRequest) -> None:
        """Give a token, or take it and release STOP."""
        controller = self.controllers.get(ask.device)
        if controller is None:
            return
        now = self._clock.monotonic_ns()
        held = controller.lease.holder_at(now)
        token, refused = "", ""
        if held is None or held.session != ask.session or held.epoch != ask.epoch:
            refused = "only who holds the lease may reset STOP"
        elif not ask.token:
            # Two steps: a token first, which the page shows as a second press. 16 bytes cannot be
            # guessed, and no other session can send it.
            token = secrets.token_urlsafe(16)
            refused = controller.latch.offer_token(ask.session, token, now)
        else:
            refused = controller.latch.check_token(ask.session, ask.token, now)
        if refused or not ask.token:
            self._answer_reset(ask, "" if refused else token, refused)
            return
        await self._release_stop(controller, ask)

    async def _release_stop(self, controller: DriveController, ask: ResetRequest) -> None:
        # Disk before memory: after a crash between the two it must be stopped, never released.
        was = controller.latch.latched
        if refused := await self._stops.write_release(controller.device):
            self._answer_reset(ask, "", refused)
            return
        # While the disk wrote, somebody may have stopped it again; that STOP stays.
        if controller.latch.latched is was:
            controller.on_reset(ask.who, self._clock.monotonic_ns())

    def _answer_reset(self, ask: ResetRequest, token: str, refused: str) -> None:
        self._output.send(
            ResetToken(device=ask.device, session=ask.session, token=token, refused=refused)
        )

    # ── another description ──

    def leave_devices(self, devices: Collection[str]) -> None:
        """End leases and holds of devices whose description is about to change, with zeros.

        Nobody drives them until `redescribe`, or until this is called with none.
        """
        self._changing = frozenset(devices)
        now = self._clock.monotonic_ns()
        for device in devices:
            if (controller := self.controllers.get(device)) is not None:
                held = controller.lease.holder_at(now) is not None
                controller.end_lease(now, CHANGING, stop_robot=False)
                if held:
                    self._output.send(controller.lease_state(now))

    def is_silent(self, devices: Collection[str]) -> bool:
        """Tell whether all zeros of these devices have been published."""
        controllers = [self.controllers[device] for device in devices if device in self.controllers]
        return all(controller.driving.silent for controller in controllers)

    def redescribe(self, site: Site, devices: Collection[str]) -> None:
        """Take another description, after `leave_devices` with the ``devices`` that it touches.

        Those that are not touched go on as they were, drivers included. STOP stays where it is.
        """
        now = self._clock.monotonic_ns()
        # Whoever took a lease since then has driven nothing, for it was barred.
        self.leave_devices([device for device in devices if device in self.controllers])
        self._motion.redescribe(site)
        before, self._changing = self.controllers, frozenset()
        self.controllers = {}
        for name, device in site.devices.items():
            if device.drive is None:
                continue
            controller = before.get(name)
            if controller is None or controller.rule != device.drive:
                kept = self._stops.latched_stop(name)
                stopped = kept if controller is None else controller.latch.latched
                controller = DriveController(
                    device=name,
                    rule=device.drive,
                    output=self._output,
                    next_epoch=self._next_epoch,
                    stopped=stopped,
                )
                self._output.send(controller.stop_state())
                self._output.send(controller.lease_state(now))
            self.controllers[name] = controller
        self._away &= site.devices.keys()

    # ── link and time ──

    def link_up(self) -> None:
        """Tell a new link how things stand. Nothing is replayed and nobody holds anything."""
        self._linked = True
        now = self._clock.monotonic_ns()
        for controller in self.controllers.values():
            self._output.send(controller.stop_state())
            self._output.send(controller.lease_state(now))
        if self._interlocks is not None:
            self._interlocks.link_up(now)

    def link_lost(self) -> None:
        """End every lease and every hold."""
        if not self._linked:
            return
        self._linked = False
        now = self._clock.monotonic_ns()
        for controller in self.controllers.values():
            controller.end_lease(
                now, "link lost", stop_robot=controller.rule.link_loss is LinkLoss.STOP
            )
        if self._interlocks is not None:
            self._interlocks.link_lost(now)

    def robot_lost(self, devices: Collection[str]) -> None:
        """End leases and holds of devices that cannot be told anything now; nobody drives them."""
        now = self._clock.monotonic_ns()
        self._away.update(devices)
        for device in devices:
            if (controller := self.controllers.get(device)) is not None:
                controller.end_lease(now, "the robot's side was lost", stop_robot=False)
                self._output.send(controller.lease_state(now))

    def robot_back(self, devices: Collection[str]) -> None:
        """Let them be driven again, by whoever lets go first; STOP is being repeated anyway."""
        self._away.difference_update(devices)
        for device in devices:
            if (controller := self.controllers.get(device)) is not None:
                controller.robot_back(self._clock.monotonic_ns())

    def override_interlock(self, ask: OverrideRequest) -> None:
        """Override an interlock for a time, or end that."""
        if self._interlocks is not None:
            self._interlocks.handle_override(ask, self._clock.monotonic_ns())

    def halt_all(self) -> None:
        """End every hold with a zero now: the process is about to end."""
        now = self._clock.monotonic_ns()
        for controller in self.controllers.values():
            controller.end_lease(now, "the gateway ends", stop_robot=False)

    def due_ns(self) -> int | None:
        """Give when `run_due` wants to be called next (monotonic), or none while all rests."""
        times = [
            due
            for controller in self.controllers.values()
            if (due := controller.due_ns()) is not None
        ]
        if self._anyone_holds():
            times.append(self.ticks.last_ns + TICK_NS)
        if self._interlocks is not None and (look := self._interlocks.due_ns()) is not None:
            times.append(look)
        return min(times, default=None)

    def run_due(self) -> None:
        """Do what is due now."""
        now = self._clock.monotonic_ns()
        if self._interlocks is not None:
            self._interlocks.evaluate_all(now)
        for controller in self.controllers.values():
            # Whoever drives when it becomes unsafe is stopped by this, and not by the next frame.
            if controller.driving.moving:
                controller.bar_driving(self._barred_now(controller, now), now)
                controller.limit_speed(self.speed_share(controller.device, now))
                controller.driving.joint_places = self._motion.joint_places(controller.rule, now)
            controller.run_due(now, partial(self._motion.standstill_proofs, controller.rule))
        if self._anyone_holds() and now - self.ticks.last_ns >= TICK_NS:
            self._send_tick(now)

    def barred_reason(self, device: str, now_ns: int) -> str:
        """Say why nobody may drive a device now; empty when somebody may."""
        if device in self._changing:
            return CHANGING
        if device in self._away:
            return "the robot's side cannot be reached now"
        if self._interlocks is None:
            return ""
        return self._interlocks.refusal_reason(device, "drive", now_ns)

    def _barred_now(self, controller: DriveController, now_ns: int) -> str:
        """Say why its holder may not drive now: also because somebody else's command acts on it."""
        if barred := self.barred_reason(controller.device, now_ns):
            return barred
        held = controller.lease.holder_at(now_ns)
        return "" if held is None else self.acting_against(controller.device, held.who)

    def speed_share(self, device: str, now_ns: int) -> float:
        """Say at which share of its limits a device may be driven now, 0 to 1."""
        return 1.0 if self._interlocks is None else self._interlocks.speed_share(device, now_ns)

    def _anyone_holds(self) -> bool:
        now = self._clock.monotonic_ns()
        return any(
            controller.lease.holder_at(now) is not None for controller in self.controllers.values()
        )

    def _send_tick(self, now_ns: int) -> None:
        self._output.send(ControlTick(tick=self.ticks.next_tick(now_ns)))
