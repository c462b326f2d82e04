"""Taking a right or a session away: open sockets follow at once, and a robot is let go.

What another process did (the command line, a second hub) is found by looking at the database
each half second; here that look is taken by hand where time would otherwise have to pass.
"""

from __future__ import annotations

import asyncio

import pytest
from sqlalchemy import delete, update

from talaia.clock import SECOND, HandClock
from talaia.hub.app import build_hub
from talaia.hub.settings import Settings
from talaia.hub.store.tables import role_permissions, roles, users
from talaia.wire import browser, frames
from talaia.wire.frames import LeaseOp

from ...everyone.world import World

# "Within a second", as it is promised.
PROMISED_S = 1.0
DRIVE = browser.PageDrive(
    site="agv", device="base", epoch=7, seq=1, tick=1, linear=0.5, angular=0.0
)


async def change(world, statement) -> None:
    """Change the database behind the hub's back, as another process does."""
    async with world.hub.hub.core.database.write() as connection:
        await connection.execute(statement)


async def _disabled(world) -> None:
    await change(world, update(users).where(users.c.name == "driver").values(disabled=True))


async def _removed(world) -> None:
    await change(world, delete(users).where(users.c.name == "driver"))


async def _demoted(world) -> None:
    await world.hub.people.set_role("driver", "guest")


async def _right_taken(world) -> None:
    async with world.hub.hub.core.database.read() as connection:
        role = (await connection.execute(roles.select().where(roles.c.name == "driver"))).one()
    await change(world, delete(role_permissions).where(role_permissions.c.role_id == role.id))


async def _sessions_ended(world) -> None:
    person = await world.hub.people.find_by_name("driver")
    await world.hub.hub.people.sessions.end_all(person.id)


TAKEN_AWAY = [_disabled, _removed, _demoted, _right_taken, _sessions_ended]


@pytest.mark.parametrize("take_away", TAKEN_AWAY, ids=lambda each: each.__name__.strip("_"))
async def test_sockets_and_pictures_end_and_the_robot_is_let_go_within_a_second(
    world, take_away
) -> None:
    viewer = await world.viewer("driver", "agv/base", "eye")
    page = await world.hub.page("driver")
    other = await world.hub.page("operator")
    gateway = world.gateways["agv"]
    await page.say(browser.PageLease(site="agv", device="base", op=LeaseOp.TAKE))
    ask = await gateway.hear(frames.LeaseRequest)
    await gateway.say(
        frames.LeaseState(device="base", session=ask.session, who=ask.who, epoch=7, remains_ms=3000)
    )
    await page.hear(browser.LeaseUpdate, lambda news: news.yours)
    await page.say(DRIVE)
    await gateway.hear(frames.DriveFrame)
    await take_away(world)
    async with asyncio.timeout(PROMISED_S):
        assert await viewer.closed() == 4401
        assert await page.closed() == 4401
        free = await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.FREE)
    assert (free.device, free.session) == ("base", ask.session)
    # Nothing but the farewell came after.
    ended = [at for at, each in enumerate(page.heard) if isinstance(each, browser.SessionEnded)]
    assert ended == [len(page.heard) - 1]
    # Others are not disturbed.
    await other.say(browser.PagePing(n=1, at_ms=0.0))
    await other.hear(browser.PagePong)


@pytest.mark.parametrize("take_away", TAKEN_AWAY, ids=lambda each: each.__name__.strip("_"))
async def test_the_next_request_has_the_rights_of_now(world, take_away) -> None:
    client = await world.client("driver")
    query = {"channel": "base/shut", "from_us": 0, "to_us": 1}
    assert (await client.get("/api/sites/agv/history", params=query)).status_code == 200
    await take_away(world)
    answer = await client.get("/api/sites/agv/history", params=query)
    assert answer.status_code in {401, 404}


def test_open_sockets_are_looked_at_more_than_once_a_second(tmp_path) -> None:
    assert Settings(data=tmp_path).check_s <= PROMISED_S / 2


@pytest.mark.parametrize("left", ["idle_s", "life_s"])
async def test_session_that_grows_too_old_ends_its_socket(hub_that_stores, left) -> None:
    running = hub_that_stores()
    clock = HandClock()
    running.hub = build_hub(running.settings, clock)
    running.people = running.hub.people.accounts
    async with running:
        world = World(running)
        try:
            await world.begin()
            page = await world.hub.page("driver")
            clock.advance(round(getattr(running.settings, left) * SECOND) + SECOND)
            async with asyncio.timeout(PROMISED_S):
                assert await page.closed() == 4401
        finally:
            await world.close()


async def test_socket_of_a_script_ends_with_its_token(world) -> None:
    page = await world.page("token")
    await page.hear(browser.Greeting)
    client = await world.client("operator")
    token = (await client.get("/api/me/tokens")).json()["tokens"][0]["id"]
    assert (await client.delete(f"/api/me/tokens/{token}")).status_code == 204
    async with asyncio.timeout(PROMISED_S):
        assert await page.closed() == 4401
    assert (await (await world.client("token")).get("/api/me")).status_code == 401


async def test_script_loses_what_its_person_loses(world) -> None:
    page = await world.page("token")
    await page.hear(browser.Greeting)
    query = {"channel": "base/shut", "from_us": 0, "to_us": 1}
    script = await world.client("token")
    assert (await script.get("/api/sites/agv/history", params=query)).status_code == 200
    await world.hub.people.set_role("operator", "guest")
    async with asyncio.timeout(PROMISED_S):
        assert await page.closed() == 4401
    assert (await script.get("/api/sites/agv/history", params=query)).status_code == 404


async def test_session_ended_at_one_door_is_dead_at_every_other(world) -> None:
    client = await world.client("driver")
    cookie = {"Cookie": f"talaia={client.cookies['talaia']}", "Origin": world.hub.origin}
    sockets = [await world.hub.dial("/ws", cookie) for _ in range(3)]
    sockets.append(await world.hub.dial("/ws/media?site=agv&stream=base/eye", cookie))
    assert (await client.post("/api/logout")).status_code == 204
    for socket in sockets:
        async with asyncio.timeout(PROMISED_S):
            await socket.wait_closed()
        assert socket.close_code == 4401
