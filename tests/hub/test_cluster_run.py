"""Several hubs on one database: whatever happens to one, what was acknowledged is there, once."""

import asyncio
import os
import signal
import sys
from contextlib import suppress

import pytest
import websockets
from async_program import start_program
from patience import PATIENCE_S, until_answered
from ports import free_port

from talaia.wire import frames
from talaia.wire.browser import LeaseUpdate, PageDrive, PageLease, PageStop, Subscribe, Values
from talaia.wire.frames import Ack, LeaseOp

from .databases import empty_database
from .several_hubs import Hubs, Nats, two_hubs

ROW_US = 1_700_000_000_000_000
STEP = 50
SITE = """
talaia: 1
site: agv
name: Shed
connections: {shell: {kind: process, poll: 1, timeout: 2}}
devices:
  base:
    name: Base
    connection: shell
    signals:
      speed: {name: Speed, unit: m/s, source: {run: echo 1, pattern: '([0-9.]+)'}}
"""


@pytest.fixture
def mariadb_url():
    # On PostgreSQL three hubs go through all of this in `tests/system/cluster`.
    with empty_database("mariadb") as url:
        yield url


@pytest.fixture
def postgresql_url():
    with empty_database("postgresql") as url:
        yield url


async def send_rows(gateway, first: int, end: int) -> None:
    """Send samples whose values are their numbers, until the link is lost."""
    with suppress(websockets.ConnectionClosed):
        for at in range(first, end, STEP):
            rows = [("power/voltage", ROW_US + n * 1000, float(n)) for n in range(at, at + STEP)]
            await gateway.samples(*rows, first=at)


def acknowledged(gateway) -> int:
    return max((x.below for x in gateway.heard if isinstance(x, Ack)), default=0)


async def is_online(hubs, hub) -> bool:
    return (await hubs.get(hub, "/api/sites/agv")).json().get("online") is True


async def came_in_at(hubs, hub, name: str) -> bool:
    """Ask whether a gateway came in at the hub of this name."""
    told = (await hubs.get(hub, "/api/hubs")).json()["hubs"]
    return any(one["name"] == name and one["gateways"] == 1 for one in told)


async def came_in(hubs, asked):
    """Wait until a gateway came in at a hub, and give that hub."""
    there = []

    async def anywhere() -> bool:
        there[:] = [hub for hub in hubs.all if await came_in_at(hubs, asked, hub.name)]
        return bool(there)

    await until_answered(anywhere)
    return there[0]


async def has_roles(hubs, hub, roles: dict[str, str]) -> bool:
    """Ask a hub whether the hubs that are there stand like this."""
    told = (await hubs.get(hub, "/api/hubs")).json()
    return {one["name"]: one["role"] for one in told["hubs"] if one["role"] != "gone"} == roles


async def stored_values(hubs, hub, end: int) -> list[float]:
    answer = await hubs.get(
        hub,
        "/api/sites/agv/history",
        channel="power/voltage",
        from_us=ROW_US,
        to_us=ROW_US + end * 1000,
        width=10_000,
    )
    assert answer.status_code == 200, answer.text
    return answer.json()["series"][0]["v"]


@pytest.mark.timeout(400)
async def test_whoever_comes_to_another_hub_sees_drives_and_stops_as_at_the_one_that_leads(
    tmp_path, mariadb_url
) -> None:
    async with two_hubs(mariadb_url, tmp_path) as (hubs, lead, other):
        gateway = await hubs.gateway(other)
        await gateway.hello()
        page = await hubs.page(other)
        await page.say(Subscribe(sub=1, site="agv", channels=["power/voltage"], every_ms=0))
        await gateway.samples(("power/voltage", ROW_US, 12.5))
        await page.hear(Values, lambda told: told.sub == 1)
        await page.say(PageLease(site="agv", device="base", op=LeaseOp.TAKE))
        asked = await gateway.hear(frames.LeaseRequest)
        held = frames.LeaseState(
            device="base", session=asked.session, who=asked.who, epoch=7, remains_ms=10_000
        )
        await gateway.say(held)
        await page.hear(LeaseUpdate, lambda lease: lease.yours)
        drive = PageDrive(
            site="agv", device="base", epoch=7, seq=1, tick=1, linear=0.3, angular=0.0
        )
        await page.say(drive)
        assert (await gateway.hear(frames.DriveFrame)).linear == 0.3
        # A page at the hub that leads sees the same, and stops the same robot.
        near = await hubs.page(lead)
        assert (await near.hear(LeaseUpdate, lambda lease: lease.holder)).holder == "ada"
        await page.say(PageStop(site="agv", device="base", id="s1"))
        assert (await gateway.hear(frames.StopRequest)).id == "s1"
        # The page goes: what it held is free at once.
        await page.close()
        freed = await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.FREE)
        assert freed.session == asked.session
        # All of that takes less than a beat on a fast machine, before the lead has heard west.
        await until_answered(lambda: has_roles(hubs, other, {"east": "leads", "west": "waits"}))
        told = (await hubs.get(other, "/api/hubs")).json()["hubs"]
        assert {hub["name"]: hub["gateways"] for hub in told}["east"] == 0


@pytest.mark.timeout(400)
async def test_a_hub_that_leads_is_killed_and_nothing_acknowledged_is_lost_or_twice(
    tmp_path, mariadb_url
) -> None:
    async with two_hubs(mariadb_url, tmp_path) as (hubs, lead, other):
        # One comes to the hub that is killed; what it had said is sent again to the other one.
        gateway = await hubs.gateway(lead)
        await gateway.hello()
        loading = asyncio.create_task(send_rows(gateway, 0, 10_000))
        await gateway.hear(Ack, lambda ack: ack.below >= 1_000)
        lead.signal(signal.SIGKILL)
        await asyncio.gather(loading, gateway.closed())
        sure = max(1_000, acknowledged(gateway))
        # Before the other one knows: it is let in as soon as that one leads.
        again = await hubs.gateway(other)
        await other.until_leads()
        stored = (await again.hello()).acked
        assert stored >= sure
        # What was under way, and some that is there already.
        begin = max(0, stored // STEP - 10) * STEP
        end = begin + 40 * STEP
        await send_rows(again, begin, end)
        await again.hear(Ack, lambda ack: ack.below >= end)
        assert await stored_values(hubs, other, end - 1) == [float(n) for n in range(end)]
        assert (await hubs.get(other, "/api/audit/verify")).json()["ok"]


@pytest.mark.timeout(400)
async def test_a_hub_that_stands_still_is_replaced_and_writes_nothing_when_it_wakes(
    tmp_path, mariadb_url
) -> None:
    async with two_hubs(mariadb_url, tmp_path) as (hubs, lead, other):
        gateway = await hubs.gateway(lead)
        await gateway.hello()
        await send_rows(gateway, 0, 500)
        await gateway.hear(Ack, lambda ack: ack.below >= 500)
        lead.signal(signal.SIGSTOP)
        # These lie in the sockets of the hub that stands still, and are read when it wakes.
        await send_rows(gateway, 500, 1_000)
        await other.until_leads()
        again = await hubs.gateway(other)
        assert (await again.hello()).acked == 500
        await send_rows(again, 500, 2_000)
        await again.hear(Ack, lambda ack: ack.below >= 2_000)
        lead.signal(signal.SIGCONT)
        # It lets its gateways go, and is one of the others again.
        await gateway.closed()
        await lead.until_ready()
        await until_answered(lambda: has_roles(hubs, lead, {"east": "waits", "west": "leads"}))
        values = await stored_values(hubs, lead, 2_000 - 1)
        assert values == [float(n) for n in range(2_000)]
        assert (await hubs.get(other, "/api/audit/verify")).json()["ok"]


@pytest.mark.timeout(400)
async def test_without_nats_gateways_go_on_and_pages_of_other_hubs_are_told(
    tmp_path, postgresql_url
) -> None:
    async with two_hubs(postgresql_url, tmp_path) as (hubs, lead, other):
        gateway = await hubs.gateway(lead)
        await gateway.hello()
        page, near = await hubs.page(other), await hubs.page(lead)
        await hubs.nats.kill()
        # 1012: the page connects again, and says meanwhile that it is not connected.
        assert await page.closed() == 1012
        assert not await other.is_ready()
        assert await lead.is_ready()
        await near.say(PageStop(site="agv", device="base", id="s1"))
        assert (await gateway.hear(frames.StopRequest)).id == "s1"
        await send_rows(gateway, 0, 500)
        await gateway.hear(Ack, lambda ack: ack.below >= 500)
        await hubs.nats.start()
        await other.until_ready()
        back = await hubs.page(other)
        await back.say(PageStop(site="agv", device="base", id="s2"))
        assert (await gateway.hear(frames.StopRequest)).id == "s2"


@pytest.mark.timeout(400)
async def test_a_hub_that_is_asked_to_end_hands_over_and_a_session_ended_there_ends_everywhere(
    tmp_path, postgresql_url
) -> None:
    async with two_hubs(postgresql_url, tmp_path) as (hubs, lead, other):
        page = await hubs.page(other)
        assert await lead.end() == 0
        assert await page.closed() in {1012, 1006}
        await other.until_leads()
        third = await hubs.add("south")
        await third.until_ready()
        # Through the third: the session is the database's, and so is its end.
        page = await hubs.page(third)
        async with other.client() as client:
            headers = {"Cookie": hubs.cookie}
            answer = await client.post("/api/logout", json={}, headers=headers)
            assert answer.status_code < 300, answer.text
        assert await page.closed() == 4401
        assert (await hubs.get(third, "/api/me")).status_code == 401


@pytest.mark.timeout(400)
async def test_a_gateway_that_knows_several_hubs_finds_one_that_is_there(
    tmp_path, postgresql_url
) -> None:
    async with two_hubs(postgresql_url, tmp_path) as (hubs, lead, other):
        (tmp_path / "agv.yaml").write_text(SITE)
        (tmp_path / "gateway-key").write_text(hubs.gateway_key)
        # At the first nobody listens; the second hands through to the one that leads.
        addresses = f"ws://127.0.0.1:{free_port()},{other.link},{lead.link}"
        gateway = await start_program(
            *("-m", "talaia", "gateway", str(tmp_path / "agv.yaml"), "--hub", addresses),
            *("--key-file", str(tmp_path / "gateway-key"), "--allow-plain"),
            *("--data", str(tmp_path / "gateway")),
        )
        try:
            # Usually at the second; where the machine stood still meanwhile, at the third.
            ours = await came_in(hubs, lead)
            left = lead if ours is other else other
            await until_answered(lambda: is_online(hubs, left))
            # The hub that it came to dies: it goes to the next one by itself.
            ours.signal(signal.SIGKILL)
            await left.until_leads()
            await until_answered(lambda: came_in_at(hubs, left, left.name))
            await until_answered(lambda: is_online(hubs, left))
        finally:
            gateway.terminate()
            await gateway.wait()


@pytest.mark.timeout(400)
async def test_a_hub_with_another_key_for_secrets_does_not_lead(tmp_path, postgresql_url) -> None:
    async with two_hubs(postgresql_url, tmp_path) as (hubs, lead, other):
        stranger = await hubs.add("stranger", same_key=False)
        assert not await stranger.is_ready()
        lead.signal(signal.SIGKILL)
        other.signal(signal.SIGKILL)
        # It takes the lead, finds the others' key written down, and ends.
        assert await asyncio.wait_for(stranger.process.wait(), PATIENCE_S) == 2


@pytest.mark.timeout(400)
async def test_a_hub_that_is_alone_is_refused_on_the_database_of_others(
    tmp_path, postgresql_url
) -> None:
    async with Nats() as nats, Hubs(postgresql_url, nats, tmp_path) as hubs:
        lead = await hubs.add("east")
        await lead.until_leads()
        process = await start_program(
            *("-m", "talaia", "hub", "--plain", "--port", "0", "--data", str(tmp_path / "alone")),
            with_errors=True,
            TALAIA_DATABASE_URL=postgresql_url,
        )
        _, errors = await asyncio.wait_for(process.communicate(), PATIENCE_S)
        assert process.returncode == 2
        assert "another hub uses this database; end it, or start both with --cluster" in (
            errors.decode()
        )
        await until_answered(lead.is_ready)


async def test_a_hub_that_is_alone_imports_nothing_of_several() -> None:
    said = "import sys, talaia.hub.run; print(*sys.modules)"
    # Not from the fork server, which has everything imported already.
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-c", said),
        env={**os.environ, "PYTHONPATH": "src"},
        stdout=asyncio.subprocess.PIPE,
    )
    output, _ = await asyncio.wait_for(process.communicate(), PATIENCE_S)
    imported = set(output.decode().split())
    assert "talaia.hub.run" in imported
    assert not {
        name
        for name in imported
        if name.split(".")[0] == "nats"
        or name in {"talaia.hub.cluster_run", "talaia.hub.cluster.member"}
    }


@pytest.mark.parametrize(
    ("words", "url", "said"),
    [
        (["--cluster", "nats://127.0.0.1:1"], "", "needs a database that several hubs can use"),
        (["--cluster", "http://127.0.0.1"], "postgresql://x@h/d", "an address is none of NATS"),
        (
            ["--cluster", "nats://me:secret@nats.example"],
            "postgresql://x@h/d",
            "a password would go over the network in clear text",
        ),
    ],
)
async def test_what_several_hubs_cannot_begin_with_is_said(tmp_path, words, url, said) -> None:
    words = ["-m", "talaia", "hub", "--plain", "--data", str(tmp_path), *words]
    process = await start_program(*words, with_errors=True, TALAIA_DATABASE_URL=url)
    _, errors = await asyncio.wait_for(process.communicate(), PATIENCE_S)
    assert process.returncode == 2
    assert said in errors.decode()
    assert "secret" not in errors.decode()
