"""Rows of the journal that were made one: nothing is lost and nothing twice, whenever it ends."""

import shutil

import numpy as np
import pytest
import sqlalchemy as sa

from talaia.hub.history.blocks.journal import JOINED, read_row, write_row
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.writing.merged_rows import RowMerger
from talaia.hub.store import history_tables as tables
from talaia.wire.columns import Columns

from ..conftest import opened
from ..samples import ALL

CHANNELS, SIZE = 1_100, 1_000
ADDRESSES = tuple(f"base/s{at}" for at in range(CHANNELS))
START = 1_700_000_000_000_000
# Blocks of a few samples, and a journal that is emptied at once: each way that a row can go.
SMALL_BLOCKS = HistoryLimits(
    block=12, largest=12, smallest=12, journal=0, delete=4, linger_s=0.0, show_s=0.0, tidy_s=0.0
)


def columns_from(first: int, size: int = SIZE) -> Columns:
    """Make a batch of the sample numbers from ``first`` on, which are their values, too."""
    index = np.arange(first, first + size)
    texts = {at: f"text {first + at}" for at in range(0, size, 97)}
    value = index.astype(float)
    value[list(texts)] = np.nan
    return Columns((index % CHANNELS).astype(np.uint16), START + index * 1_000, value, texts)


async def numbers_in(store) -> list[float]:
    """Give the numbers of all samples that are stored, of each channel in order of time."""
    found = []
    for first in range(0, CHANNELS, 100):
        some = ADDRESSES[first : first + 100]
        for series in await store.read_series("agv", some, *ALL, width=100_000):
            words = {at: float(text.split()[1]) for at, text in series.texts.items()}
            found += [words.get(at, value) for at, value in enumerate(series.value.tolist())]
            assert (np.diff(series.time_us) > 0).all()
    return sorted(found)


def journal_of(url) -> list[tuple[int, int]]:
    """List version and samples of the journal's rows."""
    engine = sa.create_engine(url)
    with engine.begin() as connection:
        rows = connection.execute(sa.select(tables.hot).order_by(tables.hot.c.id)).all()
    engine.dispose()
    return [(row.body[0], row.samples) for row in rows]


@pytest.mark.parametrize("limits", [HistoryLimits(show_s=0.0), SMALL_BLOCKS])
async def test_whenever_a_hub_is_killed_each_sample_is_there_once(tmp_path, limits) -> None:
    path = tmp_path / "h.db"
    merged = 0
    async with opened(f"sqlite:///{path}", limits) as store:
        for at in range(64):
            await store.append_samples(
                "agv", "b", at * SIZE, addresses=ADDRESSES, columns=columns_from(at * SIZE)
            )
            if at % 8 == 7:
                # What a killed hub leaves: the file and its log as they are just then.
                for file in tmp_path.glob("h.db*"):
                    shutil.copy(file, tmp_path / f"killed-{file.name}")
                left = f"sqlite:///{tmp_path}/killed-h.db"
                merged = max(merged, sum(kind == JOINED for kind, _ in journal_of(left)))
                async with opened(left, limits) as again:
                    assert await again.stored_below("agv", "b") == (at + 1) * SIZE
                    assert await numbers_in(again) == list(range((at + 1) * SIZE))
                for file in tmp_path.glob("killed-*"):
                    file.unlink()
        assert await numbers_in(store) == list(range(64 * SIZE))
    assert merged


async def test_a_server_keeps_the_rows_of_its_journal_as_they_came(url) -> None:
    async with opened(url, HistoryLimits(show_s=0.0)) as store:
        for at in range(40):
            await store.append_samples(
                "agv", "b", at * SIZE, addresses=ADDRESSES, columns=columns_from(at * SIZE)
            )
        assert await store.stored_below("agv", "b") == 40 * SIZE
    kinds = {kind for kind, _ in journal_of(url)}
    assert (JOINED in kinds) == url.startswith("sqlite")


def row_of(number, first, *, boot=1, size=SIZE):
    return {
        "id": number, "boot_id": boot, "catalogue_id": 1, "first_seq": first, "samples": size,
        "body": write_row(columns_from(first, size)),
    }  # fmt: skip


@pytest.mark.pure
def test_only_rows_that_follow_each_other_between_two_deals_are_one() -> None:
    rows = [row_of(at + 1, at * SIZE) for at in range(40)]

    def first_merged(some, deals=lambda at: 0):
        merger = RowMerger()
        for at, row in enumerate(some):
            merger.add_rows([row], deals(at))
        return merger.next_row(deals(len(some) - 1))

    whole = first_merged(rows)
    assert whole.first == 1
    assert (whole.row["id"], whole.row["first_seq"], whole.row["samples"]) == (40, 0, 40_000)
    came = np.concatenate([columns_from(at * SIZE).value for at in range(40)])
    read = read_row(whole.row["body"]).value
    assert np.array_equal(np.sort(read), np.sort(came), equal_nan=True)
    # One of another boot, one that is missing, a deal: what was before is left as it is.
    other = [*rows[:20], row_of(21, 20_000, boot=2), *rows[21:]]
    assert first_merged(other) is None
    assert first_merged(rows[:3] + rows[4:]).first == 5
    assert first_merged(rows, lambda at: int(at >= 20)) is None
