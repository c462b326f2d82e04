"""Finding what a robot offers: which command is run, and what has come of it so far. Pure.

`talaia probe --json` is run here, or over ssh on the robot, so that a laptop needs no ROS. There
is no shell here; the one that ssh starts at the other end gets words of an allowed alphabet only.
"""

from __future__ import annotations

import re
from enum import StrEnum
from typing import TYPE_CHECKING

from talaia.configurator.errors import BadHost, ImpossibleStep
from talaia.model.discovery.probe_report import NotAProbe, found_from

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.model.discovery.probe_report import Found

__all__ = ["DiscoveryPhase", "RobotDiscovery", "probe_command"]

# Neither part may begin with "-": ssh would take it for an option that runs a program. ``\Z``, for
# ``$`` would let a line end through.
_HOST = re.compile(
    r"(?:(?P<user>[A-Za-z_][A-Za-z0-9_.-]{0,63})@)?"
    r"(?P<host>[A-Za-z0-9][A-Za-z0-9.-]{0,252}|\[[0-9A-Fa-f:.]{2,45}\])"
    r"(?::(?P<port>[0-9]{1,5}))?\Z"
)
# No blank and nothing that a shell would run: ssh's other end passes it to one. ``~`` is the home
# there.
_PROGRAM = re.compile(r"[A-Za-z0-9_~./][A-Za-z0-9_./-]{0,199}\Z")
SECONDS = 5.0
# Python starts, ROS finds its peers, ssh says hello.
START_S = 6.0
# Of the errors that ssh and the probe printed.
_LAST_LINES = 6


def probe_command(
    talaia: Sequence[str], host: str = "", program: str = "talaia", seconds: float = SECONDS
) -> list[str]:
    """Give the words that look for a robot.

    Args:
        talaia: how Talaia is started here: the interpreter and its arguments.
        host: where to look, ``[user@]name[:port]``; empty for this machine.
        program: what Talaia is called there.
        seconds: how long to listen (s).

    Raises:
        BadHost: ``host`` or ``program`` is not what ssh may be given.

    """
    # JSON, for the Talaia there may be of another version than this one.
    words = ["probe", "--json", "--seconds", f"{seconds:g}"]
    if not host.strip():
        return [*talaia, *words]
    match = _HOST.match(host.strip())
    if match is None:
        raise BadHost(f"{host.strip()!r} is not a computer's name; write it as user@robot.local")
    port = int(match["port"] or 22)
    if not 1 <= port <= 65535:
        raise BadHost(f"expected a port from 1 to 65535, found {port}")
    if not _PROGRAM.match(program):
        raise BadHost(
            f"{program!r} is not the path of a program; use letters, digits, dots, _ - and /"
        )
    # ssh takes an IPv6 address without brackets, as the port is an option.
    name = match["host"].strip("[]")
    target = f"{match['user']}@{name}" if match["user"] else name
    # Nobody sits at a prompt: a question is an error that says what to do.
    options = ["-T", "-o", "BatchMode=yes", "-o", "ConnectTimeout=10", "-p", str(port)]
    # After ``--`` nothing is an option any more.
    return ["ssh", *options, "--", target, program, *words]


class DiscoveryPhase(StrEnum):
    """How far a look is."""

    IDLE = "idle"
    RUNNING = "running"
    CANCELLING = "cancelling"
    CANCELLED = "cancelled"
    FAILED = "failed"
    DONE = "done"


_NEXT = {
    DiscoveryPhase.IDLE: {DiscoveryPhase.RUNNING},
    DiscoveryPhase.RUNNING: {DiscoveryPhase.CANCELLING, DiscoveryPhase.FAILED, DiscoveryPhase.DONE},
    # A result that comes while it is being cancelled is not used.
    DiscoveryPhase.CANCELLING: {DiscoveryPhase.CANCELLED},
    DiscoveryPhase.CANCELLED: {DiscoveryPhase.RUNNING},
    DiscoveryPhase.FAILED: {DiscoveryPhase.RUNNING},
    DiscoveryPhase.DONE: {DiscoveryPhase.RUNNING},
}


class RobotDiscovery:
    """One look after the other at a robot."""

    def __init__(self) -> None:
        """Begin idle."""
        # Changed by `_set_state` alone.
        self.phase = DiscoveryPhase.IDLE
        # What the last look found; none until it is done, and cleared by the next one.
        self.found: Found | None = None
        # Why the last look failed, in words; empty else.
        self.problem = ""
        # Which computer, for the words of a problem.
        self._where = ""
        # How long the look should take (s), for the progress.
        self._planned = SECONDS + START_S

    def mark_started(self, host: str, seconds: float = SECONDS) -> None:
        """Take note that the probe's process is being started."""
        self._set_state(DiscoveryPhase.RUNNING)
        self.found, self.problem = None, ""
        self._where = host.strip() or "this machine"
        self._planned = seconds + START_S

    def expected_progress(self, elapsed: float) -> float:
        """Say how far it should be after ``elapsed`` seconds, 0 to 1; never quite 1."""
        # Full only when the answer is there: a slow network must not look like a look that is over.
        return min(elapsed / self._planned, 0.97)

    def mark_cancelled(self) -> None:
        """Take note that a person wants no more of it."""
        self._set_state(DiscoveryPhase.CANCELLING)

    def handle_exit(self, code: int, said: bytes, complained: str) -> None:
        """Take in the end of the process: its exit code, its output, and its errors."""
        if self.phase is DiscoveryPhase.CANCELLING:
            self._set_state(DiscoveryPhase.CANCELLED)
            return
        try:
            # 1 says that the graph is empty, in JSON all the same.
            found = found_from(said, f"the answer of {self._where}") if code in (0, 1) else None
        except NotAProbe as error:
            found, complained = None, f"{complained}\n{error}" if complained else str(error)
        if found is not None and (found.topics or found.services or found.actions):
            self.found = found
            self._set_state(DiscoveryPhase.DONE)
            return
        self.problem = (
            _explain_failure(code, complained, self._where)
            if found is None
            else f"Nothing was heard at {found.where}. Is the robot running, in the same ROS "
            f"domain ({found.domain}), on the same network, with the same RMW_IMPLEMENTATION?"
        )
        self._set_state(DiscoveryPhase.FAILED)

    def not_started(self, program: str) -> None:
        """Take in that the process could not be started at all."""
        if self.phase is DiscoveryPhase.CANCELLING:
            # Cancelled before it began: a person has no more use for the reason.
            self._set_state(DiscoveryPhase.CANCELLED)
            return
        remedy = "install OpenSSH's client" if program == "ssh" else "is the program still there?"
        self.problem = f"{program} could not be started; {remedy}"
        self._set_state(DiscoveryPhase.FAILED)

    def _set_state(self, phase: DiscoveryPhase) -> None:
        if phase not in _NEXT[self.phase]:
            raise ImpossibleStep(self.phase, phase)
        self.phase = phase


# What ssh and shells say, and what a person can do about it.
_REMEDIES = (
    (
        "permission denied",
        "{where} does not let this user in without a password; "
        "run in a terminal: ssh-copy-id {where}",
    ),
    (
        "host key verification failed",
        "{where} is not known here yet, or is another computer than before; "
        "run in a terminal: ssh {where}, and compare its key",
    ),
    ("could not resolve hostname", "there is no computer called {where} on this network"),
    ("connection refused", "{where} runs no ssh server on that port"),
    ("timed out", "{where} does not answer; is it on, and on this network?"),
    ("no route to host", "{where} does not answer; is it on, and on this network?"),
    ("network is unreachable", "this machine has no network route to {where}"),
    (
        "which is not installed",
        "there is no ROS 2 for Talaia at {where}; run there: pip install 'talaia[ros2]', "
        "or look from a machine that has it",
    ),
)


def _explain_failure(code: int, complained: str, where: str) -> str:
    # Programs differ in their capitals from version to version.
    low = complained.lower()
    last = "\n".join(complained.strip().splitlines()[-_LAST_LINES:])
    for sign, remedy in _REMEDIES:
        if sign in low:
            return f"{remedy.format(where=where)}.\n{last}"
    # What a shell gives for a command that it does not find (POSIX).
    if code == 127 or "command not found" in low:
        return (
            f"{where} has no talaia that a plain ssh command finds; install it there, or write "
            f"the whole path of the program.\n{last}"
        )
    return f"the probe at {where} ended with code {code}.\n{last}".rstrip()
