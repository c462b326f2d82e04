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

__all__ = ["RELEASES_VARIABLE", "run_release"]

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
    try:
        gateway = subprocess.Popen(command, env=variables)  # noqa: S603 - a release that was signed
    except OSError as error:
        folder.leave_candidate(f"it cannot be started: {error}")
        return 1
    return _watch_trial(folder, slot, gateway, link_s)


def _watch_trial(
    folder: SlotFolder, slot: RunnableSlot, gateway: subprocess.Popen[bytes], link_s: float
) -> int:
    asked: list[int] = []

    def pass_on(number: int, _frame: FrameType | None) -> None:
        asked.append(number)
        gateway.send_signal(number)

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, pass_on)
    until = time.monotonic() + link_s
    while True:
        code = _wait_code(gateway, _LOOK_S)
        if folder.is_linked(slot.version):
            folder.keep_candidate()
            return _passed_code(gateway.wait())
        # Whoever ends the service in the middle of a trial says nothing about the release.
        if asked:
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
