"""The watchdog that an earlier run of a gateway left is ended, whatever the disk takes."""

from __future__ import annotations

import errno
import os
import socket
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from talaia.gateway.watchdog.feeding import dismiss_watchdog

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


@pytest.fixture
def lock(tmp_path: Path) -> Iterator[Path]:
    """That of a watchdog which runs, and whose gateway lives still."""
    path = tmp_path / "watchdog.lock"
    ours, theirs = socket.socketpair()
    words = [sys.executable, "-m", "talaia.gateway.watchdog.child", str(path)]
    with ours, theirs:
        assert subprocess.call(words, stdin=theirs.fileno()) == 0
        theirs.close()
        yield path
        dismiss_watchdog(path)


def test_a_watchdog_of_an_earlier_run_is_ended_once(lock: Path) -> None:
    assert dismiss_watchdog(lock)
    assert not dismiss_watchdog(lock)


@pytest.mark.parametrize("number", [errno.EROFS, errno.EIO, errno.ENOSPC])
def test_a_disk_that_takes_nothing_keeps_no_old_watchdog_that_closes_a_guarded_roof(
    number: int, lock: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = os.open

    def reads_only(path: str, flags: int, *more: int, **named: int) -> int:
        if flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            raise OSError(number, os.strerror(number), path)
        return real(path, flags, *more, **named)

    with monkeypatch.context() as patch:
        patch.setattr(os, "open", reads_only)
        assert dismiss_watchdog(lock)
    assert not dismiss_watchdog(lock)


def test_where_no_watchdog_was_there_is_none_to_end(tmp_path: Path) -> None:
    assert not dismiss_watchdog(tmp_path / "watchdog.lock")
