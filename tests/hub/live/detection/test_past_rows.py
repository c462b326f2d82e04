"""Stored samples come as rows on a common step, each of them as it came."""

from __future__ import annotations

import numpy as np
import pytest

from talaia.hub.history.queries.series import Series
from talaia.hub.live.detection.past_rows import read_past_rows

pytestmark = pytest.mark.pure

SECOND = 1_000_000


class StoredSamples:
    """Answers `History.read_series` of arrays; of too many samples it gives every second one."""

    def __init__(self, **columns) -> None:
        """Keep the times and the values of each address."""
        self.columns = columns
        self.asked = []

    async def read_series(self, _site, addresses, from_us, to_us, *, width):
        self.asked.append((from_us, to_us))
        found = []
        for address in addresses:
            times, values = (np.asarray(part) for part in self.columns[address])
            there = (times >= from_us) & (times <= to_us)
            times, values = times[there], values[there]
            exact = len(times) <= 2 * width
            thin = slice(None, None, 1 if exact else 2)
            found.append(Series(address, times[thin], values[thin], {}, exact=exact, gaps=[]))
        return found


async def rows_of(history, addresses, to_us: int) -> tuple[list[int], np.ndarray]:
    parts = [
        part
        async for part in read_past_rows(
            history, "agv", addresses, from_us=0, to_us=to_us, step_us=SECOND
        )
    ]
    assert parts[-1].past_us == to_us
    times = np.concatenate([part.time_us for part in parts])
    return times.tolist(), np.concatenate([part.values for part in parts])


async def test_the_last_value_of_a_step_counts_and_where_none_came_there_is_none():
    history = StoredSamples(
        a=([0, 400_000, 900_000, 3 * SECOND], [1.0, 2.0, 3.0, 4.0]),
        b=([100_000, 3 * SECOND + 5], [7.0, np.nan]),
    )
    times, values = await rows_of(history, ["a", "b"], 10 * SECOND)
    assert times == [0, 3 * SECOND]
    np.testing.assert_equal(values, [[3.0, 7.0], [4.0, np.nan]])


async def test_samples_of_a_fast_signal_are_read_in_shorter_pieces_and_none_is_thinned():
    # A hundred a second for ten minutes: three times as many as are read at once.
    times = np.arange(60_000) * 10_000
    history = StoredSamples(fast=(times, np.arange(60_000.0)))
    steps, values = await rows_of(history, ["fast"], 600 * SECOND)
    assert steps == [at * SECOND for at in range(600)]
    assert values[:, 0].tolist() == [at * 100 + 99.0 for at in range(600)]
    assert len(history.asked) > 3
