"""Pictures of gateways are read by another process, which a hostile one may end or hold up."""

from __future__ import annotations

import asyncio
import io
import struct
import time

import numpy as np
import pytest
import simplejpeg
from PIL import Image

from talaia.hub.live.pictures.jpeg_decoder import Unreadable
from talaia.hub.live.pictures.jpeg_process import JpegProcess

RED = simplejpeg.encode_jpeg(
    np.full((48, 64, 3), (255, 0, 0), np.uint8), quality=95, colorspace="RGB"
)


@pytest.fixture
async def process():
    reader = JpegProcess(longest_s=5.0)
    yield reader
    await reader.close()


def slow_picture(scans: int = 4_000) -> bytes:
    """Give a progressive picture of 4000 × 2300 px whose last scan comes again and again."""
    out = io.BytesIO()
    Image.new("L", (4000, 2300), 128).save(out, "JPEG", progressive=True)
    data = out.getvalue()
    last = data.rindex(b"\xff\xda")
    # Of the last scan with the tables before it: from the table that it needs on.
    table = data.rindex(b"\xff\xc4", 0, last)
    return data[:-2] + data[table:-2] * scans + b"\xff\xd9"


async def test_picture_comes_back_as_its_pixels(process) -> None:
    rgb = await process.read_pixels("agv", RED)
    assert rgb.shape == (48, 64, 3)
    assert abs(rgb.astype(int) - (255, 0, 0)).max() < 8


async def test_picture_that_is_none_or_claims_to_be_huge_is_refused_and_the_next_is_read(
    process,
) -> None:
    at = RED.index(b"\xff\xc0") + 5
    huge = RED[:at] + struct.pack(">HH", 60_000, 60_000) + RED[at + 4 :]
    with pytest.raises(Unreadable, match="60000 × 60000"):
        await process.read_pixels("agv", huge)
    with pytest.raises(Unreadable):
        await process.read_pixels("agv", b"\xff\xd8 no picture")
    assert (await process.read_pixels("agv", RED)).shape == (48, 64, 3)


async def test_picture_that_is_read_for_minutes_costs_its_own_time_and_no_more() -> None:
    hostile = slow_picture()
    reader = JpegProcess(longest_s=1.0)
    began = time.process_time()
    with pytest.raises(Unreadable, match="longer"):
        await reader.read_pixels("thief", hostile)
    # The hub itself has read none of it.
    assert time.process_time() - began < 0.5
    assert len(hostile) < 4 * 1024 * 1024
    good = JpegProcess()
    both = await asyncio.gather(good.read_pixels("agv", RED), good.read_pixels("other", RED))
    assert [rgb.shape for rgb in both] == [(48, 64, 3)] * 2
    await reader.close()
    await good.close()
