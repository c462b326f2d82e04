"""Commands of one INDI server that have begun, and devices that are being connected anew. Pure.

Every ``done`` that is taken here is told exactly one final outcome: by what the driver says, by a
refusal, by time, or by `lose_all` when the server goes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.gateway.adapters.indi.goals import IndiGoal, begin_goal
from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.indi.state import IndiDeviceTree
    from talaia.wire.frames import Scalar

__all__ = ["CommandsUnderWay"]

# A driver that is there answers a connect within that; hardware that takes longer is told as
# absent, and connects all the same.
_RECONNECT_NS = 5 * SECOND


class _UnderWay(NamedTuple):
    """A command, and who waits for its end."""

    goal: IndiGoal
    done: Callable[[CommandOutcome], None]


class _Reconnecting(NamedTuple):
    """An INDI device that somebody connects anew, and until when that is waited for."""

    device: str
    due_ns: int
    done: Callable[[CommandOutcome], None]


class CommandsUnderWay:
    """All of one server. On the event loop."""

    def __init__(self, tree: IndiDeviceTree, send: Callable[[bytes], None]) -> None:
        """Take what is known of the devices, and where words to the server go."""
        self._tree, self._send = tree, send
        self._commands: list[_UnderWay] = []
        self._reconnecting: list[_Reconnecting] = []

    def begin_command(
        self,
        *,
        device: str,
        target: str,
        fields: dict[str, Scalar],
        now_ns: int,
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """Begin a command of an INDI device; see `goals.begin_goal`.

        Returns:
            What asks the driver to end it early; none if it was refused.

        """
        goal = begin_goal(
            book=self._tree, device=device, target=target, fields=fields, now_ns=now_ns
        )
        if isinstance(goal, str):
            done(CommandOutcome(CommandPhase.REFUSED, goal))
            return None
        try:
            data = goal.outgoing_bytes(self._tree)
        except ValueError as error:
            # A value that the property does not take.
            done(CommandOutcome(CommandPhase.REFUSED, str(error)))
            return None
        under_way = _UnderWay(goal, done)
        self._commands.append(under_way)
        self._send(data)
        return lambda: self._cancel_command(under_way)

    def follow_commands(self, now_ns: int, device: str = "") -> None:
        """Tell how commands stand, of one device or of all."""
        # A copy: whoever is told may begin another.
        for under_way in list(self._commands):
            if device and under_way.goal.device != device:
                continue
            outcome = under_way.goal.evaluate_progress(self._tree, now_ns)
            if outcome is None:
                continue
            under_way.done(outcome)
            if outcome.phase is not CommandPhase.RUNNING:
                self._commands.remove(under_way)

    def picture_ended(self, device: str, problem: str, now_ns: int) -> None:
        """Take in that a camera's picture is kept, or why it is not: an exposure ends with that."""
        for under_way in self._commands:
            if under_way.goal.device == device:
                under_way.goal.handle_picture(problem)
        self.follow_commands(now_ns, device)

    def await_connection(
        self, device: str, now_ns: int, done: Callable[[CommandOutcome], None]
    ) -> None:
        """Tell ``done`` when an INDI device is connected, or that it is not in time."""
        self._reconnecting.append(_Reconnecting(device, now_ns + _RECONNECT_NS, done))

    def answer_reconnections(self, now_ns: int) -> None:
        """Tell those who wait for a device, if it is there or their time is up."""
        for waiter in list(self._reconnecting):
            name = waiter.device
            device = self._tree.devices.get(name)
            if device is not None and device.connected:
                outcome = CommandOutcome(
                    CommandPhase.SUCCEEDED, f"the driver of {name} is connected"
                )
            elif now_ns >= waiter.due_ns:
                problem = "is not there" if device is None else "is not connected"
                outcome = CommandOutcome(CommandPhase.FAILED, f"the driver of {name} {problem}")
            else:
                continue
            waiter.done(outcome)
            self._reconnecting.remove(waiter)

    def lose_all(self) -> None:
        """The server is gone, and nobody will answer."""
        for under_way in self._commands:
            # Not failed: a dome that was told to close goes on closing without the server.
            gone = "the INDI server went away meanwhile; look at the device"
            under_way.done(CommandOutcome(CommandPhase.UNKNOWN, gone))
        self._commands.clear()
        for waiter in self._reconnecting:
            gone = "the INDI server went away meanwhile"
            waiter.done(CommandOutcome(CommandPhase.FAILED, gone))
        self._reconnecting.clear()

    def _cancel_command(self, under_way: _UnderWay) -> None:
        # Its end may have come first.
        if under_way in self._commands:
            self._send(under_way.goal.cancel_bytes(self._tree))
