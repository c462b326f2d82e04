"""A program that is killed in the middle of a load has lost nothing that it said was stored."""

import asyncio
import os
import signal
import subprocess
import sys

import numpy as np
import pytest

from .conftest import opened

WRITER = """
import asyncio, sys
import numpy as np
from talaia.clock import SystemClock
from talaia.hub.history.limits import Limits
from talaia.hub.history.store import HistoryStore
from talaia.wire.columns import Columns

async def main(url):
    limits = Limits(block=64, recent=32, journal=300, delete=4, linger_s=0.0)
    store = HistoryStore(url, SystemClock(), limits)
    await store.create_tables()
    await store.open()
    first = 0
    while True:
        index = np.arange(first, first + 50)
        columns = Columns((index % 3).astype(np.uint16), index * 10, index.astype(float), {})
        await store.append("agv", "b", first, ["a/x", "a/y", "a/z"], columns)
        first += 50
        print(first, flush=True)

asyncio.run(main(sys.argv[1]))
"""


@pytest.mark.parametrize("after", [1, 7, 60])
def test_kill_minus_nine_loses_nothing_that_was_acknowledged(url, after) -> None:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(
        [sys.executable, "-c", WRITER, url], stdout=subprocess.PIPE, text=True, env=environment
    ) as writer:
        said = [int(writer.stdout.readline()) for _ in range(after)]
        os.kill(writer.pid, signal.SIGKILL)
        said += [int(line) for line in writer.stdout if line.endswith("\n")]

    async def look() -> None:
        async with opened(url) as store:
            stored = await store.stored_below("agv", "b")
            # What was under way may be there too, all of it or nothing.
            assert stored - said[-1] in (0, 50)
            series = await store.read("agv", ["a/x", "a/y", "a/z"], 0, 10**12, stored)
            for channel, each in enumerate(series):
                index = np.arange(channel, stored, 3)
                np.testing.assert_array_equal(each.time_us, index * 10)
                np.testing.assert_array_equal(each.value, index)

    asyncio.run(look())
