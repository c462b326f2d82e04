"""Many channels in one question: the same as each asked for by itself."""

import random

import numpy as np

from ..conftest import opened
from ..samples import ALL, batch, rows_of

SECOND = 1_000_000
START = 1_700_000_000 * SECOND
ADDRESSES = ["base/speed", "base/pose.x", "base/mode", "base/late"]


def uneven_rows(count: int) -> list[tuple[int, int, float | str]]:
    """Give samples of channels that begin, end and come at different times, some of them late."""
    chance = random.Random(4)  # noqa: S311 - samples
    rows: list[tuple[int, int, float | str]] = []
    for at in range(count):
        rows.append((0, START + at * SECOND, chance.random()))
        if at % 3 == 0:
            rows.append((1, START + at * SECOND + 500, chance.random()))
        if at % 20 == 0:
            rows.append((2, START + at * SECOND, f"mode {at}"))
        if at > count / 2:
            # From before all that its channel had said until then, too.
            rows.append((3, START + chance.randrange(count) * SECOND, float(at)))
    return rows


async def test_channels_asked_for_together_give_what_each_gives_alone(url) -> None:
    async with opened(url) as store:
        rows = uneven_rows(900)
        for first in range(0, len(rows), 150):
            some = batch(rows[first : first + 150])
            await store.append_samples("agv", "b1", first, addresses=ADDRESSES, columns=some)
        asked = [*ADDRESSES, "no/such"]
        for low, high, width in (
            (START + 100 * SECOND, START + 130 * SECOND, 500),
            (START + 450 * SECOND, START + 900 * SECOND, 40),
            (START - SECOND, START, 10),
            (*ALL, 20),
        ):
            together = await store.read_series("agv", asked, low, high, width=width)
            for address, series in zip(asked, together, strict=True):
                (alone,) = await store.read_series("agv", [address], low, high, width=width)
                assert rows_of(series) == rows_of(alone)
                assert (series.exact, series.gaps) == (alone.exact, alone.gaps)
                assert (np.diff(series.time_us) >= 0).all()


async def test_last_values_before_a_moment_are_found_together_as_alone(url) -> None:
    async with opened(url) as store:
        rows = uneven_rows(900)
        await store.append_samples("agv", "b1", 0, addresses=ADDRESSES, columns=batch(rows))
        for seconds in (-1, 0, 33, 450, 899):
            to_us = START + seconds * SECOND
            together = await store.last_readings("agv", ADDRESSES, to_us)
            alone: dict[str, object] = {}
            for address in ADDRESSES:
                alone |= await store.last_readings("agv", [address], to_us)
            assert str(together) == str(alone)
            newest = max((us for _, us, _ in rows if us <= to_us), default=None)
            assert max((found[0] for found in together.values()), default=None) == newest
