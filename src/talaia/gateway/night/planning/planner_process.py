"""Asks the planner in a process of its own, so that no loop that drives or guards waits for it.

It may die, hang or lie: then it is begun anew, and `RequestChooser` does without meanwhile.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import sys
from typing import TYPE_CHECKING, Protocol

import msgspec

from talaia.gateway.night.planning.planner_question import (
    PlannerAnswer,
    PlannerQuestion,
    PlannerSetup,
)

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["NightPlanner", "PlannerProcess"]

log = logging.getLogger(__name__)
# One that has not answered by then is ended (s).
ANSWER_S = 60.0
# Between two starts (s).
AGAIN_S = 5.0
# An answer with a plan and ten thousand reasons stays below it (bytes).
MOST_BYTES = 32 * 1024 * 1024


class NightPlanner(Protocol):
    """Who is asked what to observe next; its answers come when they come, or never."""

    def take_setup(self, setup: PlannerSetup) -> None:
        """Plan this from the next question on."""
        ...

    def ask(self, question: PlannerQuestion) -> None:
        """Ask; a question that waits still is forgotten for this one."""
        ...

    def begin_process(self) -> None:
        """Be there before the first question."""
        ...

    async def run(self) -> None:
        """Answer, until cancelled."""
        ...


class PlannerProcess:
    """See the module. Event loop only."""

    def __init__(self, answered: Callable[[PlannerAnswer], None]) -> None:
        """Begin no process yet; ``answered`` takes each answer."""
        self._answered = answered
        self._setup: PlannerSetup | None = None
        self._question: PlannerQuestion | None = None
        self._wake = asyncio.Event()

    def take_setup(self, setup: PlannerSetup) -> None:
        """Plan this from the next question on."""
        self._setup = setup

    def ask(self, question: PlannerQuestion) -> None:
        """Ask; a question that waits still is forgotten for this one."""
        self._question = question
        self._wake.set()

    def begin_process(self) -> None:
        """Have it there before the first question: its first answer is not late."""
        self._wake.set()

    async def run(self) -> None:
        """Keep the process while there are questions, until cancelled."""
        while True:
            await self._wake.wait()
            try:
                await self._run_process()
            except (OSError, TimeoutError, EOFError, msgspec.DecodeError) as error:
                log.warning("the planner's process ended: %s", str(error) or type(error).__name__)
                self._question = None
                self._wake.clear()
                await asyncio.sleep(AGAIN_S)

    async def _run_process(self) -> None:
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "talaia.gateway.night.planning.planner_child"),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
        )
        try:
            told: PlannerSetup | None = None
            while True:
                await self._wake.wait()
                self._wake.clear()
                question, self._question = self._question, None
                if question is None:
                    continue
                async with asyncio.timeout(ANSWER_S):
                    if self._setup is not told and self._setup is not None:
                        told = self._setup
                        await _write(process, msgspec.msgpack.encode(told))
                    await _write(process, msgspec.msgpack.encode(question))
                    answer = await _read(process)
                self._answered(msgspec.msgpack.decode(answer, type=PlannerAnswer))
        finally:
            with contextlib.suppress(ProcessLookupError):
                process.kill()
            await process.wait()


async def _write(process: asyncio.subprocess.Process, data: bytes) -> None:
    if process.stdin is None:
        raise EOFError("no pipe")
    process.stdin.write(len(data).to_bytes(4, "big") + data)
    await process.stdin.drain()


async def _read(process: asyncio.subprocess.Process) -> bytes:
    if process.stdout is None:
        raise EOFError("no pipe")
    head = await process.stdout.readexactly(4)
    size = int.from_bytes(head, "big")
    if size > MOST_BYTES:
        raise EOFError(f"an answer of {size} bytes")
    return await process.stdout.readexactly(size)
