"""Starting a site here, or writing a deployment: the commands, and what has come of them. Pure."""

from __future__ import annotations

import re
from collections import deque
from enum import StrEnum
from typing import TYPE_CHECKING

from talaia.configurator.errors import ImpossibleStep

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["MAX_LINES", "ProgramPhase", "ProgramRun", "deploy_command", "up_command"]

MAX_LINES = 2000
# The greeting of `talaia up`, which prints these lines.
_READY = re.compile(r" is up \([0-9.]+ s\):\s+(?P<address>https?://\S+)")
_SETUP = re.compile(r"(?P<setup>https?://\S+/setup#\S+)")
# Its last line: only then both parts run and the whole greeting is there.
_LAST_WORD = "Ctrl-C stops everything"


def up_command(talaia: Sequence[str], file: str, data: str = "") -> list[str]:
    """Give the words that start hub and gateway of a saved description."""
    more = ["--data", data] if data else []
    return [*talaia, "up", file, "--no-browser", *more]


def deploy_command(
    talaia: Sequence[str], file: str, folder: str, database: str, *, over: bool
) -> list[str]:
    """Give the words that write a deployment's folder."""
    words = [*talaia, "generate", file, "--to", folder, "--database", database]
    return [*words, *["--force"] * over]


class ProgramPhase(StrEnum):
    """How far it is."""

    IDLE = "idle"
    STARTING = "starting"
    UP = "up"
    STOPPING = "stopping"
    ENDED = "ended"
    FAILED = "failed"


_NEXT = {
    ProgramPhase.IDLE: {ProgramPhase.STARTING},
    # ENDED from here: a command that does its work and ends, as the deployment's does.
    ProgramPhase.STARTING: {
        ProgramPhase.UP,
        ProgramPhase.STOPPING,
        ProgramPhase.ENDED,
        ProgramPhase.FAILED,
    },
    # No ENDED: a site that runs and ends by itself has failed, whatever its code.
    ProgramPhase.UP: {ProgramPhase.STOPPING, ProgramPhase.FAILED},
    ProgramPhase.STOPPING: {ProgramPhase.ENDED},
    ProgramPhase.ENDED: {ProgramPhase.STARTING},
    ProgramPhase.FAILED: {ProgramPhase.STARTING},
}


class ProgramRun:
    """A command that a person started, one after the other.

    Attributes:
        lines: the newest `MAX_LINES` lines of its log.
        address: of the dashboard, once it is up.
        setup: where the first admin's account is made; empty when there is one.

    """

    def __init__(self) -> None:
        """Begin idle."""
        # Changed by `_set_phase` alone.
        self.phase = ProgramPhase.IDLE
        # Of the last run; cleared by the next start.
        self.lines: deque[str] = deque(maxlen=MAX_LINES)
        # Found in the output while it starts; ``problem`` says why it failed. All empty at a start.
        self.address = self.setup = self.problem = ""

    @property
    def is_alive(self) -> bool:
        """Whether there is a process."""
        return self.phase in (ProgramPhase.STARTING, ProgramPhase.UP, ProgramPhase.STOPPING)

    @property
    def page(self) -> str:
        """What to open in the browser."""
        return self.setup or self.address

    def start(self, words: Sequence[str]) -> None:
        """Take note that the process is being started."""
        self._set_phase(ProgramPhase.STARTING)
        self.lines.clear()
        self.address = self.setup = self.problem = ""
        self.lines.append(
            # Shown as a person would type it, not with the interpreter's path.
            "talaia " + " ".join(words[words.index("talaia") + 1 :])
            if "talaia" in words
            else " ".join(words)
        )

    def add_line(self, text: str) -> None:
        """Take in a line that it said."""
        self.lines.append(text)
        if self.phase is not ProgramPhase.STARTING:
            return
        if ready := _READY.search(text):
            self.address = ready["address"]
        elif setup := _SETUP.search(text):
            self.setup = setup["setup"]
        # After the address and the link for the first admin, which stand above it.
        elif _LAST_WORD in text and self.address:
            self._set_phase(ProgramPhase.UP)

    def stop(self) -> None:
        """Take note that a person wants it to end."""
        self._set_phase(ProgramPhase.STOPPING)

    def handle_exit(self, code: int) -> None:
        """Take in the end of the process."""
        if self.phase is ProgramPhase.STOPPING or (
            self.phase is ProgramPhase.STARTING and code == 0
        ):
            self._set_phase(ProgramPhase.ENDED)
            return
        # The last line that says something; the first is the command itself.
        said = [line for line in self.lines if line.strip() and line.strip() != "stopping …"]
        self.problem = said[-1].strip() if len(said) > 1 else f"it ended with code {code}"
        self._set_phase(ProgramPhase.FAILED)

    def not_started(self, program: str) -> None:
        """Take in that the process could not be started at all."""
        if self.phase is ProgramPhase.STOPPING:
            # Stopped before it began: it has ended, as was wished.
            self._set_phase(ProgramPhase.ENDED)
            return
        self.problem = f"{program} could not be started; is it still there?"
        self._set_phase(ProgramPhase.FAILED)

    def _set_phase(self, phase: ProgramPhase) -> None:
        if phase not in _NEXT[self.phase]:
            raise ImpossibleStep(self.phase, phase)
        self.phase = phase
