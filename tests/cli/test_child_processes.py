"""Processes that run together: their words are heard, their end is noticed, all are ended."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import time
from pathlib import Path

import psutil
import pytest
from patience import PATIENCE_S

from talaia.cli.child_processes import (
    ChildProcess,
    end_all,
    run_together,
    start_program,
    start_talaia,
)
from talaia.cli.errors import PartStopped

WAITING = [sys.executable, "-c", "import signal; signal.pause()"]


async def test_a_parts_words_are_heard_and_kept_in_its_log(tmp_path: Path) -> None:
    part = await start_talaia("checker", ["--version"], tmp_path / "log")
    try:
        assert "talaia" in await part.wait_line("talaia", 30)
        with pytest.raises(PartStopped, match="exit code 0"):
            await part.wait_failure()
        assert "talaia" in (tmp_path / "log").read_text()
    finally:
        await end_all([part])


async def test_a_part_that_fails_at_the_start_is_told_with_its_last_words(tmp_path: Path) -> None:
    part = await start_talaia("checker", ["nonsense"], tmp_path / "log")
    try:
        with pytest.raises(PartStopped) as caught:
            await part.wait_line("ready", 30)
        assert caught.value.code == 2
        assert "unknown command 'nonsense'" in str(caught.value)
    finally:
        await end_all([part])


async def test_a_part_is_in_a_session_of_its_own_and_ends_when_asked(tmp_path: Path) -> None:
    part = await start_talaia(
        "waiter", ["account", "ada", "--data", str(tmp_path)], tmp_path / "log"
    )
    assert os.getsid(part.process.pid) == part.process.pid
    os.kill(part.process.pid, signal.SIGSTOP)  # it cannot answer: the kill must follow
    end = time.monotonic() + PATIENCE_S
    while psutil.Process(part.process.pid).status() != psutil.STATUS_STOPPED:
        assert time.monotonic() < end
    await part.end_process(within=0.2)
    assert part.process.returncode == -signal.SIGKILL


async def runs(part: ChildProcess, before: int) -> int:
    """Wait until a part runs as another process than before; gives its number."""
    deadline = time.monotonic() + PATIENCE_S
    while part.process.pid == before or part.process.returncode is not None:
        assert time.monotonic() < deadline
        await asyncio.sleep(0.01)
    return part.process.pid


async def test_a_part_that_is_killed_is_started_again_and_that_is_said_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kept: list[ChildProcess] = []

    async def begin(parts: list[ChildProcess]) -> None:
        parts.append(await start_program("waiter", WAITING, tmp_path / "log", restart=True))
        kept.extend(parts)

    running = asyncio.create_task(run_together(begin))
    deadline = time.monotonic() + PATIENCE_S
    while not kept:
        assert time.monotonic() < deadline
        await asyncio.sleep(0.01)
    (part,) = kept
    first = part.process.pid
    part.process.kill()
    second = await runs(part, first)
    part.process.kill()
    third = await runs(part, second)
    os.kill(os.getpid(), signal.SIGTERM)
    await running
    said = capsys.readouterr().out
    assert said.count("the waiter stopped (exit code -9); it is started again") == 1
    assert said.endswith("stopping …\n")
    assert not psutil.pid_exists(third)


async def test_a_part_that_does_not_stay_is_told_with_its_last_words(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part = await start_talaia("checker", ["nonsense"], tmp_path / "log", restart=True)
    keeping = asyncio.create_task(part.keep_running())
    said, deadline = "", time.monotonic() + PATIENCE_S
    while "again and again" not in said:
        assert time.monotonic() < deadline
        await asyncio.sleep(0.01)
        said += capsys.readouterr().out
    keeping.cancel()
    await asyncio.gather(keeping, return_exceptions=True)
    await end_all([part])
    assert said.count("it is started again") == 1
    assert said.count("stops again and again") == 1
    assert "unknown command 'nonsense'" in said
    assert part.process.returncode is not None


async def test_a_part_that_is_cut_short_while_it_starts_again_is_ended_with_the_others(
    tmp_path: Path,
) -> None:
    part = await start_program("waiter", WAITING, tmp_path / "log")
    first, launched = part.process, asyncio.Event()

    async def slowly() -> asyncio.subprocess.Process:
        launched.set()
        return await asyncio.create_subprocess_exec(*WAITING, stdout=asyncio.subprocess.PIPE)

    part._relaunch = slowly
    keeping = asyncio.create_task(part.keep_running())
    first.kill()
    await launched.wait()
    keeping.cancel()
    await asyncio.gather(keeping, return_exceptions=True)
    assert part.process is not first
    await end_all([part])
    assert part.process.returncode is not None


async def test_a_part_that_is_not_to_be_started_again_ends_all(tmp_path: Path) -> None:
    async def begin(parts: list[ChildProcess]) -> None:
        parts.append(await start_talaia("checker", ["--version"], tmp_path / "log"))

    with pytest.raises(PartStopped, match="exit code 0"):
        await run_together(begin)
