"""Messages that one client publishes to the robot's own topics: each is a command, done once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.auth.rate_limiter import RateLimiter
from talaia.hub.auth.tokens import new_token
from talaia.wire.browser import PageCommand
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.clock import Clock
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.robot_names import RobotName
    from talaia.wire.browser import CommandUpdate

__all__ = ["PublishedCommands"]

# Each is written down and passes the interlocks: what comes steadily is no command.
_AT_ONCE, _EACH_SECOND = 20, 5.0
_MOST_WAITING = 100
_GOING_ON = frozenset({CommandPhase.ACCEPTED, CommandPhase.RUNNING})


class PublishedCommands:
    """Asks for them; call `read_update` with what the hub says of commands."""

    def __init__(self, connection: ClientConnection, clock: Clock) -> None:
        """Ask through ``connection``."""
        self._connection = connection
        self._clock = clock
        self._rate = RateLimiter(_AT_ONCE, _EACH_SECOND)
        # By the command's id: the topic.
        self._waiting: dict[str, str] = {}

    def ask_command(self, topic: RobotName, message: Mapping[str, object]) -> str:
        """Ask for the command that publishes this very message; say why not, if so."""
        # Of all topics together.
        if self._rate.request_turn("", self._clock.monotonic_ns()) > 0:
            return f"at most {_EACH_SECOND:g} messages a second: each is a command of its own"
        if len(self._waiting) >= _MOST_WAITING:
            return f"at most {_MOST_WAITING} commands at once"
        found = topic.find_command(message)
        if isinstance(found, str):
            return found
        number = new_token()
        # Before it is asked: its end may come at once.
        self._waiting[number] = topic.name
        problem = self._connection.request(
            PageCommand(
                site=self._connection.live.name,
                device=found.device,
                command=found.command,
                id=number,
                args=found.args,
            )
        )
        if problem is None:
            return ""
        del self._waiting[number]
        return problem.message

    def read_update(self, update: CommandUpdate) -> str:
        """Give what the client is to be told: that a message was not published, and why."""
        if update.phase in _GOING_ON:
            return ""
        topic = self._waiting.pop(update.id, None)
        if topic is None or update.phase is CommandPhase.SUCCEEDED:
            return ""
        return f"{topic}: {update.phase.value}: {update.message}"
