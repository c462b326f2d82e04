"""Files to take away: every sample, once, in order of time, whatever the store holds it in."""

import asyncio
import csv
import io
import os
import subprocess
import sys
import tempfile
import tracemalloc
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from many_examples import examples

from talaia.hub.history.blocks.block import BlockSamples
from talaia.hub.history.errors import HistoryBusy
from talaia.hub.history.queries.csv_file import write_csv
from talaia.hub.history.queries.export_formats import ExportColumn, FileForm
from talaia.hub.history.queries.files import write_file
from talaia.hub.history.queries.sample_stream import SampleChunk
from talaia.hub.history.queries.wide_table import Rows, join_channels
from talaia.hub.history.queries.window import FARTHEST_US
from talaia.wire.columns import Columns

from ..conftest import SMALL, opened
from ..samples import ALL, batch
from ..test_store import START, moment, number

SECOND = 1_000_000
TESTS = Path(__file__).parents[3]
ENVIRONMENT = {**os.environ, "PYTHONPATH": f"{TESTS.parent / 'src'}{os.pathsep}{TESTS}"}
SPEED, MODE, STATE = (
    ExportColumn("a/speed", "m/s"),
    ExportColumn("a/mode", text=True),
    ExportColumn("a/gear", states=("park", "drive")),
)
ADDRESSES = [column.address for column in (SPEED, MODE, STATE)]


async def taken(store, columns, form=FileForm.ARROW, window=ALL, width=0):
    return b"".join(
        [
            piece
            async for piece in store.export_samples("agv", columns, *window, form=form, width=width)
        ]
    )


def table_of(form, body):
    if form is FileForm.PARQUET:
        return pa.parquet.read_table(io.BytesIO(body))
    return pa.ipc.open_stream(body).read_all()


@pytest.mark.parametrize("form", [FileForm.ARROW, FileForm.PARQUET])
async def test_a_file_holds_every_sample_with_its_kind(url, form) -> None:
    rows = [(0, START + i, i / 7) for i in range(400)]
    rows += [(1, START + 2 * i, f"line {i}") for i in range(100)]
    rows += [(2, START + 3 * i, float(i % 2)) for i in range(100)]
    rows += [(0, START + 9, float("nan")), (2, START, 7.0)]
    async with opened(url) as store:
        for at in range(0, len(rows), 50):
            await store.append_samples(
                "agv", "b1", at, addresses=ADDRESSES, columns=batch(rows[at : at + 50])
            )
        table = table_of(form, await taken(store, [SPEED, MODE, STATE], form))
    found = table.to_pydict()
    time_us = table.column("time").cast(pa.int64()).to_pylist()
    assert time_us == sorted(time_us)
    assert table.num_rows == 402
    # Two samples at one time have a row each; what was not said is null, what was NaN is NaN.
    at = [i for i, time in enumerate(time_us) if time == START + 9]
    speeds = [found["a/speed"][i] for i in at]
    assert speeds[0] == 9 / 7
    assert np.isnan(speeds[1])
    assert found["a/mode"][1] is None
    assert found["a/mode"][-1] is None
    at = [i for i, time in enumerate(time_us) if time == START]
    assert [found["a/gear"][i] for i in at] == ["park", "7"]
    assert [word for word in found["a/mode"] if word] == [f"line {i}" for i in range(100)]
    assert table.schema.field("a/speed").metadata == {b"unit": b"m/s"}


async def test_no_cell_of_a_csv_is_a_formula(url) -> None:
    evil = ExportColumn("=cmd()/x", "m", text=True)
    texts = ['=HYPERLINK("http://x")', "+1", "-1", "@x", "\t=1", "\r=1", 'say "hi", twice', "fine"]
    async with opened(url) as store:
        rows = [(0, START + i, text) for i, text in enumerate(texts)]
        rows += [(1, START + i, -1.5) for i in range(8)]
        await store.append_samples(
            "agv", "b1", 0, addresses=["=cmd()/x", "a/speed"], columns=batch(rows)
        )
        body = await taken(store, [evil, SPEED], FileForm.CSV)
    table = list(csv.reader(io.StringIO(body.decode(), newline="")))
    assert table[0] == ["time (UTC)", "'=cmd()/x (m)", "a/speed (m/s)"]
    assert [row[1] for row in table[1:]] == [*("'" + text for text in texts[:6]), *texts[6:]]
    assert {row[2] for row in table[1:]} == {"-1.5"}
    assert table[1][0] == "2023-11-14 22:13:20.000000Z"


def test_a_csv_has_the_same_cells_with_arrow_and_without() -> None:
    numbers = [0.0, -0.0, 1 / 3, 5e-324, 1.7e308, 123_456_789.0, 2.0**53, float("nan"), -1.5]
    texts = ["=1", "a,b", 'say "hi"', "é\nü", "fine"]
    gears = [0.0, 1.0, 7.0]
    time_us = START + np.arange(9) * SECOND // 7
    places = [np.arange(9), np.array([0, 2, 3, 5, 8]), np.array([1, 2, 8])]
    parts = [
        BlockSamples(time_us, np.array(numbers), {}),
        BlockSamples(time_us[places[1]], np.zeros(5), dict(enumerate(texts))),
        BlockSamples(time_us[places[2]], np.array(gears), {}),
    ]
    rows = Rows(time_us, places, parts)
    columns = [SPEED, MODE, STATE]
    by_arrow, own = (
        list(csv.reader(io.StringIO(b"".join(pieces).decode(), newline="")))
        for pieces in (
            write_file(FileForm.CSV, columns, iter([rows])),
            write_csv(columns, iter([rows])),
        )
    )
    # Numbers may be written otherwise, if they are the same.
    assert [(row[0], *row[2:]) for row in own] == [(row[0], *row[2:]) for row in by_arrow]
    read = [[str(float(row[1])) for row in table[1:]] for table in (by_arrow, own)]
    assert read[0] == read[1] == [str(number) for number in numbers]


# In a process of its own, where Python finds no pyarrow.
WITHOUT = """
import asyncio, sys
sys.modules["pyarrow"] = None
from hub.history.conftest import opened
from hub.history.samples import ALL, batch
from talaia.hub.errors import LibraryMissing
from talaia.hub.history.queries.export_formats import ExportColumn, FileForm

async def main():
    async with opened(sys.argv[1]) as store:
        rows = batch([(0, at, at / 2) for at in range(3)])
        await store.append_samples("agv", "b1", 0, addresses=["a/x"], columns=rows)
        for form in FileForm:
            try:
                found = store.export_samples("agv", [ExportColumn("a/x")], *ALL, form=form)
                async for piece in found:
                    print(piece.decode().split())
            except LibraryMissing as error:
                print(error)

asyncio.run(main())
"""


def test_a_hub_without_arrow_gives_csv_and_says_what_brings_the_rest(tmp_path) -> None:
    words = [sys.executable, "-c", WITHOUT, f"sqlite:///{tmp_path}/h.db"]
    done = subprocess.run(words, env=ENVIRONMENT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    *csv_pieces, parquet, arrow = done.stdout.splitlines()
    assert csv_pieces[0] == "['time', '(UTC),a/x']"
    assert "00:00:00.000002Z,1" in csv_pieces[-1]
    assert parquet == arrow
    assert parquet == (
        "Parquet and Arrow files need the Python package 'pyarrow', which is not installed at the "
        "hub; run there: pip install 'talaia[arrow]'"
    )


row = st.tuples(st.integers(0, 1), moment, number)


@settings(
    max_examples=examples(10, many=300), deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
@given(st.lists(row, min_size=1, max_size=40))
def test_an_export_holds_what_went_in_for_any_order_of_times(some) -> None:
    rows = [(channel, time + i, value) for i in range(8) for channel, time, value in some]

    async def run(url) -> None:
        async with opened(url, SMALL._replace(block=8, recent=4)) as store:
            for at in range(0, len(rows), 20):
                await store.append_samples(
                    "agv", "b1", at, addresses=["a/x", "a/y"], columns=batch(rows[at : at + 20])
                )
            columns = [ExportColumn("a/x"), ExportColumn("a/y")]
            table = table_of(FileForm.ARROW, await taken(store, columns))
        time_us = table.column("time").cast(pa.int64()).to_numpy()
        assert (np.diff(time_us) >= 0).all()
        for channel, name in enumerate(("a/x", "a/y")):
            column = table.column(name)
            there = np.array([cell.is_valid for cell in column])
            times = time_us[there].tolist() if there.size else []
            values = [cell.as_py() for cell in column if cell.is_valid]
            # Equal times keep the order in which they came.
            wanted = sorted(((t, v) for c, t, v in rows if c == channel), key=lambda r: r[0])
            assert times == [t for t, _ in wanted]
            np.testing.assert_array_equal(values, [v for _, v in wanted])

    with tempfile.TemporaryDirectory() as folder:
        asyncio.run(run(f"sqlite:///{Path(folder) / 'h.db'}"))


async def test_a_long_export_holds_every_sample_of_its_blocks_and_of_memory_once(url) -> None:
    """More blocks than are listed together, and after them what is in none yet."""
    count = 32 * 300 + 7
    time_us = START + np.arange(count) * SECOND
    async with opened(url) as store:
        for at in range(0, count, 400):
            part = time_us[at : at + 400]
            # Two signals of one message, and one that is read in between.
            channel = np.tile(np.array([0, 2], np.uint16), part.size)
            both = Columns(channel, np.repeat(part, 2), np.repeat(part % 977 / 8, 2), {})
            await store.append_samples("agv", "b1", 2 * at, addresses=ADDRESSES, columns=both)
            own = Columns(np.ones(part.size, np.uint16), part + 1, part % 31 / 2.0, {})
            await store.append_samples("agv", "b2", at, addresses=ADDRESSES, columns=own)
        columns = [ExportColumn(address) for address in ADDRESSES]
        table = table_of(FileForm.PARQUET, await taken(store, columns, FileForm.PARQUET))
    found = table.column("time").cast(pa.int64()).to_numpy()
    np.testing.assert_array_equal(found, np.sort(np.concatenate([time_us, time_us + 1])))
    for address, times, values in (
        (ADDRESSES[0], time_us, time_us % 977 / 8),
        (ADDRESSES[1], time_us + 1, time_us % 31 / 2.0),
        (ADDRESSES[2], time_us, time_us % 977 / 8),
    ):
        column = table.column(address)
        np.testing.assert_array_equal(found[np.asarray(column.is_valid())], times)
        np.testing.assert_array_equal(column.drop_null().to_numpy(), values)


times = st.lists(st.integers(0, 30), min_size=1, max_size=12).map(sorted)


@given(st.lists(times, max_size=3), st.integers(0, 3), st.integers(1, 6))
def test_channels_are_joined_by_time_wherever_their_times_are_in_memory(some, same, half) -> None:
    # Two of one size that begin at the same place; and the very array again.
    long = np.arange(2 * half)
    arrays = [long[:half], long[::2], *(np.array(own, np.int64) for own in some)]
    arrays += [arrays[-1]] * same
    flows = [iter([SampleChunk(BlockSamples(own, own / 4, {}), FARTHEST_US + 1)]) for own in arrays]
    joined = list(join_channels(flows))
    for at, own in enumerate(arrays):
        found = np.concatenate([rows.time_us[rows.places[at]] for rows in joined])
        assert found.tolist() == own.tolist()
        assert [v for rows in joined for v in rows.parts[at].value] == (own / 4).tolist()
    most = {time: max(list(own).count(time) for own in arrays) for own in arrays for time in own}
    assert sum(rows.time_us.size for rows in joined) == sum(most.values())


async def test_what_is_shown_can_be_taken_away_too(url) -> None:
    value = np.sin(np.arange(3_000) / 100)
    columns = Columns(np.zeros(3_000, np.uint16), START + np.arange(3_000) * SECOND, value, {})
    window = (START, START + 3_000 * SECOND)
    async with opened(url) as store:
        await store.append_samples("agv", "b1", 0, addresses=["a/speed"], columns=columns)
        table = table_of(FileForm.ARROW, await taken(store, [SPEED], window=window, width=50))
        (series,) = await store.read_series("agv", ["a/speed"], *window, width=50)
    assert table.column("time").cast(pa.int64()).to_pylist() == series.time_us.tolist()
    assert table.column("a/speed").to_pylist() == series.value.tolist()


async def test_an_export_takes_no_more_memory_for_more_samples(tmp_path) -> None:
    """Peaks of numpy and Python; what Arrow holds is its last piece."""
    peaks = []
    async with opened(f"sqlite:///{tmp_path}/h.db", SMALL._replace(block=4096)) as store:
        for size in (300_000, 1_500_000):
            first = 0 if size == 300_000 else 300_000
            for at in range(first, size, 50_000):
                time_us = START + np.arange(at, at + 50_000) * 10_000
                columns = Columns(np.zeros(50_000, np.uint16), time_us, time_us % 977 / 7, {})
                await store.append_samples("agv", "b1", at, addresses=["a/speed"], columns=columns)
            for form in FileForm:
                tracemalloc.start()
                total = 0
                async for piece in store.export_samples("agv", [SPEED], *ALL, form=form):
                    total += len(piece)
                peaks.append(tracemalloc.get_traced_memory()[1])
                tracemalloc.stop()
                assert total > size
    small, large = peaks[:3], peaks[3:]
    assert all(more < 1.3 * less + 1e6 for less, more in zip(small, large, strict=True)), peaks


async def test_too_many_exports_at_once_are_told_to_wait(url) -> None:
    async with opened(url) as store:
        await store.append_samples(
            "agv", "b1", 0, addresses=["a/speed"], columns=batch([(0, START, 1.0)])
        )
        going = [store.export_samples("agv", [SPEED], *ALL, form=FileForm.CSV) for _ in range(5)]
        for each in going[:4]:
            await anext(each)
        with pytest.raises(HistoryBusy, match="try again"):
            await anext(going[4])
        for each in going[:4]:
            await each.aclose()
        assert b"a/speed" in await taken(store, [SPEED], FileForm.CSV)


async def test_a_state_is_drawn_as_what_held_last(url) -> None:
    """Least and greatest alone would show state 3 for all the time after its burst."""
    value = np.zeros(20_000)
    value[1_000:1_003] = [3, 2, 1]
    value[1_003:] = 1
    time_us = START + np.arange(20_000) * SECOND // 100
    async with opened(url, SMALL._replace(block=512, recent=512)) as store:
        for at in range(0, 20_000, 500):
            part = slice(at, at + 500)
            columns = Columns(np.zeros(500, np.uint16), time_us[part], value[part], {})
            await store.append_samples("agv", "b1", at, addresses=["a/gear"], columns=columns)
        for width in (1, 4, 15):
            (series,) = await store.read_series(
                "agv", ["a/gear"], START, int(time_us[-1]), width=width, steps={"a/gear"}
            )
            assert series.time_us.size <= 2 * width
            assert series.value[-1] == 1
            assert 3 in series.value or 0 in series.value
        one = series.time_us < START + 11 * SECOND
        assert 3 in series.value[one]


def read_columns(body):
    """Give each column's values and how a Parquet file holds it."""
    file = pa.parquet.ParquetFile(io.BytesIO(body))
    group = file.metadata.row_group(0)
    held = {group.column(at).path_in_schema: group.column(at).encodings for at in range(3)}
    return file.read(), held


def test_numbers_that_repeat_are_listed_and_others_are_not_in_a_parquet_file() -> None:
    size = 200_000
    chance = np.random.default_rng(3)
    few, many = np.round(chance.normal(size=size), 2), chance.normal(size=size)
    few[5] = float("nan")
    time_us = START + np.arange(size) * 10_000
    pieces = [
        Rows(time_us[part], [np.arange(size // 2)] * 2, [
            BlockSamples(time_us[part], column[part], {}) for column in (few, many)
        ])
        for part in (slice(0, size // 2), slice(size // 2, size))
    ]  # fmt: skip
    columns = [ExportColumn("a/few.x"), ExportColumn("a/many")]
    body = b"".join(write_file(FileForm.PARQUET, columns, iter(pieces)))
    table, held = read_columns(body)
    assert table.column("time").cast(pa.int64()).to_numpy().tolist() == time_us.tolist()
    np.testing.assert_array_equal(table.column("a/few.x").to_numpy(), few)
    assert table.column("a/few.x").null_count == 0
    np.testing.assert_array_equal(table.column("a/many").to_numpy(), many)
    assert "RLE_DICTIONARY" in held["a/few.x"]
    assert "RLE_DICTIONARY" not in held["a/many"]
    assert "DELTA_BINARY_PACKED" in held["time"]
    # Two bytes or less for a number of three digits, and little more than eight for any.
    assert len(body) < 12 * size


def test_of_a_channel_that_says_little_the_first_numbers_tell_whether_they_repeat() -> None:
    """They are spread over many rows, of which the first have none."""
    count = 300_000
    places = np.arange(100_000, count, 4)
    few = BlockSamples(places, (places // 4 % 10) / 10, {})
    other = BlockSamples(np.arange(count), np.random.default_rng(1).normal(size=count), {})
    rows = Rows(np.arange(count), [places, np.arange(count)], [few, other])
    columns = [ExportColumn("a/few"), ExportColumn("a/noise")]
    body = b"".join(write_file(FileForm.PARQUET, columns, iter([rows])))
    group = pa.parquet.read_metadata(io.BytesIO(body)).row_group(0)
    assert "RLE_DICTIONARY" in group.column(1).encodings
    assert "RLE_DICTIONARY" not in group.column(2).encodings
    table = pa.parquet.read_table(io.BytesIO(body))
    assert table.column("a/few").drop_null().to_pylist() == few.value.tolist()


def test_a_parquet_file_of_nothing_has_its_columns() -> None:
    body = b"".join(write_file(FileForm.PARQUET, [SPEED, MODE], iter([])))
    table = table_of(FileForm.PARQUET, body)
    assert table.num_rows == 0
    assert table.column_names == ["time", "a/speed", "a/mode"]


def test_of_a_parquet_file_what_is_noise_is_not_compressed_and_what_is_not_comes_back() -> None:
    count = 20_000
    noise = np.random.default_rng(1).random(count)
    counter = np.arange(count) * 1.0
    time_us = START + np.arange(count) * SECOND
    whole = np.arange(count)
    parts = [BlockSamples(time_us, value, {}) for value in (noise, counter)]
    columns = [ExportColumn("a/noise"), ExportColumn("a/counter")]
    rows = Rows(time_us, [whole, whole], parts)
    body = b"".join(write_file(FileForm.PARQUET, columns, iter([rows])))
    group = pa.parquet.ParquetFile(io.BytesIO(body)).metadata.row_group(0)
    kinds = {group.column(at).path_in_schema: group.column(at) for at in range(3)}
    assert kinds["a/noise"].compression == "UNCOMPRESSED"
    assert kinds["a/counter"].compression == "ZSTD"
    # Readers pass over parts of a file by their times.
    assert kinds["time"].statistics.has_min_max
    table = table_of(FileForm.PARQUET, body)
    assert table.column("a/noise").to_numpy().tobytes() == noise.tobytes()
    assert table.column("a/counter").to_numpy().tobytes() == counter.tobytes()
