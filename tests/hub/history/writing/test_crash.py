"""A program that dies at any point loses nothing that it said was stored, and doubles nothing."""

import asyncio
import itertools
import os
import signal
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest
import sqlalchemy as sa
from hypothesis import HealthCheck, given, settings, strategies as st
from many_examples import examples

from talaia.hub.history.errors import HistoryError

from ..conftest import SMALL, opened
from ..samples import ALL, batch, rows_of, wanted

WRITER = """
import asyncio, sys
import numpy as np
from talaia.clock import SystemClock
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.store import HistoryStore
from talaia.wire.columns import Columns

async def main(url):
    limits = HistoryLimits(block=64, largest=64, recent=32, journal=300, delete=4, linger_s=0.0)
    store = HistoryStore(url, SystemClock(), limits)
    await store.create_tables()
    await store.open()
    first = 0
    while True:
        index = np.arange(first, first + 50)
        columns = Columns((index % 3).astype(np.uint16), index * 10, index.astype(float), {})
        addresses = ["a/x", "a/y", "a/z"]
        await store.append_samples("agv", "b", first, addresses=addresses, columns=columns)
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
            series = await store.read_series("agv", ["a/x", "a/y", "a/z"], 0, 10**12, width=stored)
            for channel, each in enumerate(series):
                index = np.arange(channel, stored, 3)
                np.testing.assert_array_equal(each.time_us, index * 10)
                np.testing.assert_array_equal(each.value, index)

    asyncio.run(look())


# Nearly every commit seals, saves a slow channel or empties the journal.
TINY = SMALL._replace(block=8, largest=8, recent=4, journal=8, journal_rows=6, delete=1)


class Died(Exception):
    """The program's end, as far as the database can tell."""


@contextmanager
def dying(store, statement):
    """Let the writing connection be lost at a statement of the next commit, counted from 1.

    With 0 it is lost after the commit, before anybody was told of it; with None it is not lost.
    """
    engine, seen = store._writing, itertools.count(1)

    def before(*_arguments) -> None:
        if next(seen) == statement:
            raise Died

    commit = engine.dialect.do_commit

    def committed(connection) -> None:
        commit(connection)
        raise Died

    sa.event.listen(engine, "before_cursor_execute", before)
    if statement == 0:
        engine.dialect.do_commit = committed
    try:
        yield
    finally:
        sa.event.remove(engine, "before_cursor_execute", before)
        engine.dialect.do_commit = commit


number = st.one_of(st.floats(-10, 10), st.sampled_from([float("nan"), float("inf"), -0.0]))
moment = st.one_of(st.integers(10**15, 10**15 + 50), st.integers(0, 2**52))
row = st.one_of(
    st.tuples(st.integers(0, 1), moment, number),
    st.tuples(st.just(2), moment, st.text(max_size=5)),
)
# A stretch of the boot's samples by position and length, where the program dies over it, and
# whether readings for SQL are written afterwards, which looks at what is planned to be sealed.
stretch = st.tuples(
    st.integers(0, 299),
    st.integers(1, 120),
    st.one_of(st.none(), st.integers(0, 12)),
    st.booleans(),
)


def test_no_crash_point_loses_or_doubles_a_sample_in_any_order(url) -> None:
    """Each example is a site of its own; what was not acknowledged is sent again."""
    numbers = itertools.count()
    addresses = ["base/x", "base/y", "base/word"]

    @settings(
        max_examples=examples(3, many=80), deadline=None, suppress_health_check=list(HealthCheck)
    )
    @given(st.lists(row, min_size=1, max_size=30), st.lists(stretch, min_size=1, max_size=10))
    def one(some, stretches) -> None:
        again = (some * 300)[:300]
        rows = [(c, at + i // len(some), value) for i, (c, at, value) in enumerate(again)]
        site = f"site{next(numbers)}"

        async def holds(store, *possible) -> None:
            found = await store.read_series(site, addresses, *ALL, width=1000)
            said = [rows_of(series) for series in found]
            assert said in [
                [wanted([rows[i] for i in sorted(these)], channel) for channel in range(3)]
                for these in possible
            ]

        async def run() -> None:
            stored, waiting = set(), list(stretches)
            while waiting:
                async with opened(url, TINY) as store:
                    await holds(store, stored)
                    died = False
                    while waiting and not died:
                        first, length, statement, show = waiting[0]
                        part = rows[first : first + length]
                        sent = stored | set(range(first, first + len(part)))
                        try:
                            with dying(store, statement):
                                await store.append_samples(
                                    site, "b", first, addresses=addresses, columns=batch(part)
                                )
                        except HistoryError:
                            died = True
                            waiting[0] = (first, length, None, show)
                        else:
                            waiting.pop(0)
                            stored = sent
                            if show:
                                await store.write_plain_rows()
                if died:
                    async with opened(url, TINY) as store:
                        # All of the batch, or nothing of it.
                        await holds(store, stored, sent)
                        await store.append_samples(
                            site, "b", first, addresses=addresses, columns=batch(part)
                        )
                        stored = sent
            async with opened(url, TINY) as store:
                await holds(store, stored)
                below = next(i for i in range(301) if i not in stored)
                assert await store.stored_below(site, "b") == below

        asyncio.run(run())

    one()
