"""Hostile and stalled files as a description, or beside it: following goes on."""

from __future__ import annotations

import asyncio
import os
import threading
from typing import TYPE_CHECKING, cast

from talaia.gateway.accepted_changes import AcceptedChanges
from talaia.gateway.reload.description_file import DescriptionFile
from talaia.gateway.reload.requests import ChangeRequests
from talaia.wire.frames import ChangePhase, ChangeState

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.gateway.reload.apply import DescriptionReload


class StalledFile(DescriptionFile):
    """A file on a disk that can be told to answer no more."""

    def __init__(self, path: Path) -> None:
        """Read the file once."""
        super().__init__(path)
        self.answers = threading.Event()

    def read_change(self) -> str | None:
        self.answers.wait(30.0)
        return super().read_change()


class Events:
    def report_event(
        self, kind: str, message: str, *, device: str = "", who: str = "", good: bool = False
    ) -> None:
        pass


def requests_of(
    file: DescriptionFile, told: asyncio.Queue[ChangeState], slow_look_s: float = 30.0
) -> ChangeRequests:
    return ChangeRequests(
        file=file,
        accepts=AcceptedChanges.NO,
        key_hash="",
        data=file.path.parent,
        # No text that these tests write gets as far as that.
        reload=cast("DescriptionReload", None),
        send=told.put_nowait,
        events=Events(),
        on_disk=asyncio.to_thread,
        slow_look_s=slow_look_s,
    )


async def test_a_file_whose_disk_does_not_answer_is_told_of_once_and_followed_again(
    tmp_path: Path,
) -> None:
    path = tmp_path / "site.yaml"
    path.write_text("talaia: 1")
    file = StalledFile(path)
    told: asyncio.Queue[ChangeState] = asyncio.Queue()
    requests = requests_of(file, told, 0.2)
    following = asyncio.create_task(requests.watch_file())
    try:
        slow = await asyncio.wait_for(told.get(), 30.0)
        assert slow.phase is ChangePhase.REFUSED
        assert "has not been answered for 0.2 s" in str(slow)
        path.write_text("site: [")
        file.answers.set()
        # What was told once is taken back, and then the file is read as ever.
        assert (await asyncio.wait_for(told.get(), 30.0)).phase is ChangePhase.APPLIED
        wrong = await asyncio.wait_for(told.get(), 30.0)
        assert wrong.phase is ChangePhase.REFUSED
        assert "answered" not in str(wrong)
    finally:
        file.answers.set()
        following.cancel()


async def test_a_number_of_thousands_of_digits_is_refused_and_the_file_is_followed_on(
    tmp_path: Path,
) -> None:
    path = tmp_path / "site.yaml"
    path.write_text("talaia: 1")
    told: asyncio.Queue[ChangeState] = asyncio.Queue()
    following = asyncio.create_task(requests_of(DescriptionFile(path), told).watch_file())
    try:
        path.write_text("talaia: 0x" + "f" * 5_000)
        assert "64 bits" in str(await asyncio.wait_for(told.get(), 30.0))
        path.write_text("site: [")
        assert "64 bits" not in str(await asyncio.wait_for(told.get(), 30.0))
    finally:
        following.cancel()


async def test_a_pipe_beside_the_description_is_refused_and_holds_up_no_other_change(
    tmp_path: Path,
) -> None:
    path, pipe = tmp_path / "site.yaml", tmp_path / "commands.json"
    path.write_text("talaia: 1")
    told: asyncio.Queue[ChangeState] = asyncio.Queue()
    following = asyncio.create_task(requests_of(DescriptionFile(path), told).watch_file())
    try:
        os.mkfifo(pipe)
        path.write_text(
            "talaia: 1\nsite: a\nname: A\ndevices: {}\n"
            "connections: {old: {kind: process, file: commands.json}}\n"
        )
        assert "is not a file" in str(await asyncio.wait_for(told.get(), 30.0))
        path.write_text("site: [")
        assert "is not a file" not in str(await asyncio.wait_for(told.get(), 30.0))
    finally:
        following.cancel()
        # Whoever waits for a writer has one now: a test that fails ends, too.
        os.close(os.open(pipe, os.O_RDWR | os.O_NONBLOCK))
