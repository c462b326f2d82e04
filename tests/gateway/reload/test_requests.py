"""A description's file whose disk does not answer for a while."""

from __future__ import annotations

import asyncio
import threading
from typing import TYPE_CHECKING, cast

from talaia.gateway.change_policy import AcceptedChanges
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


async def test_a_file_whose_disk_does_not_answer_is_told_of_once_and_followed_again(
    tmp_path: Path,
) -> None:
    path = tmp_path / "site.yaml"
    path.write_text("talaia: 1")
    file = StalledFile(path)
    told: asyncio.Queue[ChangeState] = asyncio.Queue()
    requests = ChangeRequests(
        file=file,
        accepts=AcceptedChanges.NO,
        key_hash="",
        data=tmp_path,
        # No text that this test writes gets as far as that.
        reload=cast("DescriptionReload", None),
        send=told.put_nowait,
        events=Events(),
        on_disk=asyncio.to_thread,
        slow_look_s=0.2,
    )
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
