"""Routes what is decided here: to the robot, to the hub, to the record and to recorders."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from talaia.model.recording import Trigger
from talaia.wire.frames import EnclosureState, Event

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.ports import CommandTarget
    from talaia.gateway.recording.recorders import TriggeredRecorder
    from talaia.gateway.uplink.send_lanes import SendLanes
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.wire.frames import FromGateway

__all__ = ["OutputRouter"]

log = logging.getLogger(__name__)
# What is noted, and what it means to who records.
_CAUSES = {"stop": Trigger.STOP, "interlock_locked": Trigger.INTERLOCK}


class OutputRouter:
    """A `ControlOutput`. Event loop only.

    Attributes:
        takes_enclosures: whether the hub of this link takes `EnclosureState`; others hear of
            enclosures only here.

    """

    def __init__(
        self,
        *,
        adapter: CommandTarget,
        lanes: SendLanes,
        clock: Clock,
        recorders: TriggeredRecorder | None,
    ) -> None:
        """Route to these; with no ``recorders`` nothing is recorded."""
        self._adapter = adapter
        self._lanes = lanes
        self._clock = clock
        self._recorders = recorders
        self.takes_enclosures = False
        self._enclosure_listeners: list[Callable[[EnclosureState], None]] = []

    def subscribe_enclosures(self, listener: Callable[[EnclosureState], None]) -> None:
        """Tell a part of the gateway how enclosures stand, whatever the hub takes."""
        self._enclosure_listeners.append(listener)

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """Publish a velocity."""
        self._adapter.drive(device, demand, key)

    def stop(self, device: str, *, stopped: bool) -> None:
        """Publish on the STOP topic."""
        self._adapter.stop(device, stopped=stopped)

    def send(self, message: FromGateway) -> None:
        """Send to the hub."""
        # Listeners hear of it even without a hub: notices go out by this.
        if isinstance(message, EnclosureState):
            for listener in self._enclosure_listeners:
                listener(message)
            if not self.takes_enclosures:
                return
        self._lanes.send(message)

    def record_event(self, kind: str, device: str, message: str, who: str, *, good: bool) -> None:
        """Write down, here and at the hub."""
        log.info("%s %s %s %s", kind, device, message, who)
        if self._recorders is not None and kind in _CAUSES:
            why = " ".join(filter(None, (message, f"({device})" if device else "")))
            self._recorders.trigger_recording(_CAUSES[kind], why, who)
        self._lanes.send(
            Event(
                kind=kind,
                device=device,
                message=message[:2000],
                who=who,
                time_us=self._clock.wall_ns() // 1000,
                good=good,
            )
        )
