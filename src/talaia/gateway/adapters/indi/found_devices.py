"""Devices that an INDI server has and the description does not name, or names with less.

A set of devices is told once, and only when the server has been quiet for a while: whoever hears of
it describes the gateway anew, which must not happen for each property of a burst.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.clock import SECOND
from talaia.gateway.adapters.indi.discovery import devices_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.indi.driver_connections import DriverConnections
    from talaia.gateway.adapters.indi.state import IndiDevice, IndiDeviceTree
    from talaia.gateway.ports import AdapterStatus
    from talaia.model.connection import IndiConnection
    from talaia.model.site import Device

__all__ = ["FoundDevices"]

# Drivers define their properties in bursts; after so long without one, that was all.
QUIET_NS = 2 * SECOND


class FoundDevices:
    """What is found at one server. On the event loop."""

    def __init__(
        self,
        scope: ConnectionScope,
        settings: IndiConnection,
        connections: DriverConnections,
        status: AdapterStatus,
    ) -> None:
        """Take what is described, what may be found, how drivers stand, and who is told."""
        self._scope, self._settings = scope, settings
        self._connections, self._status = connections, status
        # By the INDI device: its name in the description.
        self._described = {
            device.indi: name for name, device in scope.devices.items() if device.indi
        }
        # When the server defined something new last.
        self._changed_ns = 0
        self._reported: dict[str, Device] = {}

    def note_change(self, now_ns: int) -> None:
        """Wait anew for quiet: a property was defined that was not known."""
        self._changed_ns = now_ns

    def is_served(self, name: str) -> bool:
        """Tell whether an INDI device is described, or may be found."""
        if name in self._described:
            return True
        wanted = self._settings.devices
        return self._settings.discover and (not wanted or name in wanted)

    def report_found(self, tree: IndiDeviceTree, now_ns: int) -> None:
        """Tell of devices that are not described, once nothing new has come for a while."""
        if not self._settings.discover or now_ns - self._changed_ns < QUIET_NS:
            return
        found = [
            device for device in tree if self.is_served(device.name) and self._is_whole(device)
        ]
        new = devices_of(
            [device for device in found if device.name not in self._described],
            self._scope.name,
            self._described.values(),
        )
        grown = self._grown_devices([device for device in found if device.name in self._described])
        all_found = {**new, **grown}
        if all_found and all_found != self._reported:
            self._reported = all_found
            self._status.found(all_found)

    def _is_whole(self, device: IndiDevice) -> bool:
        """Tell whether a driver has defined all it will, as far as one can know.

        Before it is connected to its hardware it shows little; one that does not connect after
        some tries, or is not to be connected, is told with what it has.
        """
        return (
            device.connected
            or "CONNECTION" not in device.vectors
            or self._connections.count_tries(device.name) > 1
            or not self._settings.connect
        )

    def _grown_devices(self, found: list[IndiDevice]) -> Mapping[str, Device]:
        """Give those that have more than when they were found: a driver connected only now."""
        grown = {}
        for device in found:
            name = self._described[device.name]
            known = self._scope.devices[name]
            now = next(iter(devices_of([device], self._scope.name).values()), None)
            if now is None or not (
                now.signals.keys() - known.signals.keys()
                or now.commands.keys() - known.commands.keys()
            ):
                continue
            # What was described goes on, also where the driver no longer has it.
            grown[name] = msgspec.structs.replace(
                known,
                kind=now.kind,
                signals={**known.signals, **now.signals},
                commands={**known.commands, **now.commands},
            )
        return grown
