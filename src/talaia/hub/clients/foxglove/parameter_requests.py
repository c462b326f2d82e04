"""Parameters of one Foxglove client: read, told when they change, and set by commands."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol, cast

from talaia.hub.auth.tokens import new_token
from talaia.hub.clients.foxglove.offer import FoxgloveOffer
from talaia.hub.clients.robot_parameters import read_parameters
from talaia.wire.browser import PageCommand
from talaia.wire.foxglove.server_messages import FoxgloveParameter, ParameterValues
from talaia.wire.frames import CommandPhase
from talaia.wire.nested_json import decode_nested

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.robot_parameters import ParameterValue
    from talaia.wire.browser import CommandUpdate
    from talaia.wire.foxglove import client_messages as said
    from talaia.wire.foxglove.server_messages import ServerMessage

__all__ = ["ParameterRequests"]

# Of a status.
_WARNING = 1
# The robot is asked for its parameters about as often (s).
_TOLD_EVERY_S = 1.0
_MOST_SET = 100
_GOING_ON = frozenset({CommandPhase.ACCEPTED, CommandPhase.RUNNING})
# As Foxglove's servers for ROS 2 name a node's parameter.
_BETWEEN = "."


class TellsClient(Protocol):
    """Writes to the client."""

    async def __call__(self, message: ServerMessage, /) -> None:
        """Send a message of the protocol."""
        ...


class WarnsClient(Protocol):
    """Tells the client's person something."""

    async def __call__(self, level: int, text: str, /) -> None:
        """Send a status of the protocol."""
        ...


@dataclass(slots=True)
class _Wish:
    """One request to set parameters: what is answered when all commands of it have ended."""

    number: str | None
    names: list[str]
    # By the parameter's name: what a command has set it to, which no signal tells yet.
    done: dict[str, ParameterValue] = field(default_factory=dict)
    # By the command's id: the parameter's name and what it is to be.
    waiting: dict[str, tuple[str, ParameterValue]] = field(default_factory=dict)


class ParameterRequests:
    """Call `follow_command` with what the hub says of commands; run `serve_updates` meanwhile."""

    def __init__(
        self, connection: ClientConnection, *, send: TellsClient, warn: WarnsClient, clock: Clock
    ) -> None:
        """Ask through ``connection``; what is wrong is told by ``warn``."""
        self._connection = connection
        self._send = send
        self._warn = warn
        self._clock = clock
        self._offer = FoxgloveOffer()
        # By the command's id.
        self._wishes: dict[str, _Wish] = {}
        # Parameters of which news are wanted, as the client names them; and what was told last.
        self._wanted: set[str] = set()
        self._wants_all = False
        self._told: dict[str, ParameterValue] = {}
        self._wanting = asyncio.Event()

    def update_offer(self, offer: FoxgloveOffer) -> None:
        """Go by another offer."""
        self._offer = offer

    async def send_values(self, names: list[str], number: str | None = None) -> None:
        """Send the parameters of these names, or all; what is not known now is left out."""
        await self._send_known(names, number, {})

    async def subscribe(self, names: list[str]) -> None:
        """Tell when these change, or all without a name; what they are now is told at once."""
        if names:
            self._wanted.update(names)
        else:
            self._wants_all = True
        values = self._read_values(names)
        self._told.update(values)
        self._wanting.set()
        await self._send(_message(values))

    def unsubscribe(self, names: list[str]) -> None:
        """Tell no more of these, or of none without a name."""
        self._wanted.difference_update(names or list(self._wanted))
        self._wants_all = self._wants_all and bool(names)
        if not self._wanted and not self._wants_all:
            self._wanting.clear()
            self._told.clear()

    async def serve_updates(self) -> None:
        """Tell of changes, until cancelled; without subscriptions nothing is looked at."""
        while True:
            await self._wanting.wait()
            await asyncio.sleep(_TOLD_EVERY_S)
            values = self._read_values([] if self._wants_all else sorted(self._wanted))
            news = {
                name: value
                for name, value in values.items()
                # True is 1 for Python.
                if name not in self._told or repr(self._told[name]) != repr(value)
            }
            if news and self._wanting.is_set():
                self._told.update(news)
                await self._send(_message(news))

    async def set_values(self, message: said.FoxgloveSetParameters) -> None:
        """Ask for the commands that set parameters; the answer comes when they have ended."""
        wish = _Wish(message.id, [one.name for one in message.parameters])
        for one in message.parameters:
            why = self._ask_setting(wish, one)
            if why:
                await self._warn(_WARNING, f"{one.name[:200]}: {why}")
        if not wish.waiting:
            await self._end_wish(wish)

    async def follow_command(self, update: CommandUpdate) -> bool:
        """Take news of a command; tell whether it sets a parameter of this client."""
        wish = self._wishes.get(update.id)
        if wish is None:
            return False
        if update.phase in _GOING_ON:
            return True
        del self._wishes[update.id]
        name, value = wish.waiting.pop(update.id)
        if update.phase is CommandPhase.SUCCEEDED:
            wish.done[name] = value
        else:
            await self._warn(_WARNING, f"{name}: {update.phase.value}: {update.message}")
        if not wish.waiting:
            await self._end_wish(wish)
        return True

    def _ask_setting(self, wish: _Wish, one: said.FoxgloveParameterWish) -> str:
        parameter = self._offer.robot_parameters.find(one.name)
        if one.name in self._offer.parameters:
            return "it is of the description and cannot be set"
        if parameter is None:
            return "there is no such parameter"
        if len(self._wishes) >= _MOST_SET:
            return f"at most {_MOST_SET} are set at once"
        try:
            value = decode_nested(bytes(one.value))
        except ValueError as error:
            return f"not a value: {str(error)[:200]}"
        found = parameter.find_command(value)
        if isinstance(found, str):
            return found
        number = new_token()
        # Before it is asked: its end may come at once.
        self._wishes[number] = wish
        # A command has been found for it, so it is of a parameter's kinds.
        wish.waiting[number] = one.name, cast("ParameterValue", value)
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
        del self._wishes[number], wish.waiting[number]
        return problem.message

    async def _end_wish(self, wish: _Wish) -> None:
        self._told.update({name: value for name, value in wish.done.items() if name in self._told})
        # Who gave no number wants no answer.
        if wish.number is not None:
            await self._send_known(wish.names, wish.number, wish.done)

    async def _send_known(
        self, names: list[str], number: str | None, done: dict[str, ParameterValue]
    ) -> None:
        await self._send(_message(self._read_values(names) | done, number))

    def _read_values(self, names: list[str]) -> dict[str, ParameterValue]:
        """Give what is known of the parameters of these names, as the client names them; or all."""
        facts, robots = self._offer.parameters, self._offer.robot_parameters
        if not names:
            wanted = {n: one for n, one in robots.listed(_BETWEEN).items() if n not in facts}
            known: dict[str, ParameterValue] = {**facts}
        else:
            found = {name: robots.find(name) for name in names if name not in facts}
            wanted = {name: one for name, one in found.items() if one is not None}
            known = {name: facts[name] for name in names if name in facts}
        live = self._connection.live
        return known | read_parameters(live, wanted, self._clock.monotonic_ns())


def _message(values: dict[str, ParameterValue], number: str | None = None) -> ParameterValues:
    said = [
        FoxgloveParameter(name=name, type=_type_of(value), value=value)
        for name, value in values.items()
    ]
    return ParameterValues(parameters=said, id=number)


def _type_of(value: ParameterValue) -> str | None:
    """Say the type where JSON does not: a whole number and one with a point look the same."""
    if isinstance(value, float):
        return "float64"
    # Of numbers with a point all are.
    floats = isinstance(value, list) and value and isinstance(value[0], float)
    return "float64_array" if floats else None
