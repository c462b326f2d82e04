"""A site that is to be sealed as a whole: nothing of it may stay outside of blocks unseen."""

import asyncio

from talaia.hub.history.writing.writer_jobs import SealSite

from ..conftest import SMALL, opened
from ..samples import batch


async def test_samples_of_the_same_commit_are_not_taken_for_sealed(url) -> None:
    """What came just before writes were held is in one commit with the question."""
    async with opened(url, SMALL._replace(linger_s=0.05)) as store:
        await store.append_samples("agv", "b", 0, addresses=["a/x"], columns=batch([(0, 1, 2.0)]))
        await store.transfer.seal_all("agv")
        _, left = await asyncio.gather(
            store.append_samples("agv", "b", 1, addresses=["a/x"], columns=batch([(0, 2, 3.0)])),
            store._writer.complete_job(SealSite("agv")),
        )
        assert left == 1
        await store.transfer.seal_all("agv")
        blocks = await store.transfer.list_blocks("agv")
        assert [(block.first_us, block.last_us) for block in blocks] == [(1, 1), (2, 2)]
