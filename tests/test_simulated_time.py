"""Hours pass at once on a simulated loop, and real work stops them."""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from collections.abc import Callable, Coroutine
from typing import Any

import pytest

from talaia.clock import SECOND, HandClock
from talaia.simulated_time import SimulatedLoop


def run_on(
    clock: HandClock, live: Callable[[], Coroutine[Any, Any, None]], least: float = 0.0
) -> None:
    with asyncio.Runner(loop_factory=lambda: SimulatedLoop(clock, least)) as runner:
        runner.run(live())


async def pass_time(seconds: float) -> None:
    """Let simulated time pass; no real one does."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(seconds):
            await asyncio.get_running_loop().create_future()


def test_a_night_of_sleep_takes_no_time_and_moves_both_times() -> None:
    clock, began = HandClock(), time.monotonic()
    before = clock.wall_ns()

    async def live() -> None:
        await pass_time(36_000.0)

    run_on(clock, live)
    assert clock.monotonic_ns() >= 36_000 * SECOND
    assert clock.wall_ns() - before == clock.monotonic_ns()
    assert time.monotonic() - began < 3600.0


def test_what_is_due_comes_in_its_order_and_not_before_its_time() -> None:
    clock, came = HandClock(), []

    async def wait(seconds: float) -> None:
        await pass_time(seconds)
        came.append((seconds, clock.monotonic_ns() / SECOND))

    async def live() -> None:
        await asyncio.gather(wait(30.0), wait(10.0), wait(20.0))

    run_on(clock, live)
    assert [seconds for seconds, _ in came] == [10.0, 20.0, 30.0]
    assert all(0.0 <= at - seconds < 0.01 for seconds, at in came)


def test_time_outs_are_of_the_same_time() -> None:
    clock = HandClock()

    async def live() -> None:
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(600.0):
                await asyncio.get_running_loop().create_future()

    run_on(clock, live)
    assert 600 * SECOND <= clock.monotonic_ns() < 601 * SECOND


def test_what_looks_often_looks_once_in_the_least_span() -> None:
    clock, looks = HandClock(), 0

    async def look() -> None:
        nonlocal looks
        while True:
            looks += 1
            await pass_time(0.1)

    async def live() -> None:
        looking = asyncio.ensure_future(look())
        await pass_time(100.0)
        looking.cancel()

    run_on(clock, live, least=1.0)
    assert 90 <= looks <= 110


def test_time_stands_while_a_thread_works() -> None:
    clock = HandClock()

    async def live() -> None:
        ticking = asyncio.ensure_future(pass_time(5.0))
        # A real hundredth of a second, in which hours could pass.
        await asyncio.to_thread(lambda: sum(range(100_000)))
        assert clock.monotonic_ns() < SECOND
        assert not ticking.done()
        await ticking

    run_on(clock, live)
    assert clock.monotonic_ns() >= 5 * SECOND


def test_time_stands_while_something_real_is_waited_for() -> None:
    clock = HandClock()

    async def live() -> None:
        loop = asyncio.get_running_loop()
        assert isinstance(loop, SimulatedLoop)
        ticking = asyncio.ensure_future(pass_time(60.0))
        with loop.real_work():
            process = await asyncio.create_subprocess_exec("true")
            await process.wait()
            assert clock.monotonic_ns() < SECOND
        await ticking

    run_on(clock, live)
    assert clock.monotonic_ns() >= 60 * SECOND


def test_a_paced_loop_is_no_faster_than_it_is_told() -> None:
    clock, began = HandClock(), time.monotonic()

    async def live() -> None:
        loop = asyncio.get_running_loop()
        assert isinstance(loop, SimulatedLoop)
        loop.pace_time(1000.0)
        await pass_time(100.0)

    run_on(clock, live, least=1.0)
    assert clock.monotonic_ns() >= 100 * SECOND
    assert time.monotonic() - began >= 0.1


def test_who_speaks_from_another_thread_is_heard_at_once_by_a_paced_loop() -> None:
    clock = HandClock()

    async def live() -> None:
        loop, heard = asyncio.get_running_loop(), asyncio.Event()
        assert isinstance(loop, SimulatedLoop)
        # An hour of its time takes a real hour.
        loop.pace_time(1.0)
        resting = asyncio.ensure_future(pass_time(3600.0))
        threading.Thread(target=loop.call_soon_threadsafe, args=(heard.set,)).start()
        await heard.wait()
        assert clock.monotonic_ns() < 3600 * SECOND
        resting.cancel()

    run_on(clock, live)
