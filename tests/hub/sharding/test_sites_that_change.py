"""A site that changes its shard is one lead's at any time, and what it had under way goes on."""

from __future__ import annotations

import asyncio
import time

import pytest
import websockets
from patience import until_answered
from sqlalchemy import insert

from talaia.clock import SystemClock
from talaia.hub.sharding.elsewhere_guard import ElsewhereGuard
from talaia.hub.sharding.plan import MAIN
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.mission_tables import missions
from talaia.hub.store.missions.mission_store import MissionStore
from talaia.hub.store.tables import users
from talaia.model.missions.mission import Mission
from talaia.model.missions.mission_file import write_mission_json
from talaia.wire.browser import AlarmUpdate

from .two_shards import AGV, EAST, description_of

LOW = """
alarms:
  low: {name: Battery low, kind: limit, signal: power/voltage, below: 11, max_age: 3600}
"""
PATROL = write_mission_json(Mission(name="Patrol", steps=()))


async def move_to_main(shards) -> None:
    """Let the site be elsewhere, as the lead does that has copied it; both leads go on."""
    homes = HistoryHomes(shards.database)
    asked = await homes.ask_move(AGV, "own", own="own")
    assert await homes.switch_home(asked, led_by=EAST)


async def begin_both_anew(shards) -> None:
    for shard in (EAST, MAIN):
        await shards.end(shard)
    for shard in (EAST, MAIN):
        await shards.start(shard)


async def test_an_alarm_goes_on_at_the_lead_that_its_site_came_to(shards) -> None:
    gateway = await shards.gateway(AGV, LOW)
    await gateway.samples(("power/voltage", time.time_ns() // 1000, 10.0))
    page = await shards.east.page("operator")
    before = await page.hear(AlarmUpdate, lambda news: news.alarm == "low" and news.raised_us)
    await move_to_main(shards)
    await begin_both_anew(shards)
    page = await shards.main.page("operator")
    after = await page.hear(AlarmUpdate, lambda news: news.alarm == "low")
    assert (after.site, after.phase, after.raised_us) == (AGV, before.phase, before.raised_us)
    # Its gateway is let in there, and nowhere else.
    gateway = await shards.main.gateway(key=shards.keys[AGV])
    await gateway.hello(description_of(AGV) + LOW, site=AGV)
    with pytest.raises(websockets.InvalidStatus) as asked:
        await shards.east.gateway(key=shards.keys[AGV])
    assert asked.value.response.status_code == 503


async def test_a_mission_is_begun_by_whoever_leads_its_site_and_by_nobody_in_between(
    shards,
) -> None:
    store = MissionStore(shards.database, SystemClock())
    await shards.gateway(AGV)
    for shard in (EAST, MAIN):
        await shards.end(shard)
    await move_to_main(shards)
    async with shards.database.write() as connection:
        owner = await connection.scalar(users.select().with_only_columns(users.c.id))
        row = {"owner_id": owner, "text": PATROL, "due_us": 1, "name": "Patrol", "changed_us": 1}
        await connection.execute(insert(missions), {"site": AGV, **row})
    # The one that has let go begins nothing more.
    await shards.start(EAST)
    await shards.end(EAST)
    assert await store.list_runs(AGV, 9) == []
    await shards.start(MAIN)

    async def is_missed() -> bool:
        return [run.state for run in await store.list_runs(AGV, 9)] == ["missed"]

    await until_answered(is_missed)


async def test_a_lead_that_begins_waits_for_the_one_that_lets_go(shards) -> None:
    await shards.gateway(AGV)
    await move_to_main(shards)
    await shards.end(MAIN)
    starting = asyncio.create_task(shards.start(MAIN))
    await shards.end(EAST)
    await shards.start(EAST)
    await starting
    assert shards.main.hub.core.shard.has_site(AGV)
    assert not shards.east.hub.core.shard.has_site(AGV)


async def test_who_asks_the_wrong_lead_is_told_to_ask_again(shards) -> None:
    asked = []

    async def answer(scope, _receive, _send) -> None:
        asked.append(("answered", scope["path"]))

    async def refuse(scope, _receive, _send) -> None:
        asked.append(("refused", scope["path"]))

    guard = ElsewhereGuard(answer, shards.main.hub.core.shard, refuse)
    paths = ("/api/sites/agv/history", "/api/sites/lab", "/api/sites", "/api/sites/nowhere")
    for path in paths:
        await guard({"type": "http", "path": path}, None, None)
    # Of a site that nobody knows the main lead says so.
    assert [what for what, _ in asked] == ["refused", "answered", "answered", "answered"]
