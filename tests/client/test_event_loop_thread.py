"""Wherever Ctrl-C comes, what a program waits for has ended before the program goes on."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from talaia.client.event_loop_thread import EventLoopThread


@pytest.fixture
def thread():
    thread = EventLoopThread()
    yield thread
    thread.stop_thread()


def test_an_answer_and_an_error_come_to_who_waits(thread) -> None:
    async def answer() -> int:
        return 7

    async def fail() -> None:
        raise ValueError("no")

    assert thread.run_coroutine(answer()) == 7
    with pytest.raises(ValueError, match="no"):
        thread.run_coroutine(fail())


class InterruptedLoop:
    """A loop to which Ctrl-C comes while the first call is handed over."""

    def __init__(self, loop: asyncio.AbstractEventLoop, *, after: bool) -> None:
        """Let ``loop`` have the first call or not, before Ctrl-C."""
        self._loop, self._after = loop, after
        self._pressed = False

    def call_soon_threadsafe(self, *call: Any) -> None:
        first, self._pressed = not self._pressed, True
        if self._after or not first:
            self._loop.call_soon_threadsafe(*call)
        if first:
            raise KeyboardInterrupt


@pytest.mark.parametrize("after", [False, True])
def test_ctrl_c_around_the_handing_over_leaves_nothing_running(thread, after) -> None:
    steps: list[str] = []

    async def work() -> None:
        steps.append("begun")
        try:
            await asyncio.Event().wait()
        finally:
            await asyncio.sleep(0)
            steps.append("tidied")

    async def count() -> int:
        return len(asyncio.all_tasks())

    loop = thread._loop
    thread._loop = InterruptedLoop(loop, after=after)
    with pytest.raises(KeyboardInterrupt):
        thread.run_coroutine(work())
    thread._loop = loop
    # At once, and not when a bound in time has passed.
    assert steps in ([], ["begun", "tidied"])
    assert thread.run_coroutine(count()) == 1
