"""Fifty people at once: each is signed in as themselves and gets their own data, all the while."""

from __future__ import annotations

import asyncio

from sqlalchemy import insert

from talaia.hub.store.tables import permissions, role_permissions, roles
from talaia.model.yaml_text.load import load_site
from talaia.wire import browser, frames
from talaia.wire.columns import unpack_columns

from ...everyone.world import NOW, World

PEOPLE = 50
ROUNDS = 5
_DEVICES = "".join(
    f"  d{at}:\n    name: Device {at}\n    signals:\n      value:\n        name: Value\n"
    f"        source: {{topic: /d{at}, type: std_msgs/msg/Float64, field: data}}\n"
    f"    commands: {{turn: {{name: Turn, target: /t{at}, type: std_srvs/srv/Trigger}}}}\n"
    for at in range(PEOPLE)
)
SITE = f"talaia: 1\nsite: agv\nname: Many\nros2: {{}}\ndevices:\n{_DEVICES}"


async def _populate(world: World) -> None:
    """Make fifty people, each with a role that holds one device."""
    kept = (await world.hub.people.find_by_name("admin")).password_hash
    async with world.hub.hub.core.database.write() as connection:
        for at in range(PEOPLE):
            role = await connection.execute(insert(roles).values(name=f"r{at}", seeded=False))
            permission = await connection.execute(
                insert(permissions).values(right_name="use", site="agv", device=f"d{at}")
            )
            await connection.execute(
                insert(role_permissions).values(
                    role_id=role.inserted_primary_key[0],
                    permission_id=permission.inserted_primary_key[0],
                )
            )
    for at in range(PEOPLE):
        await world.hub.people.add_person(f"p{at}", kept, f"r{at}")


async def test_fifty_people_work_side_by_side(world) -> None:
    await _populate(world)
    await world.gateways["agv"].close()
    gateway = await world.connect("agv", SITE)
    assert len(load_site(SITE).channels()) == PEOPLE

    clients = [await world.client(f"p{at}") for at in range(PEOPLE)]

    async def work(at: int) -> None:
        client = clients[at]
        cookie = {"Cookie": f"talaia={client.cookies['talaia']}", "Origin": world.hub.origin}
        page = world.hub.peer(await world.hub.dial("/ws", cookie))
        assert (await page.hear(browser.Greeting)).who == f"p{at}"
        everything = [f"d{each}/value" for each in range(PEOPLE)]
        ask = browser.Subscribe(sub=1, site="agv", channels=everything, every_ms=0)
        await page.say(ask)
        refused = (await page.hear(browser.Subscribed)).refused
        assert set(refused) == set(everything) - {f"d{at}/value"}
        own = [at * 1000.0 + turn for turn in range(ROUNDS)]
        ready.release()
        got: list[float] = []
        # One that is behind gets fewer: the first, the least, the greatest and the last of them.
        while not got or got[-1] != own[-1]:
            values = await page.hear(browser.Values)
            batch = unpack_columns(values)
            got += batch.value.tolist()
        # All the while other things are asked, as pages do.
        assert (await client.get("/api/me")).json()["name"] == f"p{at}"
        site = (await client.get("/api/sites/agv")).json()
        assert [device["id"] for device in site["devices"]] == [f"d{at}"]
        await page.say(
            browser.PageCommand(site="agv", device=f"d{at}", command="turn", id=f"command {at}")
        )
        news = await page.hear(browser.CommandUpdate)
        assert (news.id, news.who) == (f"command {at}", f"p{at}")
        assert {each.id for each in page.heard if isinstance(each, browser.CommandUpdate)} <= {
            f"command {at}"
        }
        assert set(got) <= set(own)
        assert got == sorted(got)

    ready = asyncio.Semaphore(0)
    async with asyncio.TaskGroup() as group:
        answering = group.create_task(_answer(gateway))
        working = [group.create_task(work(at)) for at in range(PEOPLE)]
        for _ in range(PEOPLE):
            await ready.acquire()
        for turn in range(ROUNDS):
            rows = [(f"d{at}/value", NOW + turn, at * 1000.0 + turn) for at in range(PEOPLE)]
            await gateway.samples(*rows)
            await gateway.hear(frames.Ack, lambda ack: ack.below == gateway.sequence)
        await asyncio.wait(working)
        answering.cancel()
    assert all(task.done() for task in working)


async def _answer(gateway) -> None:
    """Do at once what is asked, as a gateway that has nothing else to do."""
    while True:
        ask = await gateway.hear(frames.CommandRequest)
        await gateway.say(
            frames.CommandState(
                id=ask.id,
                device=ask.device,
                command=ask.command,
                phase=frames.CommandPhase.SUCCEEDED,
                who=ask.who,
            )
        )
