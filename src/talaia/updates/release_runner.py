"""Starts the gateway's current release; one on trial it watches, and goes back if need be."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING

from talaia.updates.slot_folder import SlotFolder

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path
    from types import FrameType

    from talaia.updates.slot_folder import RunnableSlot

__all__ = ["RELEASES_VARIABLE", "PassedSignals", "run_release"]

# By this a gateway knows where its releases are.
RELEASES_VARIABLE = "TALAIA_GATEWAY_RELEASES"
_LOOK_S = 0.2
# A gateway that closes well needs a second or two.
_END_S = 10.0


def run_release(
    root: Path, words: Sequence[str], link_s: float, environment: Mapping[str, str] = os.environ
) -> int:
    """Run a gateway until it ends; give its exit code.

    Without a trial this process becomes the gateway. One on trial has ``link_s`` seconds to be
    linked with the hub; else it is ended, and the exit code asks for a start of the release before.
    """
    folder = SlotFolder(root)
    slot = folder.start_slot()
    command = [str(slot.program), "gateway", *words]
    variables = {**environment, RELEASES_VARIABLE: str(root)}
    if not slot.on_trial:
        sys.stdout.flush()
        os.execve(slot.program, command, variables)  # noqa: S606 - no shell, on purpose
    # The watchdog of the service is fed by the gateway, which is a process of its own now.
    variables.pop("WATCHDOG_PID", None)
    signals = PassedSignals()
    try:
        gateway = subprocess.Popen(command, env=variables)  # noqa: S603 - a release that was signed
    except OSError as error:
        folder.leave_candidate(f"it cannot be started: {error}")
        return 1
    signals.pass_to(gateway)
    return _watch_trial(folder, slot, gateway, signals=signals, link_s=link_s)


class PassedSignals:
    """Passes what would end this process on to its gateway.

    It listens before the gateway is there: an end between the two would leave the gateway alone.
    """

    def __init__(self) -> None:
        """Listen from now on."""
        self._gateway: subprocess.Popen[bytes] | None = None
        self._asked: list[int] = []
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self._pass_on)

    def __bool__(self) -> bool:
        """Tell whether anybody has asked for the end."""
        return bool(self._asked)

    def pass_to(self, gateway: subprocess.Popen[bytes]) -> None:
        """Send it what has come, and from now on what comes."""
        self._gateway = gateway
        for number in self._asked[:1]:
            gateway.send_signal(number)

    def _pass_on(self, number: int, _frame: FrameType | None) -> None:
        self._asked.append(number)
        if self._gateway is not None:
            self._gateway.send_signal(number)


def _watch_trial(
    folder: SlotFolder,
    slot: RunnableSlot,
    gateway: subprocess.Popen[bytes],
    *,
    signals: PassedSignals,
    link_s: float,
) -> int:
    until = time.monotonic() + link_s
    while True:
        code = _wait_code(gateway, _LOOK_S)
        if folder.is_linked(slot.version):
            folder.keep_candidate()
            return _passed_code(gateway.wait())
        # Whoever ends the service in the middle of a trial says nothing about the release.
        if signals:
            return _passed_code(gateway.wait())
        if code is not None:
            folder.leave_candidate(f"it ended with {code} before it had its link to the hub")
            return code or 1
        if time.monotonic() >= until:
            gateway.terminate()
            if _wait_code(gateway, _END_S) is None:
                gateway.kill()
                gateway.wait()
            folder.leave_candidate(f"no link to the hub within {link_s:g} s")
            return 1


def _wait_code(gateway: subprocess.Popen[bytes], seconds: float) -> int | None:
    try:
        return gateway.wait(seconds)
    except subprocess.TimeoutExpired:
        return None


def _passed_code(code: int) -> int:
    # As shells have it for a program that a signal has ended.
    return code if code >= 0 else 128 - code
