"""The promises between a gateway and an adapter that an extension brings.

The adapter runs in a process of its own with an event loop of its own: it may block or end without
harm to the gateway. What it publishes is judged, thinned and kept by the gateway like the values
of any other adapter.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

from talaia.errors import TalaiaError

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.extensions.declarations import ExtensionKeys

__all__ = [
    "AdapterHost",
    "CommandRefused",
    "ConnectionLost",
    "ExecutionFailed",
    "ExtensionAdapter",
    "ExtensionCommand",
    "WantedSignal",
]


class ConnectionLost(TalaiaError):
    """The robot's side cannot be reached; the gateway runs the adapter again a second later."""


class CommandRefused(TalaiaError):
    """A command was not begun; nothing has happened."""


class ExecutionFailed(TalaiaError):
    """A command was begun and has failed, in the robot's own words where it gave any."""


class WantedSignal(NamedTuple):
    """A signal that the description takes from the adapter.

    Attributes:
        address: ``device/signal``.
        device: the device's name.
        type: ``number``, ``state`` or ``text``.
        unit: of a number, after the description's ``scale``.
        states: of a state: its words, by number.
        keys: the signal's ``source.keys``, as `AdapterExtension.source`.

    """

    address: str
    device: str
    type: str
    unit: str
    states: tuple[str, ...]
    keys: ExtensionKeys


class ExtensionCommand(NamedTuple):
    """A command to be done now.

    Attributes:
        device: the device's name.
        command: the command's name.
        keys: its target, fixed values and arguments, as `AdapterExtension.command`.

    """

    device: str
    command: str
    keys: ExtensionKeys


class AdapterHost(Protocol):
    """What an adapter is given. Used on the adapter's event loop only; nothing here blocks.

    Attributes:
        signals: what the description asks for.
        devices: names of the devices of this connection.
        folder: where the description stands: relative paths in it begin there.

    """

    signals: tuple[WantedSignal, ...]
    devices: tuple[str, ...]
    folder: Path

    def connected(self) -> None:
        """Say in each run, once it is so, that the robot's side is reached."""
        ...

    def publish(self, address: str, value: float | str, time_us: int | None = None) -> None:
        """Give a value of a signal.

        Args:
            address: of one of ``signals``.
            value: a number before the description's ``scale``; a state's number or word; a text.
                A word that is none of the states is not published, and said once in the log.
            time_us: when it was true (µs since the epoch, UTC); now where it is left out.

        """
        ...

    def device_reachable(self, device: str, *, reachable: bool, why: str = "") -> None:
        """Say that one device does not answer, or does again; its values are unknown meanwhile."""
        ...

    def report(self, kind: str, message: str) -> None:
        """Write something down in the site's log: ``kind`` in a word or two, and a sentence."""
        ...


class ExtensionAdapter(Protocol):
    """What an adapter extension makes: speaks one protocol with one robot."""

    async def run(self) -> None:
        """Read the robot until cancelled.

        Raises:
            ConnectionLost: the robot's side cannot be reached; another error means the same, and
                names the extension as broken.

        """
        ...

    async def execute(self, request: ExtensionCommand) -> str:
        """Do a command; give what the robot said, or nothing.

        Runs beside `run`, and beside other commands. When it is cancelled, or raises anything
        else than what stands below, nobody knows what was done.

        Raises:
            CommandRefused: it was not begun.
            ExecutionFailed: it was, and failed.

        """
        ...
