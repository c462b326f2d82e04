"""Which devices the robot's side answers for now, and why not. Pure but for the clock."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.clock import MS
from talaia.wire.frames import DeviceState

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.clock import Clock

__all__ = ["DeviceReachability"]


class DeviceReachability:
    """Says each change once; what a device shows counts for nothing while it is not reached.

    A device is reached when its connection is there and nothing speaks against itself. One
    thread.
    """

    def __init__(
        self, of: Mapping[str, str], clock: Clock, say: Callable[[DeviceState], None]
    ) -> None:
        """Begin with all of them reached.

        Args:
            of: by device: the name of its connection, or an empty one.
            clock: for how long it has been so.
            say: told of every change.

        """
        self._of = of  # By device: its connection's name.
        self._clock = clock  # Monotonic: for how long, not since when.
        self._say = say  # Sends to the hub.
        self._lost: dict[str, str] = {}  # By connection: why it is gone.
        # By device: why it alone does not answer, though its connection is there.
        self._away: dict[str, str] = {}
        # Of those away, the ones that may only be slow: their last values count on.
        self._slow: set[str] = set()
        # By device that is not reached: the reason that was told, and since when (monotonic ns).
        self._said: dict[str, tuple[str, int]] = {}

    def redescribe(self, of: Mapping[str, str]) -> None:
        """Take other devices; what was known of those that stay where they were stays true."""
        # Also those that are gone: `of` has no name for them.
        moved = {device for device, name in self._of.items() if of.get(device) != name}
        self._of = of
        for device in moved:
            self._away.pop(device, None)
            if device in of:
                self._report_change(device)
            else:
                # The hub hears of it by the new description; no state is told of what is not
                # described.
                self._said.pop(device, None)
        for device in of:
            self._report_change(device)

    def mark_lost(self, connection: str, why: str) -> list[str]:
        """Take a connection as gone; give its devices."""
        self._lost[connection] = why
        devices = self.devices_of(connection)
        for device in devices:
            # When it is back, everything is heard anew.
            self._away.pop(device, None)
            self._slow.discard(device)
            self._report_change(device)
        return devices

    def mark_back(self, connection: str) -> list[str]:
        """Take a connection as there; give its devices."""
        self._lost.pop(connection, None)
        devices = self.devices_of(connection)
        for device in devices:
            self._report_change(device)
        return devices

    def device(self, device: str, *, there: bool, why: str = "", sure: bool = True) -> None:
        """Take one device as answering, or not."""
        if device not in self._of:
            return
        if there:
            self._away.pop(device, None)
        else:
            self._away[device] = why or "it does not answer"
        # Sure, or there again: either way it is not merely slow.
        if there or sure:
            self._slow.discard(device)
        else:
            self._slow.add(device)
        self._report_change(device)

    def devices_of(self, connection: str) -> list[str]:
        """Name the devices of a connection."""
        return [device for device, name in self._of.items() if name == connection]

    def is_reached(self, device: str) -> bool:
        """Tell whether a device is reached now."""
        return not self._unreached_reason(device)

    def still_counts(self, device: str) -> bool:
        """Tell whether what a device said last still counts, for as long as it is not too old."""
        return self.is_reached(device) or (
            # Of a lost connection nothing counts, however slow its device was thought to be.
            device in self._slow and not self._lost.get(self._of.get(device, ""))
        )

    def report_unreached(self) -> None:
        """Say it of all that are not reached, to a hub that has just come."""
        for device in self._said:
            self._say(self._device_state(device))

    def _unreached_reason(self, device: str) -> str:
        # The connection first: it explains all of its devices.
        return self._lost.get(self._of.get(device, "")) or self._away.get(device, "")

    def _report_change(self, device: str) -> None:
        why = self._unreached_reason(device)
        said = self._said.get(device)
        if why == (said[0] if said is not None else ""):
            return
        if why:
            # The reason may change while it lasts; since when it is so does not.
            since = said[1] if said is not None else self._clock.monotonic_ns()
            self._said[device] = (why, since)
        else:
            del self._said[device]
        self._say(self._device_state(device))

    def _device_state(self, device: str) -> DeviceState:
        why, since = self._said.get(device, ("", 0))
        # A duration: the hub's clock may be another.
        passed = (self._clock.monotonic_ns() - since) // MS if why else 0
        return DeviceState(device=device, reached=not why, why=why[:2000], for_ms=passed)
