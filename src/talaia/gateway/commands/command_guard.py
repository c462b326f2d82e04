"""Answers whether a command may be done now, and hears which begin and end."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.gateway.safety.dome_following import Hold
    from talaia.gateway.safety.interlocks import Interlocks
    from talaia.wire.frames import Scalar

__all__ = ["CommandGuard", "InterlockGuard"]


class CommandGuard:
    """Lets every command through, for a site where nothing locks."""

    def refusal_reason(self, device: str, command: str, args: dict[str, Scalar]) -> str:
        """Say why a command of a person may not be done now; empty when it may.

        ``args`` are its arguments by name.
        """
        return ""

    def power_cut_reason(self, device: str, command: str, args: dict[str, Scalar]) -> str:
        """Say why a command takes power that a safe state needs; empty when it takes none."""
        return ""

    def hold_for(self, device: str, command: str) -> Hold | None:
        """Say what a command has to wait for before the robot is asked; none when for nothing."""
        return None

    def command_began(self, device: str, command: str, who: str, args: dict[str, Scalar]) -> None:
        """Hear of each command of a person that begins; ``args`` by name."""

    def command_ended(self, device: str) -> None:
        """Hear of which device a command has ended."""


class InterlockGuard(CommandGuard):
    """Answers by the interlocks and enclosures of a site, as things stand at the moment."""

    def __init__(self, interlocks: Interlocks, clock: Clock) -> None:
        """Ask ``interlocks``, by the monotonic time of ``clock``."""
        self._interlocks = interlocks  # Of the whole site; asked anew for each command.
        self._clock = clock  # Monotonic.

    def refusal_reason(self, device: str, command: str, args: dict[str, Scalar]) -> str:
        """See `CommandGuard`."""
        return self._interlocks.refusal_reason(device, command, self._clock.monotonic_ns(), args)

    def power_cut_reason(self, device: str, command: str, args: dict[str, Scalar]) -> str:
        """See `CommandGuard`."""
        return self._interlocks.refuse_power_cut(device, command, self._clock.monotonic_ns(), args)

    def hold_for(self, device: str, command: str) -> Hold | None:
        """See `CommandGuard`."""
        return self._interlocks.enclosures.hold_for(device, command, self._clock.monotonic_ns())

    def command_began(self, device: str, command: str, who: str, args: dict[str, Scalar]) -> None:
        """See `CommandGuard`."""
        now_ns = self._clock.monotonic_ns()
        self._interlocks.begin_command(device, command, who, args=args, now_ns=now_ns)

    def command_ended(self, device: str) -> None:
        """See `CommandGuard`."""
        self._interlocks.enclosures.mark_ended(device, self._clock.monotonic_ns())

    def is_reached(self, command: str) -> bool | None:
        """Tell whether sensors show what a ``<device>/<command>`` is for; none where none could."""
        return self._interlocks.enclosures.is_reached(command, self._clock.monotonic_ns())
