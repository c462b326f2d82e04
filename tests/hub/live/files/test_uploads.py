"""What one site's gateway sends holds up no other site's files, and does not fill the disk."""

from __future__ import annotations

import asyncio
import hashlib
import os
import time
from zlib import crc32

import pytest
from hypothesis import given, strategies as st

from talaia.hub.errors import StoreDown
from talaia.hub.live.files.disk_share import DiskUse, may_take
from talaia.hub.live.files.standstill import STANDSTILL_S
from talaia.hub.live.files.uploads import Uploads
from talaia.wire.frames import ArchiveOffer, FilePiece

BODY = b"picture"


def offer(size: int = len(BODY)) -> ArchiveOffer:
    return ArchiveOffer(
        id="0" * 32, kind="fits", size=size, digest=hashlib.sha256(BODY).hexdigest(), time_us=1
    )


PIECE = FilePiece(id="0" * 32, at=0, check=crc32(BODY), data=BODY)


class Keeper:
    """Keeps files; those of one site take until `released`."""

    def __init__(self, slow: str) -> None:  # noqa: D107
        self.slow = slow
        self.began, self.released = asyncio.Event(), asyncio.Event()
        self.kept: list[str] = []

    async def __call__(self, site, offer, path) -> None:
        del offer
        if site == self.slow:
            self.began.set()
            await self.released.wait()
        path.unlink()
        self.kept.append(site)


async def everybody(site: str, size: int) -> bool:
    del site, size
    return True


async def nobody(site: str, size: int) -> bool:
    del site, size
    return False


async def bring(uploads: Uploads, site: str):
    await uploads.answer_offer(site, offer())
    return await uploads.append_piece(site, offer(), PIECE)


async def test_file_that_is_looked_at_for_long_holds_up_no_other_site(tmp_path) -> None:
    keeper = Keeper(slow="thief")
    uploads = Uploads(tmp_path, {"fits": keeper}, most_bytes=1_000, share=everybody)
    slow = asyncio.create_task(bring(uploads, "thief"))
    await keeper.began.wait()
    # The suite's own limit fails this one where the other site's would stand behind it.
    async with asyncio.timeout(20):
        assert (await bring(uploads, "agv")).done
    assert keeper.kept == ["agv"]
    keeper.released.set()
    assert (await slow).done


async def test_site_without_a_share_of_the_disk_waits(tmp_path) -> None:
    uploads = Uploads(tmp_path, {"fits": Keeper("")}, most_bytes=1_000, share=nobody)
    with pytest.raises(StoreDown, match="sites that hold less"):
        await bring(uploads, "thief")
    assert not list(tmp_path.glob("*/*.part"))


async def test_upload_that_stands_still_ends_though_its_gateway_never_comes_again(tmp_path) -> None:
    uploads = Uploads(tmp_path, {"fits": Keeper("")}, most_bytes=1_000, share=everybody)
    for site in ("gone", "slow"):
        await uploads.answer_offer(site, offer(size=500))
        await uploads.append_piece(site, offer(size=500), PIECE)
    old = time.time() - STANDSTILL_S - 60
    os.utime(tmp_path / "gone" / f"{'0' * 32}.part", (old, old))
    await uploads.end_standing_uploads()
    assert [path.parent.name for path in tmp_path.glob("*/*.part")] == ["slow"]


DISK = st.integers(1, 10**15)


@given(total=DISK, used=st.floats(0, 1), held=st.floats(0, 1), sites=st.integers(1, 50))
def test_a_site_that_holds_its_share_leaves_the_last_tenth_to_the_others(
    total: int, used: float, held: float, sites: int
) -> None:
    free = int(total * (1 - used))
    use = DiskUse(total, free, held=int(total * held), sites=sites)
    if may_take(use, 1):
        # There is room for all, or this one has less than is its own.
        assert free - 1 >= total * 0.1 or use.held + 1 <= total / sites
    elif sites == 1:
        assert use.held + 1 > total


def test_who_filled_the_disk_waits_and_who_did_not_goes_on() -> None:
    full = DiskUse(total=1_000, free=90, held=800, sites=3)
    assert not may_take(full, 10)
    assert may_take(full._replace(held=20), 10)
    # One site alone has all of it.
    assert may_take(full._replace(sites=1), 10)
