"""Hundreds and thousands of gateways that are there: what they cost their hub while they send."""

from __future__ import annotations

import asyncio
import time
from typing import NamedTuple

import httpx
import numpy as np
import psutil
from link import crowd
from stack import Stack, context


class BearCost(NamedTuple):
    """What many gateways that are there cost their hub.

    Attributes:
        running: of a core, and ``each_us`` for each of them in a second (µs).
        memory_kib: of the hub, for each of them (KiB).
        asked_ms: how long somebody waits for an answer of the hub meanwhile (ms each).
        sent: samples that they sent a second, beside those that they would with time enough.

    """

    running: float
    each_us: float
    memory_kib: float
    asked_ms: np.ndarray
    sent: float


async def bear(here: Stack, count: int, signals: int, seconds: float) -> BearCost:
    """Let so many gateways be there, with so many signals at 1 Hz each, or none."""
    hub = psutil.Process(here.hub.process.pid)

    def used_s() -> float:
        return sum(hub.cpu_times()[:2])

    await asyncio.sleep(3)
    before, began, memory = used_s(), time.monotonic(), hub.memory_info().rss
    await asyncio.sleep(8)
    alone = (used_s() - before) / (time.monotonic() - began)
    async with crowd(here, count, signals) as many, httpx.AsyncClient(
        base_url=here.origin, verify=context(here), trust_env=False
    ) as person:  # fmt: skip
        await many.all_back(900)
        await many.all_kept(300)
        await asyncio.sleep(5)
        waits, sent = [], await many.samples_sent()
        before, began = used_s(), time.monotonic()
        while time.monotonic() - began < seconds:
            asked = time.monotonic()
            (await person.get("/api/health")).raise_for_status()
            waits.append(1e3 * (time.monotonic() - asked))
            await asyncio.sleep(0.1)
        passed_s = time.monotonic() - began
        running = (used_s() - before) / passed_s
        sent = await many.samples_sent() - sent
        grown = hub.memory_info().rss - memory
    return BearCost(
        running, 1e6 * (running - alone) / count, grown / count / 1024, np.array(waits),
        sent / passed_s / (count * signals) if signals else 1.0,
    )  # fmt: skip
