"""One command of an Alpaca client: asked of the hub as a page would, and waited for until it runs.

Alpaca's methods return when the device has begun. So a client is told of a refusal at once, with
the reason, and of a success as soon as the gateway says that it runs.
"""

from __future__ import annotations

import asyncio
import contextlib
from typing import TYPE_CHECKING

from talaia.hub.auth.tokens import new_token
from talaia.hub.clients.alpaca.device_answers import INVALID_OPERATION, DeviceError
from talaia.wire.browser import CommandUpdate, PageCommand
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from talaia.hub.clients.alpaca.device_answers import DomeCommand
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.wire.browser import ToBrowser

__all__ = ["DRIVER_ERROR", "call_command"]

# The first of those that ASCOM leaves to drivers.
DRIVER_ERROR = 0x500
# For the gateway to say anything (s), and after it has taken the command to refuse it yet.
_ANSWER_S, _BEGIN_S = 8.0, 1.0


class _CommandSession:
    """A `ClientSession` that lives for one command."""

    def __init__(self, command_id: str) -> None:
        self._id = command_id
        self.taken = asyncio.Event()
        self.begun = asyncio.Event()  # It runs, or has ended.
        self.newest: CommandUpdate | None = None

    async def read_client(self) -> None:
        """Wait: its client says nothing more."""
        await asyncio.Event().wait()

    async def deliver_message(self, message: ToBrowser) -> None:
        """Keep how the command stands."""
        if isinstance(message, CommandUpdate) and message.id == self._id:
            self.newest = message
            self.taken.set()
            if message.phase is not CommandPhase.ACCEPTED:
                self.begun.set()

    async def warn_person(self, text: str) -> None:
        """Nothing is driven here."""

    async def close_client(self, code: int) -> None:
        """The connection ends with its request."""


async def call_command(connection: ClientConnection, asked: DomeCommand) -> None:
    """Call a command; returns when it runs, or has succeeded.

    Raises:
        DeviceError: it is refused, or has failed.

    """
    command_id = f"alpaca-{new_token()}"
    session = _CommandSession(command_id)
    serving = asyncio.create_task(connection.serve_client(session))
    try:
        problem = connection.request(
            PageCommand(
                site=connection.live.name,
                device=asked.device,
                command=asked.command,
                id=command_id,
                args=asked.args,
            )
        )
        if problem is not None:
            raise DeviceError(INVALID_OPERATION, problem.message)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_ANSWER_S):
                await session.taken.wait()
            async with asyncio.timeout(_BEGIN_S):
                await session.begun.wait()
        _check_outcome(session.newest)
    finally:
        connection.end("the command was asked for")
        await asyncio.wait([serving])


def _check_outcome(newest: CommandUpdate | None) -> None:
    if newest is None:
        raise DeviceError(DRIVER_ERROR, "the gateway has not answered; it is not asked again")
    match newest.phase:
        case CommandPhase.ACCEPTED | CommandPhase.RUNNING | CommandPhase.SUCCEEDED:
            return
        case CommandPhase.REFUSED:
            raise DeviceError(INVALID_OPERATION, newest.message or "it is refused")
        case _:
            raise DeviceError(DRIVER_ERROR, newest.message or f"it has {newest.phase.value}")
