"""A program that runs wild is held back, and slows nobody else down."""

from __future__ import annotations

import asyncio
import time
from collections import Counter

import pytest
import websockets

from talaia.clock import MS, SECOND
from talaia.hub.api.rate_limits import HISTORY, MOST_SOCKETS
from talaia.hub.auth.rate_limiter import RateLimiter


def test_pace_allows_a_burst_and_then_so_many_a_second() -> None:
    pace, now = RateLimiter(burst=5, per_s=2.0), 10 * SECOND
    assert [pace.request_turn("ada", now) for _ in range(5)] == [0] * 5
    assert pace.request_turn("ada", now) == SECOND // 2
    # Whoever is refused and asks again at once has no longer to wait for it.
    assert pace.request_turn("ada", now) == SECOND // 2
    assert pace.request_turn("eve", now) == 0
    assert pace.request_turn("ada", now + 500 * MS) == 0
    assert pace.request_turn("ada", now + 500 * MS) > 0
    assert [pace.request_turn("ada", now + 60 * SECOND) for _ in range(5)] == [0] * 5


def test_pace_forgets_the_oldest_of_very_many() -> None:
    pace = RateLimiter(burst=1, per_s=0.001)
    for number in range(20_000):
        pace.request_turn(number, number)
    assert len(pace._due_ns) == 10_000


async def test_flood_of_history_questions_is_held_back_and_others_are_not(
    hub, gateway, monkeypatch: pytest.MonkeyPatch
) -> None:
    # For the limit time stands still: a busy machine may answer no faster than it refills.
    request_turn, begun = RateLimiter.request_turn, time.monotonic_ns()
    monkeypatch.setattr(
        RateLimiter, "request_turn", lambda self, key, _now_ns: request_turn(self, key, begun)
    )
    wild, other = await hub.client("operator"), await hub.client("admin")
    query = {"channel": "base/speed", "from_us": 0, "to_us": 1}
    answers = []
    while not answers or answers[-1].status_code != 429:
        asked = (wild.get("/api/sites/agv/history", params=query) for _ in range(100))
        answers += await asyncio.gather(*asked)
        assert len(answers) < 20 * HISTORY.burst, "the flood was never held back"
    statuses = Counter(answer.status_code for answer in answers)
    assert statuses[200] >= HISTORY.burst
    assert statuses.keys() == {200, 429}
    assert int(answers[-1].headers["retry-after"]) >= 1
    assert (await other.get("/api/sites/agv/history", params=query)).status_code == 200
    # What else the person does still works.
    assert (await wild.get("/api/sites")).status_code == 200


async def test_one_person_cannot_open_sockets_without_end(hub) -> None:
    cookie = await hub.cookie("operator")
    headers = {"Cookie": cookie, "Origin": hub.origin}
    opened = [await hub.dial("/ws", headers) for _ in range(MOST_SOCKETS)]
    try:
        with pytest.raises(websockets.InvalidStatus) as refused:
            await hub.dial("/ws", headers)
        assert refused.value.response.status_code == 429
        await hub.page("admin")
    finally:
        await asyncio.gather(*(each.close() for each in opened))
    # Those that are closed do not count any more.
    await hub.page("operator")


async def test_verifying_and_exporting_the_whole_log_is_not_done_in_a_loop(hub) -> None:
    admin = await hub.client("admin")
    statuses = [(await admin.get("/api/audit/verify")).status_code for _ in range(11)]
    assert statuses == [200] * 10 + [429]
