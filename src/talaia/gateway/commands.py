"""One-shot commands: what may be asked, and where each stands. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from talaia.model.site import ArgumentType
from talaia.wire.frames import CommandPhase, CommandState

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from talaia.model.site import Argument, Command
    from talaia.wire.frames import Scalar

__all__ = ["FINAL", "CommandBook", "fields_of"]

_P = CommandPhase
FINAL: Final = frozenset({_P.SUCCEEDED, _P.FAILED, _P.REFUSED, _P.CANCELLED, _P.UNKNOWN})
# Every step a command may take; all others are a mistake of ours or an answer that came too late.
_STEPS: Final[Mapping[CommandPhase, frozenset[CommandPhase]]] = {
    _P.ACCEPTED: frozenset({_P.RUNNING}) | FINAL,
    _P.RUNNING: frozenset({_P.RUNNING}) | FINAL,
    **{phase: frozenset[CommandPhase]() for phase in FINAL},
}


def fields_of(command: Command, args: Mapping[str, Scalar]) -> dict[str, Scalar] | str:
    """Give the request's fields by path, or the sentence that says what is wrong with ``args``."""
    unknown = sorted(set(args) - set(command.arguments))
    if unknown:
        return f"there is no argument {unknown[0]!r}"
    fields: dict[str, Scalar] = dict(command.fixed)
    for name, argument in command.arguments.items():
        value = args.get(name, argument.default)
        if value is None:
            return f"the argument {name!r} is missing"
        problem = _problem(argument, value)
        if problem:
            return f"{name}: {problem}"
        fields[argument.field] = float(value) if argument.type is ArgumentType.NUMBER else value
    return fields


def _problem(argument: Argument, value: Scalar) -> str:
    match argument.type:
        case ArgumentType.BOOLEAN:
            return "" if isinstance(value, bool) else f"expected true or false, found {value!r}"
        case ArgumentType.TEXT:
            if not isinstance(value, str):
                return f"expected a text, found {value!r}"
            if len(value) > argument.max_length:
                return f"at most {argument.max_length} characters, found {len(value)}"
            return ""
        case ArgumentType.INTEGER:
            if not isinstance(value, int) or isinstance(value, bool):
                return f"expected a whole number, found {value!r}"
            return _range_problem(argument, value)
        case ArgumentType.NUMBER:
            if not isinstance(value, int | float) or isinstance(value, bool):
                return f"expected a number, found {value!r}"
            return _range_problem(argument, value)


def _range_problem(argument: Argument, value: float) -> str:
    try:
        finite = math.isfinite(value)
    except OverflowError:
        finite = False
    if not finite:
        return "expected a finite number"
    if argument.minimum is not None and value < argument.minimum:
        return f"{value} is below {argument.minimum}"
    if argument.maximum is not None and value > argument.maximum:
        return f"{value} is above {argument.maximum}"
    return ""


class CommandBook:
    """Every command this gateway knows of, by id; the gate all changes pass."""

    KEPT = 10_000

    def __init__(self, remembered: Iterable[CommandState] = ()) -> None:
        """Take what the journal remembers; what had not ended then is unknown now."""
        self._states: dict[str, CommandState] = {}
        self.interrupted: list[CommandState] = []
        for state in remembered:
            self._states.pop(state.id, None)
            self._states[state.id] = state
        for state in list(self._states.values()):
            if state.phase not in FINAL:
                lost = _with(state, _P.UNKNOWN, "the gateway ended while this was under way")
                self._states[state.id] = lost
                self.interrupted.append(lost)
        self._forget()

    def get(self, command_id: str) -> CommandState | None:
        """Give where a command stands, or none if its id was never seen."""
        return self._states.get(command_id)

    def states(self) -> list[CommandState]:
        """Give all, oldest first."""
        return list(self._states.values())

    def open(self, state: CommandState) -> bool:
        """Enter a new id; tell whether it was new. An id is acted on only by who got True."""
        if state.id in self._states:
            return False
        self._states[state.id] = state
        self._forget()
        return True

    def move(self, command_id: str, phase: CommandPhase, message: str = "") -> CommandState | None:
        """Take a step, or give none when that step is not possible from where it stands."""
        state = self._states.get(command_id)
        if state is None or phase not in _STEPS[state.phase]:
            return None
        moved = _with(state, phase, message)
        self._states[command_id] = moved
        return moved

    def _forget(self) -> None:
        excess = len(self._states) - self.KEPT
        if excess <= 0:
            return
        old = [key for key, state in self._states.items() if state.phase in FINAL][:excess]
        for key in old:
            del self._states[key]


def _with(state: CommandState, phase: CommandPhase, message: str) -> CommandState:
    return CommandState(
        id=state.id,
        device=state.device,
        command=state.command,
        phase=phase,
        message=message[:2000],
        progress=1.0 if phase is _P.SUCCEEDED else state.progress,
        who=state.who,
    )
