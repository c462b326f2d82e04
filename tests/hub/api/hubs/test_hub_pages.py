"""How hubs that are one stand, as their page says it."""

from __future__ import annotations

from talaia.clock import HandClock
from talaia.hub.api.hubs.hub_pages import HubPages
from talaia.hub.cluster.peers import HubNotice
from talaia.hub.files.local_folder import LocalFolder
from talaia.hub.live.sites import Sites
from talaia.hub.sharding.plan import MAIN, ShardPlan
from talaia.hub.store.database import open_migrated
from talaia.hub.store.history_servers.history_homes import HistoryHomes


class Seat:
    """A place among hubs that has heard what it is given, just now."""

    connected = True
    shard, plan = MAIN, ShardPlan()

    def __init__(self, own: HubNotice, *others: HubNotice, heard_ns: int) -> None:
        """Be ``own``, beside others."""
        self._own, self._others, self._heard_ns = own, others, heard_ns

    def own_notice(self) -> HubNotice:
        return self._own

    def heard_hubs(self) -> list[tuple[HubNotice, int]]:
        return [(notice, self._heard_ns) for notice in self._others]


def notice(name: str, epoch: int = 0, shards: tuple[str, ...] = ()) -> HubNotice:
    return HubNotice(hub=name, name=name, version="1", leads=epoch > 0, epoch=epoch, shards=shards)


def pages_of(seat, clock, folder, homes) -> HubPages:
    return HubPages(seat, clock, files=LocalFolder(folder), sites=Sites(), homes=homes)


async def test_a_lead_that_was_replaced_leads_no_more_though_it_was_just_heard(tmp_path) -> None:
    clock = HandClock()
    own, killed, third = notice("east", epoch=2), notice("west", epoch=1), notice("north")
    seat = Seat(own, killed, third, heard_ns=clock.monotonic_ns())
    async with open_migrated(f"sqlite:///{tmp_path}/hub.db") as database:
        told = await pages_of(seat, clock, tmp_path, HistoryHomes(database)).hubs()
    roles = {hub.name: hub.role for hub in told.hubs}
    assert roles == {"east": "leads", "west": "waits", "north": "waits"}
    assert told.shards == []


async def test_of_divided_sites_it_is_said_which_shard_has_them_and_who_leads_it(tmp_path) -> None:
    clock = HandClock()
    own, other = notice("east", epoch=2, shards=(MAIN,)), notice("west", shards=("north",))
    seat = Seat(own, other, heard_ns=clock.monotonic_ns())
    seat.plan = ShardPlan(("north", "south"))
    async with open_migrated(f"sqlite:///{tmp_path}/hub.db") as database:
        homes = HistoryHomes(database)
        for site, server in (("agv", "north"), ("moon", "own"), ("mast", "archive")):
            await homes.add_home(site, server)
        told = await pages_of(seat, clock, tmp_path, homes).hubs()
    assert [(shard.name, shard.lead, shard.sites) for shard in told.shards] == [
        ("main", "east", []),
        ("north", "west", ["agv"]),
        ("south", "", []),
    ]
    assert {hub.name: hub.role for hub in told.hubs} == {"east": "leads", "west": "leads"}
    assert told.problems[0] == "No hub leads the shard south"
