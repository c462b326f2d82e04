"""One command: asked once, followed to its end, never sent again by itself."""

from __future__ import annotations

import asyncio
import secrets
from typing import TYPE_CHECKING

from talaia.client.addresses import find_command
from talaia.client.errors import ConfirmationNeeded, HubNotReached, NotPermitted
from talaia.client.values import CommandProgress, CommandResult
from talaia.wire.browser import CommandUpdate, PageCommand, RequestError
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.client.hub_api import HubApi
    from talaia.client.page_socket import PageSocket

__all__ = ["call_command"]

# The gateway ends a command after its own time-out, and says so; that takes a moment (s).
_SLACK_S = 10.0
_GOING_ON = frozenset({CommandPhase.ACCEPTED, CommandPhase.RUNNING})
_LOOK = "it may have been done and it may not, so look at the device before you ask again"


async def call_command(
    api: HubApi,
    address: str,
    arguments: Mapping[str, bool | float | str],
    *,
    confirm: bool,
    over: str,
    timeout_s: float | None,
    report: Callable[[CommandProgress], None] | None,
) -> CommandResult:
    """Ask for a command by its qualified address, and wait for what becomes of it.

    Raises:
        ConfirmationNeeded: people are asked whether they mean it, and ``confirm`` is not set.
        ClientError: it was not sent: the hub cannot be asked, or says no.

    """
    site, device_id, name = address.split("/")
    _, command = find_command(await api.describe_site(site), address)
    if command.confirm and not confirm:
        raise ConfirmationNeeded(address, command.name)
    number = f"script-{secrets.token_hex(16)}"
    asked = PageCommand(
        site=site, device=device_id, command=name, id=number, args=dict(arguments), over=over
    )
    limit_s = command.timeout + _SLACK_S if timeout_s is None else timeout_s
    async with api.open_socket("/ws") as socket:
        # From here on it may have been done, whatever happens: it is never sent a second time.
        try:
            await socket.send_message(asked)
            async with asyncio.timeout(limit_s):
                return await _follow_command(socket, address, asked, report=report)
        except TimeoutError:
            why = f"no end was heard of within {limit_s:g} s; {_LOOK}"
        except HubNotReached as error:
            why = f"{error}; {_LOOK}"
    return CommandResult(address, number, CommandPhase.UNKNOWN.value, why)


async def _follow_command(
    socket: PageSocket,
    address: str,
    asked: PageCommand,
    *,
    report: Callable[[CommandProgress], None] | None,
) -> CommandResult:
    while True:
        message = await socket.receive_message()
        match message:
            case RequestError(code="forbidden", about="command"):
                raise NotPermitted(
                    message.code,
                    message.message,
                    f"it takes the right use of {asked.site}/{asked.device}, of the token and of"
                    " its person",
                )
            # The hub refuses before any gateway is asked.
            case RequestError(about="command"):
                refused = CommandPhase.REFUSED.value
                return CommandResult(address, asked.id, refused, message.message)
            case CommandUpdate(id=asked.id) if message.phase in _GOING_ON:
                if report is not None:
                    phase = message.phase.value
                    report(CommandProgress(phase, message.progress, message.message))
            case CommandUpdate(id=asked.id):
                return CommandResult(
                    address, asked.id, message.phase.value, message.message, message.blocked_by
                )
            case _:
                pass
