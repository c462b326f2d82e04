"""A site goes to another shard while hubs run: what was acknowledged is there, and there once."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import contextlib
import signal
from typing import TYPE_CHECKING

import pytest
import sqlalchemy as sa
import websockets
from async_program import start_program
from patience import PATIENCE_S, until_answered

from talaia.hub.store.database_url import parse_database_url
from talaia.hub.store.history_servers.home_tables import history_homes
from talaia.hub.store.history_servers.shard_handover import HoldWord, word_of
from talaia.wire.browser import SiteUpdate, Subscribe, Values
from talaia.wire.frames import Ack

from .conftest import DESCRIPTION
from .several_hubs import sites_stored_in
from .test_cluster_run import ROW_US, STEP, stored_values
from .test_sharded_hubs import drive, leader_of, three_hubs, urls  # noqa: F401 - a fixture

if TYPE_CHECKING:
    from .conftest import Peer
    from .several_hubs import Hubs, OneHub


class SteadyGateway:
    """A gateway that sends without a pause, dials again, and sends again what is not stored."""

    def __init__(self, hubs: Hubs, hub: OneHub, *, key: str = "", site: str = "agv") -> None:
        self.acked = 0
        # The longest that nothing was acknowledged (s).
        self.longest_s = 0.0
        self._hubs, self._key, self._site = hubs, key, site
        # Where it dials.
        self.hub = hub
        self._last_s = asyncio.get_running_loop().time()
        self.link = None
        self._ended = False
        self._running = asyncio.create_task(self._run())

    async def until_acked(self, more: int) -> None:
        """Wait until so many more samples are stored than now."""
        wanted = self.acked + more

        async def is_acked() -> bool:
            if self._running.done():
                await self._running
            return self.acked >= wanted

        await until_answered(is_acked)

    async def end(self) -> int:
        """Send no more; give how many are stored."""
        self._ended = True
        await asyncio.wait_for(self._running, PATIENCE_S)
        return self.acked

    async def _run(self) -> None:
        while not self._ended:
            await until_answered(self._dial)
            # Whatever is under way as the link is lost is sent again.
            with contextlib.suppress(AssertionError, websockets.ConnectionClosed):
                await self._send()

    async def _dial(self) -> bool:
        try:
            link = await self._hubs.gateway(self.hub, self._key)
            link.acked = self.acked
            description = DESCRIPTION.replace("site: agv", f"site: {self._site}")
            stored = (await link.hello(description, site=self._site)).acked
        except (OSError, websockets.WebSocketException, AssertionError):
            return False
        # What it was told to be stored is.
        assert stored >= self.acked
        self.link, self.acked = link, stored
        return True

    async def _send(self) -> None:
        while not self._ended:
            first = self.acked
            rows = [
                ("power/voltage", ROW_US + number * 1000, float(number))
                for number in range(first, first + STEP)
            ]
            await self.link.samples(*rows, first=first)
            await self.link.hear(Ack, lambda ack, past=first + STEP: ack.below >= past)
            self.acked = first + STEP
            now_s = asyncio.get_running_loop().time()
            self.longest_s = max(self.longest_s, now_s - self._last_s)
            self._last_s = now_s


async def move(hubs: Hubs, hub: OneHub, server: str) -> list[str]:
    """Ask for the move of `agv` as an operator does; give what the command says."""
    command = await start_program(
        *("-m", "talaia", "history", "move", "agv", "--to", server),
        *("--data", str(hub.folder)),
        *("--history-servers", str(hub.folder.parent / "servers.yaml")),
        with_errors=True,
        TALAIA_DATABASE_URL=hubs.url,
    )
    said, errors = await asyncio.wait_for(command.communicate(), PATIENCE_S)
    assert command.returncode == 0, errors.decode()
    return said.decode().splitlines()


@pytest.mark.timeout(600)
async def test_a_site_goes_to_another_shard_and_back_while_it_is_written(tmp_path, urls) -> None:  # noqa: F811
    async with three_hubs(urls, tmp_path) as (hubs, main, _, spare):
        moon_key = await hubs.enrol(spare, "moon")
        agv = SteadyGateway(hubs, spare)
        moon = SteadyGateway(hubs, main, key=moon_key, site="moon")
        await agv.until_acked(1_000)
        await moon.until_acked(1_000)
        pages = [await looking_page(hubs, hub) for hub in hubs.all]
        for server, there, elsewhere in (
            ("own", urls[0], urls[1]),
            ("east", urls[1], urls[0]),
        ):
            agv.longest_s = moon.longest_s = 0.0
            said = await move(hubs, spare, server)
            assert said[-1] == f"agv: {server}"
            await agv.until_acked(500)
            await moon.until_acked(500)
            # Pages stay, and see both sites again without asking anew.
            for page in pages:
                for sub, gateway in ((1, agv), (2, moon)):
                    await sees_new(page, sub, gateway)
            assert "agv" in sites_stored_in(there)
            assert "agv" not in sites_stored_in(elsewhere)
            page = await hubs.page(spare)
            await page.hear(SiteUpdate, lambda told: told.site == "agv" and told.online)
            await drive(page, agv.link, "agv")
            await page.close()
        past = await agv.end()
        await moon.end()
        for hub in hubs.all:
            found = await stored_values(hubs, hub, past - 1)
            assert found == [float(number) for number in range(past)]
        assert (await hubs.get(spare, "/api/audit/verify")).json()["ok"]


async def looking_page(hubs: Hubs, hub: OneHub) -> Peer:
    """Open a page that looks at both sites."""
    page = await hubs.page(hub)
    for sub, site in ((1, "agv"), (2, "moon")):
        await page.say(Subscribe(sub=sub, site=site, channels=["power/voltage"], every_ms=0))
        await page.hear(Values, lambda told, sub=sub: told.sub == sub)
    return page


async def sees_new(page: Peer, sub: int, gateway: SteadyGateway) -> None:
    """Wait for a value that was not there yet when this was asked."""
    past_us = ROW_US + gateway.acked * 1000
    await page.hear(Values, lambda told: told.sub == sub and told.base_us > past_us)


class Row:
    """The row that says where the site is, as it stands from moment to moment."""

    def __init__(self, url: str) -> None:
        self._engine = sa.create_engine(parse_database_url(url, blocking=True).url)

    def close(self) -> None:
        self._engine.dispose()

    async def until(self, fits) -> sa.Row:
        """Look without a pause until it stands as wanted."""
        async with asyncio.timeout(PATIENCE_S):
            while not fits(row := await asyncio.to_thread(self._read)):
                pass
        return row

    def _read(self) -> sa.Row:
        with self._engine.connect() as connection:
            return connection.execute(
                sa.select(history_homes).where(history_homes.c.site == "agv")
            ).one()


def is_held(row: sa.Row) -> bool:
    return word_of(row.hold) == HoldWord.HELD


async def until_held(row: Row, hubs: Hubs, asked: OneHub, to: str) -> asyncio.Task:
    """Ask for a move, and come back in the moment in which nothing of the site is written."""
    moving = asyncio.create_task(move(hubs, asked, to))
    await row.until(is_held)
    return moving


@pytest.mark.timeout(900)
@pytest.mark.parametrize("urls", ["postgresql"], indirect=True)
async def test_whichever_lead_is_killed_within_the_hold_nothing_is_lost_or_twice(
    tmp_path,
    urls,  # noqa: F811
) -> None:
    async with three_hubs(urls, tmp_path) as (hubs, main, east, spare):
        row = Row(urls[0])
        agv = SteadyGateway(hubs, spare)
        await agv.until_acked(1_000)
        # The lead that it comes from dies, while the other one stands still in the middle of the
        # last copy: a new one writes the site again, so that copy must not become the site.
        moving = await until_held(row, hubs, spare, "own")
        main.signal(signal.SIGSTOP)
        east.signal(signal.SIGKILL)
        found = await row.until(lambda found: not is_held(found))
        await agv.until_acked(100)
        main.signal(signal.SIGCONT)
        assert found.server == "east"
        assert (await moving)[-1] == "agv: own"
        await agv.until_acked(500)
        # The lead that it goes to dies: the other one goes on with it.
        agv.hub = await hubs.add("d", "--history-servers", str(tmp_path / "servers.yaml"))
        await agv.hub.until_ready()
        target = leader_of(hubs, "east")
        moving = await until_held(row, hubs, agv.hub, "east")
        target.signal(signal.SIGKILL)
        assert (await moving)[-1] == "agv: east"
        await agv.until_acked(500)
        # Both die between the commit by which the site is elsewhere and their beginning anew: it is
        # nobody's until one hub has both shards.
        agv.hub = await hubs.add("e", "--history-servers", str(tmp_path / "servers.yaml"))
        await agv.hub.until_ready()
        moving = asyncio.create_task(move(hubs, agv.hub, "own"))
        await row.until(lambda found: found.led_by)
        for hub in hubs.all:
            if hub is not agv.hub and hub.process.returncode is None:
                hub.signal(signal.SIGKILL)
        assert (await moving)[-1] == "agv: own"
        await agv.until_acked(500)
        past = await agv.end()
        found = await stored_values(hubs, agv.hub, past - 1)
        assert found == [float(number) for number in range(past)]
        row.close()
