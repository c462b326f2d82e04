"""While one site's recording is slow to be taken, those of the others come in."""

from __future__ import annotations

import asyncio
import hashlib

from talaia.hub.files.local_folder import LocalFolder
from talaia.hub.live.files.recordings import Recordings
from talaia.wire.frames import FileOffer

BODY = b"recording"


class SlowRows:
    """A list of recordings; that of one site answers when it is released."""

    def __init__(self, slow: str) -> None:  # noqa: D107
        self.slow = slow
        self.asked, self.released = asyncio.Event(), asyncio.Event()
        self.rows = {}

    async def find_recording(self, site, name):
        if site == self.slow:
            self.asked.set()
            await self.released.wait()
        return self.rows.get((site, name))

    async def save_recording(self, recorded) -> None:
        self.rows[recorded.site, recorded.id] = recorded


async def test_recording_that_is_slow_to_be_taken_holds_up_no_other_site(tmp_path) -> None:
    rows = SlowRows("thief")
    recordings = Recordings(
        rows=rows, store=LocalFolder(tmp_path), audit=None, data=tmp_path, most_bytes=0
    )
    offer = FileOffer(
        id="20260101T120000Z-abcdef",
        size=len(BODY),
        digest=hashlib.sha256(BODY).hexdigest(),
        begin_us=1,
        end_us=2,
    )
    slow = asyncio.create_task(recordings.answer_offer("thief", offer))
    await rows.asked.wait()
    # The suite's own limit fails this one where the other site's would stand behind it.
    async with asyncio.timeout(20):
        assert (await recordings.answer_offer("agv", offer)).have == 0
    rows.released.set()
    assert (await slow).refused == ""
