"""An INDI server: properties and elements of the devices that it names."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.model.base import Shape, SourceShape
from talaia.model.checks.identifiers import Finding
from talaia.model.checks.validity_checks import stamp_fits
from talaia.model.closed_lists import CommandKind, SignalType
from talaia.model.connections.kinds import ConnectionKind
from talaia.model.connections.rules import KindRules, argument_fields
from talaia.model.derivation.source import DerivedSource

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Command, Device, Signal

__all__ = ["IndiConnection", "IndiRules", "IndiSource", "indi_word_fits"]

# What libindi allows a name (MAXINDINAME), of which a driver keeps no more.
_MAX_WORD = 64
# The attribute that INDI gives each update of a property.
_STAMP = "timestamp"
# A name, an IPv4 or an IPv6 address, which may name its network card.
_HOST = re.compile(r"[A-Za-z0-9_.-]+\Z|[0-9A-Fa-f:]+(%[A-Za-z0-9_.-]+)?\Z")


class IndiConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="indi"):
    """An INDI server.

    Attributes:
        host: where the server answers.
        port: its TCP port.
        discover: make devices of what the server has and the description does not name.
        devices: with ``discover``: only INDI devices of these names; empty takes all.
        connect: tell drivers to connect to their hardware when they come, and again after a
            crash; one that somebody disconnects is left so until somebody connects it.

    """

    host: str = "127.0.0.1"
    # INDI's usual one.
    port: int = 7624
    discover: bool = True
    connect: bool = True
    devices: tuple[str, ...] = ()


class IndiSource(SourceShape, frozen=True, kw_only=True, tag="indi"):
    """Where a signal or a picture comes from at an INDI server.

    Attributes:
        property: the property (``EQUATORIAL_EOD_COORD``).
        element: the element of the property (``RA``); without it a state is that of the property
            itself (Idle, Ok, Busy, Alert), and of a switch the element that is on.
        device: another device than `Device.indi`.
        stamp: ``timestamp``, the property's attribute, which tells an old value that goes on
            arriving from a new one. Interlocks count a value from when it last advanced.
        synchronized: the clock behind ``stamp`` and the gateway's agree (NTP): a stamp that is
            further from the gateway's clock than ``max_age`` makes its value unknown.

    """

    property: str = ""
    element: str = ""
    device: str = ""
    stamp: str = ""
    synchronized: bool = False


class IndiRules(KindRules[IndiConnection, IndiSource]):
    """Checks what is described of an INDI server."""

    kind = ConnectionKind.INDI
    source = IndiSource
    example = "property: EQUATORIAL_EOD_COORD, element: RA"
    commands = frozenset({CommandKind.INDI})

    def __init__(self, connection: IndiConnection) -> None:
        """Answer for this connection."""
        super().__init__(connection, IndiSource)

    @property
    def names_devices(self) -> bool:
        """See `ConnectionRules`."""
        return True

    def own_findings(self, where: str) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        connection = self.connection
        if not connection.host or not connection.host.isprintable():
            yield Finding(f"{where}.host", "there is no host", "write: host: 127.0.0.1")
        # As it is copied from a browser.
        elif not _HOST.match(connection.host):
            problem = f"{connection.host[:80]!r} is not the name or the number of a computer"
            remedy = "leave out http://, the port and all behind it: host: 192.168.1.20"
            yield Finding(f"{where}.host", problem, remedy)
        if not 1 <= connection.port <= 65_535:
            yield Finding(f"{where}.port", f"expected 1 to 65535, found {connection.port}")

    def device_findings(self, where: str, device: Device) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield from super().device_findings(where, device)
        signals, streams = device.signals.values(), device.streams.values()
        sources = [*(thing.source for thing in signals), *(thing.source for thing in streams)]
        # What is worked out from other signals asks nobody.
        read = [source for source in sources if not isinstance(source, DerivedSource)]
        named = all(isinstance(source, IndiSource) and source.device for source in read)
        # A device without a name of its own can still be read where each source says whose it is.
        if not device.indi and (device.commands or not named):
            problem = "the name of the device at the INDI server is missing"
            yield Finding(f"{where}.indi", problem, "write: indi: Telescope Simulator")

    def signal_fits(self, where: str, signal: Signal, source: IndiSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield from stamp_fits(where, signal, source.stamp, synchronized=source.synchronized)
        judged = signal.type in (SignalType.NUMBER, SignalType.STATE)
        if source.stamp not in ("", _STAMP) and judged:
            problem = f"INDI has one stamp for each property, found {source.stamp!r}"
            yield Finding(f"{where}.stamp", problem, f"write: stamp: {_STAMP}")
        if signal.type is SignalType.POSITION:
            yield self.no_positions(where)
            return
        yield from self.stream_fits(where, source)
        if signal.type is SignalType.NUMBER and not source.element:
            yield Finding(f"{where}.element", "which element is meant?", "write: element: RA")

    def stream_fits(self, where: str, source: IndiSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield from indi_word_fits(f"{where}.property", source.property, "INDI property")

    def frames_findings(self, where: str, device: Device) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield Finding(where, "FITS files of an INDI camera come by themselves", "leave it out")

    def command_fits(self, where: str, command: Command) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield from indi_word_fits(f"{where}.target", command.target, "INDI property")
        for at, field in argument_fields(where, command):
            yield from indi_word_fits(at, field, "INDI element")


def indi_word_fits(where: str, word: str, what: str) -> Iterator[Finding]:
    """Judge a name at an INDI server."""
    if not word:
        yield Finding(where, f"the name of the {what} is missing")
    elif len(word) > _MAX_WORD or not word.isprintable():
        # Cut: what is wrong may be of any length.
        yield Finding(where, f"{word[:80]!r} is not the name of an {what}")
