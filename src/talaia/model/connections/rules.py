"""What every kind of connection is asked when a description is checked; each answers for itself.

A kind says which source it reads, which commands it carries, and what is wrong with either. What
it does not have (pictures, positions, FITS files, driving) is refused here, once for all kinds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Generic, TypeVar

from talaia.model.base import SourceShape
from talaia.model.checks.identifiers import Finding
from talaia.model.closed_lists import CommandKind
from talaia.model.derivation.source import DerivedSource
from talaia.model.detection import DetectionSource

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.connections.kinds import ConnectionKind
    from talaia.model.site import Command, Device, Signal, Stream

__all__ = [
    "ConnectionRules",
    "ConnectionT",
    "KindRules",
    "SourceT",
    "argument_fields",
    "keys_given",
    "own_keys",
]

# Only these carry a message that has a type.
_TYPED = frozenset({CommandKind.SERVICE, CommandKind.TOPIC, CommandKind.ACTION})


SourceT = TypeVar("SourceT", bound=SourceShape)
# Both of the two: a connection has one shape, its kind one source.
ConnectionT = TypeVar("ConnectionT")


class ConnectionRules:
    """What one connection asks of the devices that it reaches; see `KindRules`.

    Attributes:
        kind: the word for it in a description.
        source: the shape of its signals' and cameras' sources.
        example: such a source, for remedies.
        commands: what commands it carries.
        drives: whether a device can be driven by it.

    """

    kind: ClassVar[ConnectionKind]
    source: ClassVar[type[SourceShape]]
    example: ClassVar[str]
    commands: ClassVar[frozenset[CommandKind]] = frozenset()
    drives: ClassVar[bool] = False

    def own_findings(self, where: str) -> Iterator[Finding]:
        """List what is wrong with the connection itself."""
        yield from ()

    def device_findings(self, where: str, device: Device) -> Iterator[Finding]:
        """List what is wrong with how a device is reached."""
        if device.drive is not None and not self.drives:
            problem = f"a connection of kind {self.kind} cannot drive"
            yield Finding(f"{where}.drive", problem, "reach the device by ROS")
        if device.indi and not self.names_devices:
            problem = f"its connection is of kind {self.kind}"
            yield Finding(f"{where}.indi", problem, "leave it out")

    def signal_findings(self, where: str, signal: Signal) -> Iterator[Finding]:
        """List what is wrong with where a signal comes from; ``where`` is its source."""
        yield from self.foreign_findings(where, signal.source)

    def stream_findings(self, where: str, stream: Stream) -> Iterator[Finding]:
        """List what is wrong with where pictures come from."""
        yield from self.foreign_findings(where, stream.source)

    def frames_findings(self, where: str, device: Device) -> Iterator[Finding]:
        """List what is wrong with where a camera's FITS files come from."""
        problem = f"a connection of kind {self.kind} gives no FITS files"
        yield Finding(where, problem, "reach the camera by ros2, ros1 or indi")

    def command_findings(self, where: str, command: Command) -> Iterator[Finding]:
        """List what is wrong with what a command reaches, and with what its arguments fill."""
        if command.kind not in self.commands:
            fitting = ", ".join(
                command_kind for command_kind in CommandKind if command_kind in self.commands
            )
            problem = f"{command.kind} is not for a connection of kind {self.kind}"
            yield Finding(f"{where}.kind", problem, f"write one of: {fitting}")
            return
        # Of the right kind: its target and fields are the protocol's to judge.
        yield from self.command_fits(where, command)
        if command.type and command.kind not in _TYPED:
            yield Finding(f"{where}.type", f"{command.kind} has no type", "leave it out")

    @property
    def names_devices(self) -> bool:
        """Whether its server calls devices by a name of its own (`Device.indi`)."""
        return False

    def no_positions(self, where: str) -> Finding:
        """Refuse a position, for a kind whose sources give one number each."""
        problem = f"a connection of kind {self.kind} gives no positions"
        return Finding(where, problem, "make a signal of each number")

    def command_fits(self, where: str, command: Command) -> Iterator[Finding]:
        """Judge a command of a kind that it carries; see `command_findings`."""
        yield from ()

    def foreign_findings(self, where: str, source: SourceShape) -> Iterator[Finding]:
        """Say of each key of another protocol's source that this one does not know it."""
        # In a source of this kind only foreign keys are wrong; in another kind's all that it says.
        for key in source.foreign if isinstance(source, self.source) else keys_given(source):
            problem, remedy = self.why_not(key)
            yield Finding(f"{where}.{key}", problem, remedy)
        # Another kind's that says nothing would be read back as an empty one of this kind.
        if not isinstance(source, self.source) and not keys_given(source):
            yield Finding(where, "it names nothing", f"write as: {self.example}")

    @classmethod
    def why_not(cls, key: str) -> tuple[str, str]:
        """Say that a key is another protocol's, and how a source is written here."""
        if key in own_keys(DetectionSource):
            problem = "it belongs to a signal that counts what a camera sees"
            return problem, "write both stream and sees, or leave it out"
        if key in own_keys(DerivedSource):
            return "only a signal is worked out from others", "leave it out"
        remedy = f"write as: {cls.example}"
        if key == "url" and cls.kind.startswith("ros"):
            # A camera of the network beside a robot.
            remedy = "for a camera's address name a connection of kind video or onvif"
        return f"a connection of kind {cls.kind} knows no {key}", remedy


class KindRules(ConnectionRules, Generic[ConnectionT, SourceT]):
    """The base of each kind's own class, with the shapes of its connection and its source."""

    def __init__(self, connection: ConnectionT, shape: type[SourceT]) -> None:
        """Answer for this connection, whose sources have that shape."""
        self.connection = connection
        # A source of another shape is judged by `foreign_findings` alone.
        self._shape = shape

    def signal_findings(self, where: str, signal: Signal) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield from super().signal_findings(where, signal)
        if isinstance(signal.source, self._shape):
            yield from self.signal_fits(where, signal, signal.source)
        elif not keys_given(signal.source):
            # Another protocol's that says nothing is written as ours that says nothing.
            yield from self.signal_fits(where, signal, self._shape())

    def stream_findings(self, where: str, stream: Stream) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield from super().stream_findings(where, stream)
        if isinstance(stream.source, self._shape):
            yield from self.stream_fits(where, stream.source)

    def signal_fits(self, where: str, signal: Signal, source: SourceT) -> Iterator[Finding]:
        """Judge a source of this kind; see `signal_findings`."""
        yield from ()

    def stream_fits(self, where: str, source: SourceT) -> Iterator[Finding]:
        """Judge a source of this kind; see `stream_findings`."""
        problem = f"a connection of kind {self.kind} gives no pictures"
        yield Finding(where, problem, "reach the camera otherwise")


def keys_given(source: SourceShape) -> tuple[str, ...]:
    """Name the keys of a source that say something."""
    # Empty and false is as good as not written.
    own = [key for key in own_keys(type(source)) if getattr(source, key)]
    return (*own, *source.foreign)


def own_keys(shape: type[SourceShape]) -> tuple[str, ...]:
    """Name the keys that a kind of source has."""
    return tuple(key for key in shape.__struct_fields__ if key != "foreign")


def argument_fields(where: str, command: Command) -> list[tuple[str, str]]:
    """List what a command fills, fixed or asked for, each with its place in the description."""
    fields = [(f"{where}.fixed.{field}", field) for field in command.fixed]
    for name, argument in command.arguments.items():
        fields.append((f"{where}.arguments.{name}.field", argument.field))
    return fields
