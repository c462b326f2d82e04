"""Wherever Ctrl-C comes, what a program waits for has ended before the program goes on."""

from __future__ import annotations

import asyncio
import threading

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


@pytest.mark.parametrize("interrupted", ["before it is handed over", "after it is handed over"])
def test_ctrl_c_around_the_handing_over_leaves_nothing_running(
    thread, monkeypatch, interrupted
) -> None:
    steps: list[str] = []
    tidied = threading.Event()

    async def work() -> None:
        steps.append("begun")
        try:
            await asyncio.Event().wait()
        finally:
            await asyncio.sleep(0)
            steps.append("tidied")
            tidied.set()

    hand_over, calls = thread._loop.call_soon_threadsafe, []

    def press(*call) -> None:
        calls.append(call)
        if len(calls) > 1:
            hand_over(*call)
            return
        if interrupted == "after it is handed over":
            hand_over(*call)
        raise KeyboardInterrupt

    monkeypatch.setattr(thread._loop, "call_soon_threadsafe", press)
    with pytest.raises(KeyboardInterrupt):
        thread.run_coroutine(work())
    # At once, and not when a bound in time has passed.
    assert steps in ([], ["begun", "tidied"])
    assert tidied.is_set() == bool(steps)
    monkeypatch.undo()

    async def count() -> int:
        return len(asyncio.all_tasks())

    assert thread.run_coroutine(count()) == 1
