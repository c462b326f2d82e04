"""Two real hubs behind one address are one to pages and tools, also while one of them is away."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import socket
from contextlib import asynccontextmanager

import httpx
import pytest
import websockets
from patience import PATIENCE_S, until_answered
from prometheus_client.parser import text_string_to_metric_families

from talaia.hub.run import server_of
from talaia.hub.sharding.merged_lists import MergedLists
from talaia.hub.sharding.page_join import PageJoin
from talaia.hub.sharding.plan import MAIN
from talaia.wire import frames
from talaia.wire.browser import (
    Greeting,
    LeaseUpdate,
    PageDrive,
    PageLease,
    PagePing,
    PagePong,
    RequestError,
    SessionEnded,
    SiteUpdate,
    Subscribe,
    Values,
)
from talaia.wire.frames import LeaseOp

from ..api.clients.prometheus_server import open_protocol, token
from .two_shards import AGV, EAST, LAB

TIME_US = 1_700_000_000_000_000


class Joined:
    """One address before the hubs of both shards, as the router is; it can be cut off from one."""

    def __init__(self, shards) -> None:
        self._shards = shards
        self.asgi = self
        self.settings = shards.settings
        apps = {MAIN: self._at(MAIN), EAST: self._at(EAST)}
        self.page_join = PageJoin(apps, self._shard_of, retry_s=0.05)
        self.lists = MergedLists(apps, self._shard_of)
        self.port, self.origin = 0, ""
        # Shards that cannot be reached, as where the way to their hub is gone.
        self.cut = set()
        self.cut_off = asyncio.Event()

    async def hand_over(self) -> None: ...

    async def __call__(self, scope, receive, send) -> None:
        if scope["type"] == "lifespan":
            for answer in ("startup", "shutdown"):
                await receive()
                await send({"type": f"lifespan.{answer}.complete"})
        elif scope["type"] == "websocket":
            await self.page_join.serve(scope, receive, send)
        else:
            await self.lists.serve(scope, receive, send)

    async def _shard_of(self, site: str) -> str:
        return EAST if site == AGV else MAIN

    def _at(self, shard: str):
        async def ask(scope, receive, send) -> None:
            hub = self._shards._open.get(shard)
            if hub is None or shard in self.cut:
                raise ConnectionError("no hub leads just now")
            answering = asyncio.ensure_future(hub[0].hub.asgi(scope, receive, send))
            cut = asyncio.ensure_future(self.cut_off.wait())
            await asyncio.wait({answering, cut}, return_when=asyncio.FIRST_COMPLETED)
            cut.cancel()
            if not answering.done() and shard in self.cut:
                answering.cancel()
                raise ConnectionError("the hub that led is gone")
            await answering

        return ask

    def cut_off_from(self, shard: str) -> None:
        self.cut.add(shard)
        self.cut_off.set()

    @asynccontextmanager
    async def serving(self):
        with socket.create_server(("127.0.0.1", 0)) as listener:
            self.origin = f"http://127.0.0.1:{listener.getsockname()[1]}"
            self.port = listener.getsockname()[1]
            ready = asyncio.Event()
            server = server_of(self, ready.set)
            task = asyncio.create_task(server.serve(sockets=[listener]))
            await ready.wait()
            yield self
            server.should_exit = True
            await task

    async def page(self, name: str, *, text: bool = False):
        main = self._shards.main
        connection = await main.dial(
            "/ws?form=json" if text else "/ws",
            {"Cookie": await main.cookie(name), "Origin": self.origin},
            at=self,
        )
        page = main.peer(connection, text=text)
        await page.hear(Greeting)
        return page

    async def ask(self, name: str, path: str, headers=None) -> httpx.Response:
        if headers is None:
            headers = {"Cookie": await self._shards.main.cookie(name), "Origin": self.origin}
        async with httpx.AsyncClient(base_url=self.origin, timeout=PATIENCE_S) as client:
            return await client.get(path, headers=headers)


@pytest.fixture
async def joined(shards):
    async with Joined(shards).serving() as served:
        yield served


async def take_lease(page, gateway, site: str) -> None:
    await page.say(PageLease(site=site, device="base", op=LeaseOp.TAKE))
    asked = await gateway.hear(frames.LeaseRequest)
    said = {"device": "base", "session": asked.session, "who": asked.who, "epoch": 7}
    await gateway.say(frames.LeaseState(**said, remains_ms=60_000))
    await page.hear(LeaseUpdate, lambda lease: lease.site == site and lease.yours)


@pytest.mark.parametrize("text", [False, True], ids=["msgpack", "json"])
async def test_one_socket_has_the_values_and_the_driving_of_both(shards, joined, text) -> None:
    gateways = {site: await shards.gateway(site) for site in (AGV, LAB)}
    page = await joined.page("operator", text=text)
    for sub, (site, gateway) in enumerate(gateways.items()):
        await page.hear(SiteUpdate, lambda said, site=site: said.site == site and said.online)
        await page.say(Subscribe(sub=sub, site=site, channels=["power/voltage"], every_ms=0))
        await gateway.samples(("power/voltage", TIME_US, 12.5))
        await page.hear(Values, lambda said, sub=sub: said.sub == sub and len(said.value) > 0)
        await take_lease(page, gateway, site)
        drive = {"site": site, "device": "base", "epoch": 7, "seq": 1, "tick": 1, "angular": 0.0}
        await page.say(PageDrive(**drive, linear=0.3))
        assert (await gateway.hear(frames.DriveFrame)).linear == 0.3
    await page.say(PagePing(n=3, at_ms=1.0, active=True))
    assert (await page.hear(PagePong)).n == 3
    assert not [said for said in page.heard if isinstance(said, Greeting | PagePong | RequestError)]


async def test_while_the_hub_of_a_shard_is_away_the_rest_goes_on_and_all_is_there_again_after_it(
    shards, joined
) -> None:
    agv, lab = [await shards.gateway(site) for site in (AGV, LAB)]
    page = await joined.page("operator")
    await page.hear(SiteUpdate, lambda said: said.site == AGV and said.online)
    await page.say(Subscribe(sub=1, site=AGV, channels=["power/voltage"], every_ms=0))
    await agv.samples(("power/voltage", TIME_US, 12.5))
    await page.hear(Values, lambda said: len(said.value) > 0)
    await take_lease(page, lab, LAB)
    joined.cut_off_from(EAST)
    await shards.end(EAST)
    away = await page.hear(SiteUpdate, lambda said: said.away)
    assert (away.site, away.online) == (AGV, False)
    assert away.catalogue
    answer = await joined.ask("operator", "/api/sites")
    assert [site["site"] for site in answer.json()] == [LAB]
    assert answer.headers["x-talaia-missing"] == EAST
    await page.say(PageLease(site=AGV, device="base", op=LeaseOp.TAKE))
    assert (await page.hear(RequestError)).code == "offline"
    # Whoever drives at the other shard notices nothing of it.
    drive = {"site": LAB, "device": "base", "epoch": 7, "seq": 1, "tick": 1, "angular": 0.0}
    await page.say(PageDrive(**drive, linear=0.3))
    await lab.hear(frames.DriveFrame)
    await shards.start(EAST)
    joined.cut.clear()
    joined.cut_off.clear()
    again = await shards.gateway(AGV)
    await page.hear(SiteUpdate, lambda said: said.site == AGV and said.online)
    await again.samples(("power/voltage", TIME_US + 1, 13.0))
    await page.hear(Values, lambda said: said.sub == 1 and len(said.value) > 0)
    answer = await joined.ask("operator", "/api/sites")
    assert [site["site"] for site in answer.json()] == [AGV, LAB]
    assert "x-talaia-missing" not in answer.headers


async def test_a_session_that_ends_closes_the_page_with_its_one_reason(shards, joined) -> None:
    page = await joined.page("operator")
    cookie = await shards.main.cookie("operator")
    client = await shards.main.client()
    answer = await client.post("/api/logout", json={}, headers={"Cookie": cookie})
    assert answer.is_success
    assert await page.closed() == 4401
    assert len([said for said in page.heard if isinstance(said, SessionEnded)]) == 1


async def test_who_is_nobody_is_not_let_in(shards, joined) -> None:
    with pytest.raises(websockets.InvalidStatus) as asked:
        await shards.main.dial("/ws", {"Origin": joined.origin}, at=joined)
    assert asked.value.response.status_code == 401


async def test_what_is_asked_of_all_sites_has_those_of_both(shards, joined) -> None:
    for site in (AGV, LAB):
        gateway = await shards.gateway(site)
        await gateway.samples(("power/voltage", TIME_US, 12.5))

    async def listed(path: str) -> dict:
        answer = await joined.ask("admin", path)
        assert answer.status_code == 200, answer.text
        assert "x-talaia-missing" not in answer.headers
        return answer.json()

    assert [one["site"] for one in await listed("/api/sites")] == [AGV, LAB]
    devices = (await listed("/api/devices"))["devices"]
    assert [one["site"] for one in devices] == sorted(one["site"] for one in devices)
    assert {one["site"] for one in devices} == {AGV, LAB}
    for command in (await listed("/api/commands"))["commands"]:
        assert command["sites"] == [AGV, LAB]
    gateways = (await listed("/api/gateways"))["gateways"]
    assert {(one["site"], one["online"]) for one in gateways} >= {(AGV, True), (LAB, True)}
    assert [one["site"] for one in gateways] == sorted(one["site"] for one in gateways)
    assert len({one["id"] for one in gateways}) == len(gateways)
    assert (await listed("/api/releases"))["rollout"] is None
    await open_protocol(shards.main)
    # Of the sites of the other shard alone: the main one has nothing to tell, and says so.
    own = await token(shards.main, {"right": "metrics", "site": AGV, "device": "*"})
    everywhere = await token(shards.main, {"right": "metrics", "site": "*", "device": "*"})

    async def scrape(headers: dict[str, str]) -> dict[str, float]:
        answer = await joined.ask("admin", "/metrics", headers)
        assert answer.status_code in {200, 403}, answer.text
        return {} if answer.status_code == 403 else linked_in(answer.text)

    # The other shard hears within a second that the protocol is open.
    async def has_both() -> bool:
        return await scrape(everywhere) == {AGV: 1.0, LAB: 1.0}

    await until_answered(has_both)
    assert await scrape(own) == {AGV: 1.0}


def linked_in(scraped: str) -> dict[str, float]:
    return {
        sample.labels["site"]: sample.value
        for family in text_string_to_metric_families(scraped)
        for sample in family.samples
        if sample.name == "talaia_gateway_linked"
    }
