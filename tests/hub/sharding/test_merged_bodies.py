"""Answers of several shards make the one that a hub with all sites would give."""

from __future__ import annotations

import json

import msgspec
import pytest
from hypothesis import given, settings, strategies as st
from msgspec.structs import replace

from talaia.hub.api.missions.fleet_schemas import SharedCommandList
from talaia.hub.api.schemas.history_schemas import OutlookShape, StorageShape
from talaia.hub.api.sites.shared_commands import list_shared_commands
from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.history.forecast import Warn
from talaia.hub.sharding.merged_bodies import (
    join_client_protocols,
    join_commands,
    join_devices,
    join_gateways,
    join_releases,
    join_sites,
    join_storage,
)
from talaia.model.site import Argument, ArgumentType, Command, Device, Site

SITES = "abcdefgh"
# Which of three shards has which site.
divided = st.fixed_dictionaries({site: st.integers(0, 2) for site in SITES})


def bodies_of(rows, shard_of, write) -> list[bytes]:
    """Write what each shard answers of its own sites."""
    return [write([row for row in rows if shard_of[row["site"]] == shard]) for shard in range(3)]


@given(divided)
def test_sites_stand_in_the_order_of_their_names_and_as_the_bytes_they_were(shard_of) -> None:
    rows = [{"site": site, "loop_ms": 0.1, "name": "ñ", "nested": [{"a": None}]} for site in SITES]
    joined = join_sites(bodies_of(rows, shard_of, msgspec.json.encode))
    assert joined == msgspec.json.encode(rows)


@given(divided)
def test_devices_stand_by_site_each_site_s_in_its_own_order(shard_of) -> None:
    rows = [{"site": site, "device": device} for site in SITES for device in ("z", "a")]
    bodies = bodies_of(rows, shard_of, lambda own: msgspec.json.encode({"devices": own}))
    assert json.loads(join_devices(bodies)) == {"devices": rows}


@given(divided)
def test_gateways_stand_by_site_the_newest_first_and_codes_the_newest_first(shard_of) -> None:
    rows = [{"id": str(n), "site": site} for site in SITES for n in (100, 99, 9)]
    codes = [{"id": str(n), "site": SITES[n % 8]} for n in range(12, 0, -1)]
    bodies = [
        msgspec.json.encode({"gateways": own, "codes": [c for c in codes if c["site"] in has]})
        for shard in range(3)
        for has in [{site for site in SITES if shard_of[site] == shard}]
        for own in [[row for row in rows if row["site"] in has]]
    ]
    assert json.loads(join_gateways(bodies)) == {"gateways": rows, "codes": codes}


arguments = st.builds(
    Argument,
    type=st.just(ArgumentType.NUMBER),
    field=st.just("v"),
    unit=st.sampled_from(["m/s", "km/h"]),
    minimum=st.sampled_from([None, 0.0, 0.5]),
    maximum=st.sampled_from([None, 1.0, 2.0]),
    default=st.sampled_from([None, 0.7]),
)
commands = st.builds(
    Command,
    name=st.sampled_from(["Cruise", "Go"]),
    target=st.just("/cruise"),
    arguments=st.dictionaries(st.sampled_from("vw"), arguments, max_size=2),
    confirm=st.booleans(),
    timeout=st.sampled_from([1.0, 30.0]),
)


@settings(max_examples=60)
@given(
    st.fixed_dictionaries(
        {site: st.dictionaries(st.sampled_from(["cruise", "dock"]), commands) for site in "abcd"}
    ),
    divided,
    st.booleans(),
)
def test_commands_in_common_are_those_that_a_hub_with_all_sites_would_list(
    described, shard_of, somewhere_only_view
) -> None:
    sites = [
        Site(
            talaia=1,
            site=name,
            name=name,
            devices={"base": Device(name=f"Base of {name}", kind="vehicle", commands=own)},
        )
        for name, own in sorted(described.items())
    ]
    rights = dict.fromkeys(SITES, Right.USE)
    if somewhere_only_view:
        # Of shard 0 one may be only looked at; where all of a shard are, it does not tell of them.
        rights["a"] = Right.VIEW
        shard_of = {**shard_of, "a": 0, "b": 0}
        sites[1] = replace(sites[1], devices=sites[0].devices)
    grants = Grants(frozenset(Permission(right, site) for site, right in rights.items()))

    def listed(shards) -> bytes:
        own = [site for site in sites if shard_of[site.site] in shards]
        shared = list_shared_commands(own, grants)
        return SharedCommandList(commands=shared).model_dump_json().encode()

    joined = json.loads(join_commands([listed({shard}) for shard in range(3)]))
    assert joined == json.loads(listed({0, 1, 2}))


def storage(**said) -> bytes:
    usual = {
        "kind": "PostgreSQL 15.4",
        "place": "talaia on db",
        "database_bytes": 1_000,
        "spare_bytes": 10,
        "blocks_bytes": 500,
        "free_bytes": None,
        "disk_bytes": 0,
        "limit_bytes": 0,
        "day_bytes": 5,
        "full_us": None,
        "by_limit": False,
        "oldest_us": None,
        "kept_days": None,
        "warn": Warn.NOTHING,
        "trouble": "",
        "files_trouble": "",
        "channels": [],
    }
    return StorageShape(**{**usual, **said}).model_dump_json().encode()


def joined_storage(*bodies: bytes) -> StorageShape:
    return StorageShape.model_validate_json(join_storage(bodies))


def test_room_of_histories_is_added_up_and_the_first_that_is_full_is_told() -> None:
    channel = {"address": "base/speed", "name": "", "described": True, "samples": 1}
    channel |= {"bytes": 1, "day_bytes": 1, "first_us": 1, "last_us": 1, "keep_days": 0.0}
    joined = joined_storage(
        storage(full_us=900, oldest_us=1, channels=[{**channel, "site": "a"}], limit_bytes=7),
        storage(place="east on db", limit_bytes=7, kept_days=9.0, trouble="it is away"),
        storage(
            full_us=500,
            by_limit=True,
            oldest_us=2,
            limit_bytes=7,
            kept_days=8.0,
            warn=Warn.LIMIT,
            trouble="it is away",
            channels=[{**channel, "site": "b"}],
        ),
    )
    assert (joined.place, joined.database_bytes, joined.spare_bytes) == (
        "talaia on db; east on db",
        3_000,
        30,
    )
    assert (joined.blocks_bytes, joined.limit_bytes, joined.day_bytes) == (1_500, 21, 15)
    assert (joined.full_us, joined.by_limit, joined.oldest_us) == (500, True, 2)
    assert (joined.kept_days, joined.warn, joined.trouble) == (8.0, Warn.LIMIT, "it is away")
    assert [one.site for one in joined.channels] == ["a", "b"]


@pytest.mark.parametrize(
    "body",
    [
        storage(),
        OutlookShape(
            **dict.fromkeys(("trouble", "files_trouble"), "x"),
            warn=Warn.FULL,
            full_us=3,
            free_bytes=4,
        )
        .model_dump_json()
        .encode(),
    ],
)
def test_storage_of_one_shard_is_as_that_says(body) -> None:
    assert json.loads(join_storage([body])) == json.loads(body)


def test_in_short_the_worst_of_all_is_told() -> None:
    def outlook(warn: Warn, trouble: str = "") -> bytes:
        said = {"trouble": trouble, "files_trouble": "", "full_us": None, "free_bytes": None}
        return OutlookShape(**said, warn=warn).model_dump_json().encode()

    bodies = [outlook(warn) for warn in (Warn.NOTHING, Warn.SOON, Warn.FULL, Warn.LIMIT)]
    assert [
        json.loads(join_storage(bodies[:count]))["warn"] for count in range(1, len(bodies) + 1)
    ] == ["", "soon", "full", "full"]
    troubled = [outlook(Warn.NOTHING, "one"), outlook(Warn.NOTHING), outlook(Warn.NOTHING, "two")]
    assert json.loads(join_storage(troubled))["trouble"] == "one; two"


def rollout(version: str, began_us: int, sites: list[str], **said) -> dict:
    return {
        "version": version,
        "began_us": began_us,
        "runs": False,
        "stopped": "",
        "sites": [{"site": site, "stage": "done", "why": ""} for site in sites],
        **said,
    }


def releases(files: list[str], gateways: list[str], last: dict | None) -> bytes:
    rows = {
        "releases": [{"name": name, "size": 1} for name in files],
        "gateways": [{"site": site} for site in gateways],
        "rollout": last,
    }
    return msgspec.json.encode(rows)


def test_releases_are_those_of_all_folders_and_a_rollout_is_that_of_all_its_sites() -> None:
    joined = json.loads(
        join_releases(
            [
                releases(["2.0", "1.0"], ["b"], rollout("1.0", 1, ["b"])),
                releases(["2.0", "0.9"], ["a"], rollout("2.0", 8, ["a"], runs=True)),
                releases([], [], None),
                releases([], ["c"], rollout("2.0", 7, ["c"], stopped="c failed")),
            ]
        )
    )
    assert [row["name"] for row in joined["releases"]] == ["2.0", "1.0", "0.9"]
    assert [row["site"] for row in joined["gateways"]] == ["a", "b", "c"]
    last = joined["rollout"]
    assert (last["version"], last["began_us"], last["runs"], last["stopped"]) == (
        "2.0",
        7,
        True,
        "c failed",
    )
    assert [row["site"] for row in last["sites"]] == ["a", "c"]


def test_where_nothing_was_handed_out_none_is_told() -> None:
    assert json.loads(join_releases([releases([], [], None)] * 2))["rollout"] is None


def test_clients_of_all_shards_are_counted_and_brokers_of_each_are_named() -> None:
    def body(connected: int, broker: str, *more: str) -> bytes:
        first = {"protocol": "mqtt", "open": True, "connected": connected, "brokers": [broker]}
        rest = [{"protocol": name, "connected": 1, "brokers": []} for name in more]
        return msgspec.json.encode({"protocols": [first, *rest], "drivers": [{"site": "agv"}]})

    joined = json.loads(join_client_protocols([body(2, "of main"), body(3, "of east", "newer")]))
    assert joined == {
        "protocols": [
            {"protocol": "mqtt", "open": True, "connected": 5, "brokers": ["of main", "of east"]}
        ],
        "drivers": [{"site": "agv"}],
    }
