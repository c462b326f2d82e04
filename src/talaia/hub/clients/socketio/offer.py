"""What one account is offered of a site in the words of the founding vehicle. Pure."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.clients.account_offer import make_account_offer
from talaia.model.connections.ros import DIAGNOSTICS, RosSource
from talaia.model.site import SignalType

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
    account = make_account_offer(site, grants)
    # Two devices may have signals of one name: both then go by their address.
    times = Counter(_own_name(seen.name, seen.signal) for seen in account.signals)
    sensors = {}
    for seen in account.signals:
        own = _own_name(seen.name, seen.signal)
        name = own if times[own] == 1 else seen.address
        for part, address in seen.addresses().items():
            sensors[address] = OfferedSensor(
                f"{name}.{part}" if part else name, seen.signal.unit, _words_of(seen.signal)
            )
    return SocketioOffer(
        sensors=sensors,
        cameras=tuple(camera.address for camera in account.cameras),
        driven=tuple(drive.device for drive in account.drives if drive.usable),
        stopped=tuple(drive.device for drive in account.drives),
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


def _own_name(name: str, signal: Signal) -> str:
    source = signal.source
    # A level of ROS's diagnostics has a name, too, but that is no sensor's of CloudConnect.
    if isinstance(source, RosSource) and source.name and source.type != DIAGNOSTICS:
        return source.name
    return name


def _words_of(signal: Signal) -> tuple[str, ...]:
    return signal.states if signal.type is SignalType.STATE else ()
