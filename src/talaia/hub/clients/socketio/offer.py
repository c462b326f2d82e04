"""What one account is offered of a site in the words of the founding vehicle. Pure.

What an account may not see is not in it, so nothing that is listed has to be hidden later.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.auth.permissions import Right, sees_signal, sees_stream
from talaia.model.connections.ros import DIAGNOSTICS, RosSource
from talaia.model.site import SignalType, parts_of

if TYPE_CHECKING:
    from talaia.hub.auth.permissions import Grants
    from talaia.hub.clients.signal_subscriptions import ClientSample
    from talaia.model.site import Signal, Site

__all__ = ["OfferedSensor", "SocketioOffer", "make_socketio_offer", "sensor_magnitude"]


class OfferedSensor(NamedTuple):
    """A sensor, which is one channel.

    Attributes:
        name: its own at the robot where it has one there (``speed1``), else the signal's.
        unit: empty: none.
        states: of a state: its words.

    """

    name: str
    unit: str
    states: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SocketioOffer:
    """All of it.

    Attributes:
        sensors: by the address of their channel.
        cameras: as ``<device>/<stream>``.
        driven: devices that the account may use and that are driven.
        stopped: driven devices that the account may view, and so may stop.

    """

    sensors: dict[str, OfferedSensor] = field(default_factory=dict)
    cameras: tuple[str, ...] = ()
    driven: tuple[str, ...] = ()
    stopped: tuple[str, ...] = ()

    def describe_site(self, site: Site) -> dict[str, object]:
        """Give the configuration as a client is told it."""
        sensors = self.sensors.values()
        return {
            "site": site.site,
            "name": site.name,
            "sensors": [sensor.name for sensor in sensors],
            "units": {sensor.name: sensor.unit for sensor in sensors if sensor.unit},
            "cameras": list(self.cameras),
            "vehicles": list(self.driven),
        }


def make_socketio_offer(site: Site, grants: Grants) -> SocketioOffer:
    """Offer an account what it may see and drive at a site now."""
    seen = [
        (f"{device}/{name}", signal)
        for device, described in site.devices.items()
        for name, signal in described.signals.items()
        if sees_signal(grants, site, device, name)
    ]
    # Two devices may have signals of one name: both then go by their address.
    times = Counter(_own_name(address, signal) for address, signal in seen)
    sensors = {}
    for address, signal in seen:
        own = _own_name(address, signal)
        name = own if times[own] == 1 else address
        for part in parts_of(signal):
            suffix = f".{part}" if part else ""
            sensors[address + suffix] = OfferedSensor(name + suffix, signal.unit, _words_of(signal))
    driven = [name for name, device in site.devices.items() if device.drive is not None]
    return SocketioOffer(
        sensors=sensors,
        cameras=tuple(
            f"{device}/{stream}"
            for device, described in site.devices.items()
            for stream in described.streams
            if sees_stream(grants, site, device, stream)
        ),
        driven=tuple(name for name in driven if grants.has_right(Right.USE, site.site, name)),
        stopped=tuple(name for name in driven if grants.has_right(Right.VIEW, site.site, name)),
    )


def sensor_magnitude(sensor: OfferedSensor, sample: ClientSample) -> float | str | None:
    """Give what a sensor says: a number, a text or the word of a state; None: no number."""
    if sample.text is not None:
        return sample.text
    if not math.isfinite(sample.value):
        return None
    if sensor.states:
        at = int(sample.value)
        return sensor.states[at] if 0 <= at < len(sensor.states) else str(at)
    return sample.value


def _own_name(address: str, signal: Signal) -> str:
    source = signal.source
    # A level of ROS's diagnostics has a name, too, but that is no sensor's of CloudConnect.
    if isinstance(source, RosSource) and source.name and source.type != DIAGNOSTICS:
        return source.name
    return address.partition("/")[2]


def _words_of(signal: Signal) -> tuple[str, ...]:
    return signal.states if signal.type is SignalType.STATE else ()
