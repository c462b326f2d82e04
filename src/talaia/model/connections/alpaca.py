"""An ASCOM Alpaca server: properties and methods of the devices that it has."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.model.base import Shape, SourceShape
from talaia.model.camera_addresses import NO_ADDRESS, why_no_camera
from talaia.model.checks.identifiers import Finding
from talaia.model.closed_lists import CommandKind, SignalType
from talaia.model.connections.kinds import ConnectionKind
from talaia.model.connections.rules import KindRules, argument_fields

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Command, Device, Signal

__all__ = ["AlpacaConnection", "AlpacaRules", "AlpacaSource", "alpaca_device_of"]

# What stands behind ``/api/v1/``: the device's type and number, then what is asked of it. The
# query is an argument that the property takes, as a switch's ``Id``.
_DEVICE = r"[a-z]{2,40}/[0-9]{1,9}"
_PROPERTY = re.compile(rf"{_DEVICE}/[a-z0-9]{{1,60}}(\?[A-Za-z]{{1,40}}=[A-Za-z0-9]{{1,40}})?\Z")
_METHOD = re.compile(rf"{_DEVICE}/[a-z0-9]{{1,60}}\Z")
_WHOLE_DEVICE = re.compile(rf"{_DEVICE}\Z")
# A parameter of a method; with another of the same device's before it, ``binx/BinX``, that is set
# first; ``fits/OBJECT`` goes into the picture's header.
_FIELD = re.compile(r"(?:[a-z0-9]{1,60}/)?[A-Za-z][A-Za-z0-9-]{0,40}\Z")
_POLL_S = (0.1, 3600)
_TIMEOUT_S = (0.1, 60)
_AGE = "timesincelastupdate"


class AlpacaConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="alpaca"):
    """An ASCOM Alpaca server.

    Attributes:
        host: where the server answers.
        port: its TCP port.
        poll: each device is asked so often (s).
        timeout: what has not answered a question whole by then counts as silent (s).
        discover: make devices of what the server has and the description does not name.
        connect: tell devices to connect to their hardware; one that somebody disconnects from
            here is left so until somebody connects it.
        devices: with ``discover``: only these, ``telescope/0``; empty takes all.
        here: the server may run on the gateway's own computer (``127.0.0.1``), which is refused
            otherwise.

    """

    host: str
    # Alpaca's usual one.
    port: int = 11_111
    poll: float = 1.0
    timeout: float = 3.0
    discover: bool = True
    connect: bool = True
    devices: tuple[str, ...] = ()
    here: bool = False


class AlpacaSource(SourceShape, frozen=True, kw_only=True, tag="alpaca"):
    """Where a signal comes from at an Alpaca server.

    Attributes:
        property: what is asked for, as in ASCOM's address behind ``/api/v1/``:
            ``telescope/0/rightascension``, ``switch/0/getswitchvalue?Id=2``.
        age: ``timesincelastupdate`` for a weather station's value, whose own age the server tells
            in seconds; interlocks count the value from when it was measured.

    """

    property: str = ""
    age: str = ""


class AlpacaRules(KindRules[AlpacaConnection, AlpacaSource]):
    """Checks what is described of an Alpaca server."""

    kind = ConnectionKind.ALPACA
    source = AlpacaSource
    example = "property: telescope/0/rightascension"
    commands = frozenset({CommandKind.ALPACA})

    def __init__(self, connection: AlpacaConnection) -> None:
        """Answer for this connection."""
        super().__init__(connection, AlpacaSource)

    def own_findings(self, where: str) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        connection = self.connection
        if not re.fullmatch(r"[A-Za-z0-9.:-]{1,253}", connection.host):
            yield Finding(f"{where}.host", "it is no host", "write: host: alpaca.local")
        else:
            # A name is looked up, and checked likewise, each time it is asked.
            why = why_no_camera(connection.host, here=connection.here)
            if why and why != NO_ADDRESS:
                remedy = "write here: true at the connection, if it is meant"
                yield Finding(f"{where}.host", f"no server is asked there, {why}", remedy)
        if not 1 <= connection.port <= 65_535:
            yield Finding(f"{where}.port", f"expected 1 to 65535, found {connection.port}")
        for key, (low, high) in (("poll", _POLL_S), ("timeout", _TIMEOUT_S)):
            found = getattr(connection, key)
            # Written so that NaN is found as well.
            if not low <= found <= high:
                yield Finding(f"{where}.{key}", f"expected {low:g} to {high:g} s, found {found:g}")
        for at, device in enumerate(connection.devices):
            if not _WHOLE_DEVICE.match(device):
                problem = f"{device[:80]!r} is no Alpaca device"
                yield Finding(f"{where}.devices[{at}]", problem, "write it as telescope/0")

    def signal_fits(self, where: str, signal: Signal, source: AlpacaSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        if signal.type is SignalType.POSITION:
            yield self.no_positions(where)
        if not _PROPERTY.match(source.property):
            problem = f"{source.property[:80]!r} is no property of an Alpaca device"
            yield Finding(f"{where}.property", problem, "write: telescope/0/rightascension")
        if source.age and (source.age != _AGE or not source.property.startswith("observing")):
            problem = "only an ObservingConditions device tells how old its values are"
            yield Finding(f"{where}.age", problem, f"write: age: {_AGE}, or leave it out")

    def frames_findings(self, where: str, device: Device) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield Finding(where, "pictures of an Alpaca camera come by themselves", "leave it out")

    def command_fits(self, where: str, command: Command) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        if not _METHOD.match(command.target):
            problem = f"{command.target[:80]!r} is no method of an Alpaca device"
            yield Finding(f"{where}.target", problem, "write: dome/0/openshutter")
        for at, field in argument_fields(where, command):
            if not _FIELD.match(field):
                problem = f"{field[:80]!r} is no parameter of Alpaca's"
                yield Finding(at, problem, "write it as RightAscension, or binx/BinX")


def alpaca_device_of(address: str) -> str:
    """Name the Alpaca device of a property or method: ``telescope/0`` of ``telescope/0/park``."""
    return "/".join(address.split("/")[:2])
