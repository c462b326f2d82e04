"""Each site on its server; a server that is away, and a hub that is not to write any more."""

import pytest

from talaia.clock import SystemClock
from talaia.hub.errors import CannotStart
from talaia.hub.history.errors import HistoryAway, HistoryError
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.servers.history_servers import HistoryServers
from talaia.hub.history.servers.server_file import HistoryServersFile
from talaia.hub.history.store import HistoryStore
from talaia.hub.store.database import Database
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.home_tables import OWN
from talaia.model.yaml_text.load import load_site

from ...conftest import DESCRIPTION
from .samples_sent import assert_whole, send


async def test_a_new_site_is_written_where_new_sites_are(place) -> None:
    async with place.opened() as (history, _):
        await send(history, "before", 0, 20)
    place.default = "east"
    async with place.opened() as (history, homes):
        await send(history, "before", 20, 40)
        await send(history, "after", 0, 30)
        assert await homes.find_home("before") is None
        assert (await homes.find_home("after")).server == "east"
        assert not history.places.store_named(OWN).transfer.has_site("after")
        assert not history.places.store_named("east").transfer.has_site("before")
        await assert_whole(history, "before", 40)
        await assert_whole(history, "after", 30)
        # What is in blocks counts.
        await history.places.store_named(OWN).transfer.seal_all("before")
        await history.places.store_named("east").transfer.seal_all("after")
        stored = await history.measure_storage()
        assert {channel.site for channel in stored.channels} == {"before", "after"}


async def test_a_hub_that_was_replaced_writes_nothing_on_a_server(place) -> None:
    place.default = "east"
    async with place.opened() as (stale, _):
        await send(stale, "agv", 0, 30)
        async with place.opened() as (newer, _):
            await send(newer, "agv", 30, 60)
            for _ in range(2):
                with pytest.raises(HistoryError, match="another hub writes"):
                    await send(stale, "agv", 60, 90)
            # Nothing of it holds the newer one up, or is there.
            await send(newer, "agv", 60, 70)
            await assert_whole(newer, "agv", 70)
            assert "agv is on 'east', which is away" in stale.trouble
            assert newer.trouble == ""


async def test_a_site_goes_on_without_the_server_of_another(place, tmp_path) -> None:
    # A disk that is not there yet.
    place.east = f"sqlite:///{tmp_path}/disk/talaia.db"
    place.default = "east"
    async with place.opened() as (history, homes):
        await homes.add_home("near", OWN)
        site = load_site(DESCRIPTION)
        await history.describe_site(site)
        with pytest.raises(HistoryAway, match="'east' is away"):
            await send(history, site.site, 0, 10)
        with pytest.raises(HistoryAway):
            await history.stored_below(site.site, "b")
        with pytest.raises(HistoryAway):
            await history.read_series(site.site, ["base/x"], 0, 1, width=10)
        assert history.kind_of(site.site, "base/speed") is None
        assert f"{site.site} is on 'east', which is away" in history.trouble
    async with place.opened() as (history, homes):
        await send(history, "near", 0, 10)
        await assert_whole(history, "near", 10)
        await history.describe_site(site)
        (tmp_path / "disk").mkdir()
        await history.mend_servers()
        assert history.trouble == ""
        # What was described meanwhile is known there.
        assert history.kind_of(site.site, "base/speed").name == "Speed"
        await send(history, site.site, 0, 10)
        await assert_whole(history, site.site, 10)


async def test_a_database_of_another_hub_is_not_written(place, tmp_path) -> None:
    place.default = "east"
    async with place.opened() as (history, _):
        await send(history, "agv", 0, 10)
    place.accounts = f"sqlite:///{tmp_path}/second.db"
    async with place.opened() as (history, _):
        with pytest.raises(HistoryAway, match="histories of another hub"):
            await send(history, "agv", 10, 20)


async def test_the_hubs_own_database_is_no_other_server(place) -> None:
    place.default, place.east = "east", place.accounts
    async with place.opened() as (history, _):
        with pytest.raises(HistoryAway, match="is in use already"):
            await send(history, "agv", 10, 20)


async def test_a_server_that_has_a_site_must_be_named(place) -> None:
    async with place.opened() as (_, homes):
        await homes.add_home("agv", "west")
    with pytest.raises(CannotStart, match="'west'"):
        async with place.opened():
            pass


async def test_new_names_of_channels_wait_for_their_server(place, tmp_path) -> None:
    place.east, place.default = f"sqlite:///{tmp_path}/disk/talaia.db", "east"
    async with place.opened() as (history, _):
        await homes_known(history, "agv")
        with pytest.raises(HistoryAway):
            await history.rename_channels("agv", {"base/x": "base/y"})
        # Nothing to do needs no server.
        await history.rename_channels("agv", {})


async def homes_known(history, site):
    """Have a site that was written on a server that is away."""
    with pytest.raises(HistoryAway):
        await send(history, site, 0, 1)


@pytest.mark.parametrize("database_url", ["postgresql", "mariadb"], indirect=True)
async def test_a_hub_that_stands_still_within_a_transaction_is_ended_by_the_server(place) -> None:
    """It would keep the term's row, and with it every hub that comes after it, from writing."""
    place.default = "east"
    async with place.opened() as (history, _):
        await send(history, "agv", 0, 5)
        words = {
            "postgresql": "SHOW idle_in_transaction_session_timeout",
            "mysql": "SELECT @@SESSION.idle_transaction_timeout",
        }
        store = history.places.store_named("east")
        with store._writing.connect() as connection:
            bound = connection.exec_driver_sql(words[connection.dialect.name]).scalar()
    assert str(bound) in {"10s", "10"}


async def test_two_new_servers_are_prepared_at_once(tmp_path) -> None:
    """Tables are made by a library that knows one connection for the whole program."""
    folders = [tmp_path / name for name in ("accounts", "east", "west")]
    for folder in folders:
        folder.mkdir()
    accounts, east, west = (f"sqlite:///{folder}/talaia.db" for folder in folders)
    database = Database(accounts)
    await database.migrate()
    own = HistoryStore(accounts, SystemClock())
    named = HistoryServersFile(
        servers={"east": east, "west": west}, default="east", sites={"b": "west"}
    )
    servers = HistoryServers(
        own, named, HistoryHomes(database), clock=SystemClock(), limits=HistoryLimits()
    )
    await servers.open()
    for site in ("a", "b"):
        await send(servers, site, 0, 10)
        await assert_whole(servers, site, 10)
    await servers.close()
    await database.close()
