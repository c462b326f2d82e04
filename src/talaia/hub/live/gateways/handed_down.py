"""In whose names the hub itself has asked something of a gateway: only these count.

A gateway repeats them in what it reports. Any other name that it says, be it an account's, is
marked as the gateway's own word.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from talaia.wire.frames import FromHub

__all__ = ["HandedDown"]

_T = TypeVar("_T")
# The oldest are forgotten beyond so many.
_MOST_NAMES = 500
_MOST_ASKED = 5_000
# As long as a name may be.
_MOST_CHARACTERS = 200


class HandedDown:
    """What was handed down to one site; kept over links, for answers come late."""

    def __init__(self) -> None:
        """Begin with nobody."""
        self._names: dict[str, None] = {}
        # By the id of a command or a STOP, or by the session of a lease.
        self._askers: dict[str, str] = {}
        # How a command ended, by its id.
        self._ends: dict[str, CommandPhase] = {}

    def record_message(self, message: FromHub) -> None:
        """Remember in whose name something goes down, if in anybody's."""
        who = getattr(message, "who", "")
        if not who:
            return
        _remember(self._names, who, None, _MOST_NAMES)
        for key in (getattr(message, "id", ""), getattr(message, "session", "")):
            if key:
                _remember(self._askers, key, who, _MOST_ASKED)

    def asker_of(self, key: str) -> str | None:
        """Give who asked for a command by its id, or for a lease by the session."""
        return self._askers.get(key)

    def may_go_on(self, key: str, phase: CommandPhase, *, final: bool) -> bool:
        """Tell whether a command that was asked for may still come to a phase; it ends once.

        What was told as unknown may have an end yet: its gateway was away.
        """
        before = self._ends.get(key)
        if before not in {None, CommandPhase.UNKNOWN} or (before is not None and before is phase):
            return False
        if final and key in self._askers:
            _remember(self._ends, key, phase, _MOST_ASKED)
        return True

    def contradicts_end(self, key: str, phase: CommandPhase) -> bool:
        """Tell whether a command that has ended would have another end by this."""
        return self._ends.get(key) not in {None, phase}

    def known_name(self, said: str) -> str:
        """Give a name that a gateway says, marked where the hub never handed it down."""
        if not said or said in self._names:
            return said
        return f"gateway: {said}"[:_MOST_CHARACTERS]


def _remember(known: dict[str, _T], key: str, value: _T, most: int) -> None:
    # To the end: what was used last is forgotten last.
    known.pop(key, None)
    known[key] = value
    while len(known) > most:
        del known[next(iter(known))]
