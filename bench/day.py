"""A day of several signals, written straight into a hub's history before the hub starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from talaia.clock import SystemClock
from talaia.hub.history.store import HistoryStore
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from talaia.hub.settings import Settings

DAY_S = 86_400
DAY_US = DAY_S * 1_000_000
AT_ONCE = 20_000


def yesterday_us() -> int:
    """Give the start of yesterday (µs, UTC)."""
    now_us = SystemClock().wall_ns() // 1000
    return now_us // DAY_US * DAY_US - DAY_US


async def fill_yesterday(settings: Settings, signals: int, rate: int) -> None:
    """Store yesterday's samples of ``base/s0`` and on, at ``rate`` Hz each: noise on a drift."""
    start, count = yesterday_us(), DAY_S * rate * signals
    addresses = tuple(f"base/s{each}" for each in range(signals))
    random = np.random.default_rng(1)
    store = HistoryStore(settings.url, SystemClock())
    await store.open()
    for first in range(0, count, AT_ONCE):
        index = np.arange(first, min(first + AT_ONCE, count))
        at, channel = index // signals, index % signals
        time_us = start + at * (1_000_000 // rate) + random.integers(0, 300, index.size)
        value = np.round(np.sin(at / 3000 + channel) + random.normal(0, 0.1, index.size), 3)
        columns = Columns(channel.astype(np.uint16), time_us, value, {})
        await store.append_samples("bench", "day", first, addresses=addresses, columns=columns)
    await store.close()
