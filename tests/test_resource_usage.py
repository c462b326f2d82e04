"""A process says what it uses when it is asked by a signal."""

import asyncio
import logging
import os
import signal

import pytest
from patience import PATIENCE_S

from talaia.resource_usage import describe_usage, report_usage_on_signal


async def waits(ended: asyncio.Event) -> None:
    await ended.wait()


async def test_tasks_are_counted_by_what_they_run() -> None:
    ended = asyncio.Event()
    tasks = [asyncio.create_task(waits(ended)) for _ in range(7)]
    said = describe_usage(asyncio.get_running_loop())
    assert said.startswith(f"usage: tasks {len(asyncio.all_tasks())}, threads ")
    assert "7 waits" in said
    ended.set()
    await asyncio.gather(*tasks)
    assert "waits" not in describe_usage(asyncio.get_running_loop())


async def test_the_signal_writes_it_to_the_log_and_ends_nothing(
    caplog: pytest.LogCaptureFixture,
) -> None:
    loop = asyncio.get_running_loop()
    report_usage_on_signal(loop, lambda: 3 * 2**19)
    try:
        with caplog.at_level(logging.INFO):
            os.kill(os.getpid(), signal.SIGUSR1)
            async with asyncio.timeout(PATIENCE_S):
                while not caplog.messages:  # noqa: ASYNC110 - the signal is on its way
                    await asyncio.sleep(0)
    finally:
        loop.remove_signal_handler(signal.SIGUSR1)
    assert caplog.messages[0].startswith("usage: tasks ")
    assert ", cached 1.50 MiB;" in caplog.messages[0]
