"""What an admin is told of several hubs, in words."""

from talaia.hub.api.hubs.hub_problems import find_problems
from talaia.hub.api.hubs.hub_schemas import HubShape, ShardShape


def hub(name, role="waits", **more) -> HubShape:
    about = {
        "version": "1", "own": False, "since_us": 0, "cpu": 0.1, "memory_bytes": 1,
        "database_ms": 1.0, "gateways": 0, "sockets": 0, "silent_s": 0.0, "shards": [],
    }  # fmt: skip
    return HubShape(name=name, role=role, **{**about, **more})


def test_hubs_that_are_well_have_no_problem() -> None:
    assert find_problems([hub("east", "leads"), hub("west")], bus=True) == []


def test_a_hub_that_is_gone_and_one_that_is_left_alone_are_named() -> None:
    said = find_problems([hub("east", "leads"), hub("west", "gone", silent_s=90.0)], bus=True)
    assert said == [
        "west has not been heard for 90\u202fs",
        "No other hub is there to take over",
    ]


def test_without_the_bus_nothing_is_said_of_hubs_that_nobody_can_hear() -> None:
    said = find_problems([hub("east", "leads"), hub("west", "gone", silent_s=90.0)], bus=False)
    assert said == ["NATS is away: pages and gateways reach this hub only where it is itself"]


def test_hubs_of_two_versions_and_a_slow_database_are_told() -> None:
    said = find_problems([hub("east", version="2"), hub("west", database_ms=800.0)], bus=True)
    assert said == [
        "The hubs are of different versions; go on with the upgrade",
        "The database is slow for west: 800\u202fms",
    ]


def shard(name, lead="east") -> ShardShape:
    return ShardShape(name=name, lead=lead, sites=[])


def test_a_shard_without_a_lead_is_named() -> None:
    hubs = [hub("east", "leads", shards=["main"]), hub("west")]
    said = find_problems(hubs, [shard("main"), shard("north", lead="")], bus=True)
    assert said == ["No hub leads the shard north"]


def test_a_hub_that_leads_all_while_another_one_waits_is_to_be_restarted() -> None:
    hubs = [hub("east", "leads", shards=["main", "north"]), hub("west")]
    said = find_problems(hubs, [shard("main"), shard("north")], bus=True)
    assert said == ["east leads 2 shards and west none: restart east to divide them"]


def test_hubs_without_a_spare_are_told_so_where_sites_are_divided() -> None:
    hubs = [hub("east", "leads", shards=["main"]), hub("west", "leads", shards=["north"])]
    said = find_problems(hubs, [shard("main"), shard("north", "west")], bus=True)
    assert said == ["Every hub leads: one more would take over sooner when one is gone"]
    hubs.append(hub("south"))
    assert find_problems(hubs, [shard("main"), shard("north", "west")], bus=True) == []
