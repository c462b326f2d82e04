"""``talaia history`` where sites are divided: hubs move a site, or the command does."""

import asyncio
import contextlib
import threading
from contextlib import asynccontextmanager
from dataclasses import replace

import pytest
from hub.conftest import DESCRIPTION, settings_in
from hub.databases import empty_database
from hub.history.servers.samples_sent import assert_whole, send
from patience import PATIENCE_S, until_answered
from sqlalchemy import update

from talaia.cli.history.moving import list_histories, move_history
from talaia.clock import SystemClock
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.servers.build_history import build_history
from talaia.hub.lock import hub_lock
from talaia.hub.sharding.plan import ShardPlan
from talaia.hub.store.database import Database, open_migrated
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.lead.hub_plan import agree_on_plan
from talaia.hub.store.lead.lead_lock import LeadLock
from talaia.hub.store.lead.lead_table import hub_plan
from talaia.hub.store.sites.site_registry import SiteRegistry

PLAN = ShardPlan(("east",))


@pytest.fixture(params=["sqlite", "postgresql", "mariadb"])
def settings(request, tmp_path):
    """Give the settings of hubs that divide their sites, on a database of each kind."""
    servers = tmp_path / "servers.yaml"
    servers.write_text(
        f"servers: {{east: 'sqlite:///{tmp_path}/east.db', west: 'sqlite:///{tmp_path}/w.db'}}\n"
        "shards: [east]\n"
    )
    servers.chmod(0o600)
    settings = replace(settings_in(tmp_path), history_servers=servers)
    with contextlib.ExitStack() as stack:
        if request.param != "sqlite":
            url = stack.enter_context(empty_database(request.param))
            settings = replace(settings, database_url=url)
        yield settings


@asynccontextmanager
async def lead_of(settings, shard):
    """Give the history of a shard's lead, and the accounts' database."""
    database = Database(settings.url)
    await database.migrate()
    try:
        await agree_on_plan(database, PLAN.names)
        history = build_history(
            settings, database, SystemClock(), HistoryLimits(), shard=shard, plan=PLAN
        )
        try:
            await history.open()
            yield history, database
        finally:
            await history.close()
    finally:
        await database.close()


async def have_site(settings) -> None:
    async with lead_of(settings, "main") as (history, database):
        await SiteRegistry(database, SystemClock()).said_hello("agv", DESCRIPTION, "", "")
        await send(history, "agv", 0, 100)


async def test_a_site_changes_its_shard_while_no_hub_runs(settings) -> None:
    await have_site(settings)
    said = []
    await list_histories(settings, said.append)
    await move_history(settings, "agv", "west", said.append)
    await move_history(settings, "agv", "east", said.append)
    # Once more: it is there.
    await move_history(settings, "agv", "east", said.append)
    await list_histories(settings, said.append)
    assert said[0] == "agv: own (shard main)"
    assert said[-3:] == ["agv: east", "agv: east", "agv: east (shard east)"]
    async with lead_of(settings, "east") as (history, database):
        await assert_whole(history, "agv", 100)
        assert (await HistoryHomes(database).find_home("agv")).erase_at == ""


@asynccontextmanager
async def asked(settings):
    """Ask for the move, which a hub is to do; it is done when this ends, by which that has."""
    said = []
    moving = asyncio.create_task(move_history(settings, "agv", "east", said.append, wait_s=0.1))
    async with open_migrated(settings.url) as database:
        homes = HistoryHomes(database)

        async def is_asked() -> bool:
            home = await homes.find_home("agv")
            return home is not None and home.moving_to == "east"

        await until_answered(is_asked)
        assert (await homes.find_home("agv")).server == "own"
        yield
    await asyncio.wait_for(moving, PATIENCE_S)
    assert said[0] == "agv: own, on its way to east"
    assert said[-1] == "agv: east"


@pytest.mark.parametrize("settings", ["sqlite"], indirect=True)
async def test_while_a_hub_runs_it_asks_and_does_it_itself_when_that_has_ended(settings) -> None:
    held = contextlib.ExitStack()
    await have_site(settings)
    held.enter_context(hub_lock(settings.data))
    async with asked(settings):
        held.close()


@pytest.mark.parametrize("settings", ["postgresql", "mariadb"], indirect=True)
@pytest.mark.parametrize("shard", ["main", "east"])
async def test_a_lead_of_any_shard_on_another_machine_is_a_hub_that_runs(settings, shard) -> None:
    await have_site(settings)
    taken = threading.Event()
    lock = LeadLock(settings.url, taken=taken.set, lost=print, shard=shard, shards=PLAN.names)
    lock.start_looking()
    assert await asyncio.to_thread(taken.wait, PATIENCE_S)
    async with asked(settings):
        await asyncio.to_thread(lock.stop_looking)


@pytest.mark.parametrize("settings", ["postgresql", "mariadb"], indirect=True)
async def test_no_lead_begins_meanwhile(settings) -> None:
    await have_site(settings)
    taken = []

    def try_to_lead(_line) -> None:
        for shard in PLAN.all_names:
            began = threading.Event()
            lock = LeadLock(
                settings.url, taken=began.set, lost=print, shard=shard, shards=PLAN.names
            )
            lock.start_looking()
            lock.tried.wait(PATIENCE_S)
            lock.stop_looking()
            taken.append(began.is_set())
        said.append(_line)

    said = []
    await move_history(settings, "agv", "east", try_to_lead)
    # It says so first while it moves, and last when that is over.
    assert said[0] == "agv: own, on its way to east"
    assert taken[:2] == [False, False]


@pytest.mark.parametrize("settings", ["postgresql"], indirect=True)
async def test_a_program_of_another_version_moves_it_too(settings) -> None:
    await have_site(settings)
    async with open_migrated(settings.url) as database, database.write() as connection:
        # As hubs of another version have written it down.
        await connection.execute(update(hub_plan).values(agreed="9999 east"))
    said = []
    await move_history(settings, "agv", "east", said.append)
    assert said[-1] == "agv: east"


@pytest.mark.parametrize("settings", ["sqlite"], indirect=True)
async def test_a_move_that_was_broken_off_goes_on_when_it_is_run_again(settings) -> None:
    await have_site(settings)
    async with lead_of(settings, "main") as (history, database):
        # As the command leaves it that is killed.
        asked = await HistoryHomes(database).ask_move("agv", "east", own="own")
        await history.move_sites()
        await send(history, "agv", 100, 150)
        assert await HistoryHomes(database).find_home("agv") == asked
    said = []
    await move_history(settings, "agv", "east", said.append)
    assert said[0] == "agv: own, on its way to east"
    async with lead_of(settings, "east") as (history, _):
        await assert_whole(history, "agv", 150)
