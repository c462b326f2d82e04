"""What a server has said of its devices, and when by the gateway's monotonic clock. Pure.

Two ages are kept apart. *Arrived*: when a vector was last **set** by its driver, which is when a
measured value was measured. *Heard*: when the driver last said anything at all. A shutter that
does not move is not set for hours and is known all the same, for as long as its driver answers.
An answer to our own question repeats a value and makes no measurement newer.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.adapters.indi.errors import IndiError
from talaia.gateway.adapters.indi.protocol import (
    Deleted,
    DriverMessage,
    Element,
    PropertyPermission,
    PropertyState,
    SwitchRule,
    Vector,
    VectorKind,
)
from talaia.gateway.samples.source_stamps import StampAge, iso_stamp_ns

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.gateway.adapters.indi.protocol import Value

__all__ = ["IndiDevice", "IndiDeviceTree", "StoredVector"]

# A server that makes up names without end must not fill the memory of a gateway that guards a
# roof.
MAX_DEVICES = 500
MAX_VECTORS = 2_000
MAX_SAID = 50


@dataclass(slots=True)
class StoredVector:
    """A vector as it stands.

    Attributes:
        arrived_ns: when it was last set, or else defined.
        sets: how many times it was set; tells a later Set event from an earlier one.
        timestamp: its driver's own time of the newest set, as that wrote it.
        stamps: how these went on.
        advanced_ns: when one advanced last; none when none ever did.

    """

    kind: VectorKind
    device: str
    name: str
    elements: dict[str, Element]
    state: PropertyState
    label: str
    group: str
    perm: PropertyPermission
    rule: SwitchRule
    timeout: float
    arrived_ns: int
    sets: int = 0
    timestamp: str = ""
    stamps: StampAge = field(default_factory=StampAge)
    advanced_ns: int | None = None

    def element_value(self, element: str) -> Value | None:
        """Give an element's value, or none where there is no such element."""
        found = self.elements.get(element)
        return None if found is None else found.value


class LoggedDriverMessage(NamedTuple):
    """A sentence of a driver, and when it came."""

    mono_ns: int
    message: str


@dataclass(slots=True)
class IndiDevice:
    """One device as a server tells it.

    Attributes:
        heard_ns: when anything came from it.
        said: its newest sentences, the last one last.

    """

    name: str
    heard_ns: int
    vectors: dict[str, StoredVector] = field(default_factory=dict)
    said: list[LoggedDriverMessage] = field(default_factory=list)

    @property
    def connected(self) -> bool:
        """Whether the driver says that it is connected to its hardware."""
        return self.element_value("CONNECTION", "CONNECT") is True

    @property
    def interface(self) -> int:
        """What kinds of device it is, as the bits of ``DRIVER_INFO``."""
        text = self.element_value("DRIVER_INFO", "DRIVER_INTERFACE")
        digits = str(text).strip()[:12]
        return int(digits) if digits.isascii() and digits.isdigit() else 0

    def element_value(self, name: str, element: str) -> Value | None:
        """Give the value of an element, or none where there is no such."""
        held = self.vectors.get(name)
        return None if held is None else held.element_value(element)


class IndiDeviceTree:
    """All devices of one server."""

    def __init__(self) -> None:
        """Start knowing nothing."""
        self.devices: dict[str, IndiDevice] = {}

    def __iter__(self) -> Iterator[IndiDevice]:
        """Go through the devices in the order in which they came."""
        return iter(self.devices.values())

    def find_vector(self, device: str, name: str) -> StoredVector | None:
        """Find a vector."""
        found = self.devices.get(device)
        return None if found is None else found.vectors.get(name)

    def apply_event(
        self, event: Vector | Deleted | DriverMessage, now_ns: int
    ) -> StoredVector | None:
        """Take an event, and give the vector that it touched, if one.

        Raises:
            IndiError: the server names more than is taken from one.

        """
        match event:
            case Vector():
                return self._apply_vector(event, now_ns)
            case Deleted():
                self._delete_vector(event, now_ns)
            case DriverMessage():
                found = self.devices.get(event.device)
                if found is not None:
                    found.heard_ns = now_ns
                    _log_message(found, event.message, now_ns)
        return None

    def forget_all(self) -> None:
        """Forget all: the server is gone, and what it said may be wrong by now."""
        self.devices.clear()

    def _apply_vector(self, event: Vector, now_ns: int) -> StoredVector | None:
        device = self.devices.get(event.device)
        if device is None:
            # Values of what was never defined: a definition is on its way, or the server is
            # confused.
            if not event.new:
                return None
            if len(self.devices) >= MAX_DEVICES:
                raise IndiError(f"the INDI server names more than {MAX_DEVICES} devices")
            device = self.devices[event.device] = IndiDevice(event.device, now_ns)
        device.heard_ns = now_ns
        if event.message:
            _log_message(device, event.message, now_ns)
        held = device.vectors.get(event.name)
        if event.new:
            return self._define_vector(device, held, event, now_ns)
        # A set of another kind than was defined, or of what never was, means nothing.
        if held is None or held.kind is not event.kind:
            return None
        for element in event.elements:
            known = held.elements.get(element.name)
            if known is not None:
                held.elements[element.name] = _update_element(known, element)
        # A set may leave these out, which means that they are as before.
        if event.state is not None:
            held.state = event.state
        if event.timeout > 0:
            held.timeout = event.timeout
        # Only a set makes a value newer; see the module about the two ages.
        held.arrived_ns = now_ns
        held.sets += 1
        held.timestamp = event.timestamp
        held.advanced_ns = held.stamps.add_stamp(iso_stamp_ns(event.timestamp), now_ns)
        return held

    def _define_vector(
        self, device: IndiDevice, held: StoredVector | None, event: Vector, now_ns: int
    ) -> StoredVector:
        elements = {element.name: element for element in event.elements}
        if held is not None and held.kind is event.kind:
            # Defined once more: the answer to our question, or to another client's.
            held.elements = elements
            held.state = event.state or held.state
            held.perm, held.rule = event.perm, event.rule
            return held
        if held is None and len(device.vectors) >= MAX_VECTORS:
            raise IndiError(
                f"the INDI device {device.name[:40]!r} has more than {MAX_VECTORS} properties"
            )
        # New, or defined as another kind than before: nothing of the old one holds.
        held = StoredVector(
            event.kind,
            event.device,
            event.name,
            elements,
            event.state or PropertyState.IDLE,
            event.label,
            event.group,
            event.perm,
            event.rule,
            event.timeout,
            now_ns,
        )
        device.vectors[event.name] = held
        return held

    def _delete_vector(self, event: Deleted, now_ns: int) -> None:
        if not event.device:
            self.devices.clear()
        elif not event.name:
            self.devices.pop(event.device, None)
        elif (device := self.devices.get(event.device)) is not None:
            device.heard_ns = now_ns
            if event.message:
                _log_message(device, event.message, now_ns)
            device.vectors.pop(event.name, None)
            # A driver that ends deletes its properties one by one; after the last there is no
            # device.
            if not device.vectors:
                del self.devices[event.device]


def _update_element(known: Element, element: Element) -> Element:
    """Take the new value; limits only where the set carries them."""
    # Both zero is the protocol's "no limit" and also what a set without limits looks like.
    if element.minimum or element.maximum:
        return known._replace(value=element.value, minimum=element.minimum, maximum=element.maximum)
    return known._replace(value=element.value)


def _log_message(device: IndiDevice, message: str, now_ns: int) -> None:
    device.said.append(LoggedDriverMessage(now_ns, message))
    del device.said[:-MAX_SAID]
