"""One-shot commands: what may be asked, and where each stands. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from talaia.wire.frames import CommandPhase, CommandState

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = ["FINAL", "CommandBook"]

_P = CommandPhase
FINAL: Final = frozenset({_P.SUCCEEDED, _P.FAILED, _P.REFUSED, _P.CANCELLED, _P.UNKNOWN})
# Every step a command may take; all others are a mistake of ours or an answer that came too late.
_STEPS: Final[Mapping[CommandPhase, frozenset[CommandPhase]]] = {
    _P.ACCEPTED: frozenset({_P.RUNNING}) | FINAL,
    _P.RUNNING: frozenset({_P.RUNNING}) | FINAL,
    **{phase: frozenset[CommandPhase]() for phase in FINAL},
}


class CommandBook:
    """Every command this gateway knows of, by id; the gate all changes pass."""

    # Beyond this ended ones are forgotten, oldest first; a command that runs never is.
    KEPT = 10_000

    def __init__(self, remembered: Iterable[CommandState] = ()) -> None:
        """Take what the journal remembers; what had not ended then is unknown now."""
        # By id, oldest first; changed only by `enter_command` and `move_command`.
        self._states: dict[str, CommandState] = {}
        # What a restart cut off; told to the hub once, cleared by `CommandService.report_states`.
        self.interrupted: list[CommandState] = []
        for state in remembered:
            # Taken out first, so that the order is by the last time it was written.
            self._states.pop(state.id, None)
            self._states[state.id] = state
        for state in list(self._states.values()):
            if state.phase not in FINAL:
                lost = _next_state(
                    state=state,
                    # Neither failed nor done: the robot may have finished it. Only a person can
                    # tell.
                    phase=_P.UNKNOWN,
                    message="the gateway ended while this was under way",
                )
                self._states[state.id] = lost
                self.interrupted.append(lost)
        self._forget_oldest()

    def find_state(self, command_id: str) -> CommandState | None:
        """Give where a command stands, or none if its id was never seen."""
        return self._states.get(command_id)

    def all_states(self) -> list[CommandState]:
        """Give all, oldest first."""
        return list(self._states.values())

    def enter_command(self, state: CommandState) -> bool:
        """Enter a new id; tell whether it was new. An id is acted on only by who got True."""
        if state.id in self._states:
            return False
        self._states[state.id] = state
        self._forget_oldest()
        return True

    def move_command(
        self,
        *,
        command_id: str,
        phase: CommandPhase,
        message: str = "",
        progress: float = 0.0,
        blocked_by: str = "",
    ) -> CommandState | None:
        """Take a step, or give none when that step is not possible from where it stands."""
        state = self._states.get(command_id)
        # An answer that came after the end, or twice.
        if state is None or phase not in _STEPS[state.phase]:
            return None
        moved = _next_state(
            state=state, phase=phase, message=message, progress=progress, blocked_by=blocked_by
        )
        self._states[command_id] = moved
        return moved

    def _forget_oldest(self) -> None:
        excess = len(self._states) - self.KEPT
        if excess <= 0:
            return
        old = [key for key, state in self._states.items() if state.phase in FINAL][:excess]
        for key in old:
            del self._states[key]


def _next_state(
    *,
    state: CommandState,
    phase: CommandPhase,
    message: str,
    progress: float = 0.0,
    blocked_by: str = "",
) -> CommandState:
    return CommandState(
        id=state.id,
        device=state.device,
        command=state.command,
        phase=phase,
        message=message[:2000],
        # Progress never falls, whatever a robot's feedback says.
        progress=1.0 if phase is _P.SUCCEEDED else max(progress, state.progress),
        who=state.who,
        blocked_by=blocked_by,
    )
