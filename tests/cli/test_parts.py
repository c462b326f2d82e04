"""Processes that run together: their words are heard, their end is noticed, all are ended."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import psutil
import pytest
from patience import PATIENCE_S

from talaia.cli.errors import PartStopped
from talaia.cli.parts import end_all, start


async def test_a_parts_words_are_heard_and_kept_in_its_log(tmp_path: Path) -> None:
    part = await start("checker", ["--version"], tmp_path / "log")
    try:
        assert "talaia" in await part.says("talaia", 30)
        with pytest.raises(PartStopped, match="exit code 0"):
            await part.ended()
        assert "talaia" in (tmp_path / "log").read_text()
    finally:
        await end_all([part])


async def test_a_part_that_fails_at_the_start_is_told_with_its_last_words(tmp_path: Path) -> None:
    part = await start("checker", ["nonsense"], tmp_path / "log")
    try:
        with pytest.raises(PartStopped) as caught:
            await part.says("ready", 30)
        assert caught.value.code == 2
        assert "unknown word 'nonsense'" in str(caught.value)
    finally:
        await end_all([part])


async def test_a_part_is_in_a_session_of_its_own_and_ends_when_asked(tmp_path: Path) -> None:
    part = await start("waiter", ["account", "ada", "--data", str(tmp_path)], tmp_path / "log")
    assert os.getsid(part.process.pid) == part.process.pid
    os.kill(part.process.pid, signal.SIGSTOP)  # it cannot answer: the kill must follow
    end = time.monotonic() + PATIENCE_S
    while psutil.Process(part.process.pid).status() != psutil.STATUS_STOPPED:
        assert time.monotonic() < end
    await part.end(within=0.2)
    assert part.process.returncode == -signal.SIGKILL
