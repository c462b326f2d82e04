"""Sites divided among two leads: each has its own, and whoever comes anywhere has all of them."""

from __future__ import annotations

import asyncio
import signal
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from patience import PATIENCE_S, until_answered

from talaia.wire import frames
from talaia.wire.browser import LeaseUpdate, PageDrive, PageLease, SiteUpdate, Subscribe, Values
from talaia.wire.frames import Ack, LeaseOp

from .conftest import DESCRIPTION
from .databases import empty_database
from .several_hubs import Hubs, Nats, sites_stored_in
from .test_cluster_run import ROW_US, STEP, send_rows, stored_values

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from .several_hubs import OneHub

MOON = DESCRIPTION.replace("site: agv", "site: moon")


@pytest.fixture(params=["postgresql", "mariadb"])
def urls(request):
    """Give two empty databases: of the accounts, and of the shard's histories."""
    with empty_database(request.param) as accounts, empty_database(request.param) as east:
        yield accounts, east


def leader_of(hubs: Hubs, shard: str) -> OneHub | None:
    """Give the living hub that has said that it leads a shard; the last one that took it."""
    found = [hub for hub in hubs.all if hub.process.returncode is None and hub.leads_shard(shard)]
    return found[0] if found else None


async def until_led(hubs: Hubs, shard: str) -> OneHub:
    async def is_led() -> bool:
        return leader_of(hubs, shard) is not None

    await until_answered(is_led)
    return leader_of(hubs, shard)


@asynccontextmanager
async def three_hubs(urls, folder) -> AsyncIterator[tuple[Hubs, OneHub, OneHub, OneHub]]:
    """Start three hubs: the lead of the main shard, that of the other one, and one that waits."""
    accounts, east = urls
    servers = folder / "servers.yaml"
    # The gateway `agv` is of the shard; what nobody names is of the main one.
    servers.write_text(f"servers: {{east: '{east}'}}\nshards: [east]\nsites: {{agv: east}}\n")
    servers.chmod(0o600)
    more = ("--history-servers", str(servers))
    async with Nats() as nats, Hubs(accounts, nats, folder) as hubs:
        # At once: one that is long alone takes all.
        await asyncio.gather(*(hubs.add(name, *more) for name in "abc"))
        main, shard = await until_led(hubs, "main"), await until_led(hubs, "east")
        await hubs.set_up(main)
        (spare,) = (hub for hub in hubs.all if hub not in {main, shard})
        await spare.until_ready()
        yield hubs, main, shard, spare


@pytest.mark.timeout(600)
async def test_sites_of_two_leads_are_one_portal_and_each_lead_that_dies_takes_only_its_own_along(
    tmp_path, urls
) -> None:
    async with three_hubs(urls, tmp_path) as (hubs, main, shard, spare):
        moon_key = await hubs.enrol(spare, "moon")
        # All come to the third, which leads nothing.
        agv, moon = await hubs.gateway(spare), await hubs.gateway(spare, moon_key)
        await agv.hello()
        await moon.hello(MOON, site="moon")
        await send_rows(agv, 0, 500)
        await send_rows(moon, 0, 500)
        for gateway in (agv, moon):
            await gateway.hear(Ack, lambda ack: ack.below >= 500)
        for hub in hubs.all:
            told = (await hubs.get(hub, "/api/sites")).json()
            assert [(site["site"], site["online"]) for site in told] == [
                ("agv", True),
                ("moon", True),
            ]
        assert sites_stored_in(urls[0]) == ["moon"]
        assert sites_stored_in(urls[1]) == ["agv"]
        # One socket has both.
        page = await hubs.page(spare)
        await page.say(Subscribe(sub=1, site="agv", channels=["power/voltage"], every_ms=0))
        await page.say(Subscribe(sub=2, site="moon", channels=["power/voltage"], every_ms=0))
        for sub, gateway in ((1, agv), (2, moon)):
            await gateway.samples(("power/voltage", ROW_US + 500_000, 12.5), first=500)
            await page.hear(Values, lambda told, sub=sub: told.sub == sub)
            await gateway.hear(Ack, lambda ack: ack.below >= 501)
        for name, gateway in (("agv", agv), ("moon", moon)):
            await drive(page, gateway, name)
        # The lead of the shard dies: the other site's gateway does not notice.
        shard.signal(signal.SIGKILL)
        await agv.closed()
        await page.hear(SiteUpdate, lambda told: told.site == "agv" and not told.online)
        await send_rows(moon, 501, 501 + STEP)
        await moon.hear(Ack, lambda ack: ack.below >= 501 + STEP)
        again = await hubs.gateway(spare)
        assert (await again.hello()).acked == 501
        await send_rows(again, 501, 1_001)
        await again.hear(Ack, lambda ack: ack.below >= 1_001)
        assert await stored_values(hubs, main, 1_000) == [
            *(float(at) for at in range(500)),
            12.5,
            *(float(at) for at in range(501, 1_001)),
        ]
        # The page that stayed sees the site again without asking anew.
        await page.hear(SiteUpdate, lambda told: told.site == "agv" and told.online)
        await again.samples(("power/voltage", ROW_US + 2_000_000, 13.0), first=1_001)
        await page.hear(Values, lambda told: told.sub == 1)
        # Now the lead of the main shard: no hub waits, so the other lead takes it besides.
        main.signal(signal.SIGKILL)
        await moon.closed()
        await until_led(hubs, "main")
        await send_rows(again, 1_002, 1_002 + STEP)
        await again.hear(Ack, lambda ack: ack.below >= 1_002 + STEP)
        back = await hubs.gateway(spare, moon_key)
        assert (await back.hello(MOON, site="moon")).acked >= 501 + STEP
        assert (await hubs.get(spare, "/api/audit/verify")).json()["ok"]


async def drive(page, gateway, site: str) -> None:
    """Take a device and drive it, through the page's one socket."""
    await page.say(PageLease(site=site, device="base", op=LeaseOp.TAKE))
    asked = await gateway.hear(frames.LeaseRequest)
    await gateway.say(
        frames.LeaseState(
            device="base", session=asked.session, who=asked.who, epoch=7, remains_ms=10_000
        )
    )
    await page.hear(LeaseUpdate, lambda lease: lease.yours and lease.site == site)
    await page.say(
        PageDrive(site=site, device="base", epoch=7, seq=1, tick=1, linear=0.3, angular=0.0)
    )
    assert (await gateway.hear(frames.DriveFrame)).linear == 0.3


@pytest.mark.timeout(600)
@pytest.mark.parametrize("urls", ["postgresql"], indirect=True)
async def test_a_hub_that_is_alone_leads_every_shard_and_one_that_comes_is_told_of(
    tmp_path, urls
) -> None:
    accounts, east = urls
    servers = tmp_path / "servers.yaml"
    servers.write_text(f"servers: {{east: '{east}'}}\nshards: [east]\ndefault: [east]\n")
    servers.chmod(0o600)
    more = ("--history-servers", str(servers))
    async with Nats() as nats, Hubs(accounts, nats, tmp_path) as hubs:
        only = await hubs.add("a", *more)
        await only.until_leads()
        await hubs.set_up(only)
        async with asyncio.timeout(PATIENCE_S):
            assert await until_led(hubs, "east") is only
        gateway = await hubs.gateway(only)
        await gateway.hello()
        await send_rows(gateway, 0, 200)
        await gateway.hear(Ack, lambda ack: ack.below >= 200)
        assert sites_stored_in(east) == ["agv"]
        other = await hubs.add("b", *more)
        await other.until_ready()

        async def is_told() -> bool:
            problems = (await hubs.get(other, "/api/hubs")).json()["problems"]
            return problems == ["a leads 2 shards and b none: restart a to divide them"]

        await until_answered(is_told)
