"""What the file of servers says, and what is wrong with one."""

from collections import Counter

import pytest
from hypothesis import given, strategies as st

from talaia.hub.errors import CannotStart
from talaia.hub.history.servers.server_file import HistoryServersFile, read_history_servers
from talaia.hub.sharding.plan import ShardPlan
from talaia.hub.store.history_servers.home_tables import OWN

pytestmark = pytest.mark.pure
_EAST = "servers: {east: 'mariadb://a@b/c'}"


def test_a_new_site_is_where_its_name_says_or_where_all_are(tmp_path) -> None:
    file = tmp_path / "servers.yaml"
    file.write_text(
        "servers: {east: 'postgresql://a@b/c', west: 'mariadb://a@b/c'}\n"
        "default: east\nsites: {lab: west, hall: own}\n"
    )
    found = read_history_servers(file)
    homes = [found.first_home(site, {}) for site in ("lab", "hall", "agv")]
    assert homes == ["west", OWN, "east"]
    assert found.plan == ShardPlan()
    file.write_text("servers: {east: 'postgresql://a@b/c'}\n")
    assert read_history_servers(file).first_home("agv", {}) == OWN


def test_of_several_a_new_site_is_where_the_fewest_are(tmp_path) -> None:
    found = divided_file(tmp_path)
    assert found.plan == ShardPlan(("east", "west"))
    assert found.first_home("agv", {}) == "east"
    assert found.first_home("agv", {"east": 3, "west": 2, OWN: 1}) == "west"
    assert found.first_home("lab", {"west": 9}) == "west"
    # What the main shard has is never where a shard's own sites are.
    for site in ("agv", "lab"):
        assert found.first_home(site, {}, without=found.shards) == OWN
        assert found.first_home(site, {"north": 1}, without=["east"]) == "west"


@given(st.lists(st.sampled_from(["agv", "lab", "drone"]) | st.text(max_size=3), max_size=30))
def test_sites_spread_evenly_over_servers(names) -> None:
    found = HistoryServersFile(servers={"a": "x", "b": "x", "c": "x"}, default=("c", "a", OWN))
    counts = Counter()
    for name in names:
        counts[found.first_home(name, counts)] += 1
    assert counts.keys() <= {"a", "c", OWN}
    assert max(counts.values(), default=0) - min(counts[name] for name in found.defaults) <= 1


def divided_file(folder):
    file = folder / "servers.yaml"
    file.write_text(
        "servers: {east: 'postgresql://a@b/c', west: 'mariadb://a@b/c'}\n"
        "shards: [east, west]\ndefault: [east, west]\nsites: {lab: west}\n"
    )
    return read_history_servers(file)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("servers: {own: 'postgresql://a@b/c'}", "own database"),
        ("servers: {east: 'oracle://a:secret@b/c'}", "no engine"),
        ("servers: {East Side: 'postgresql://a@b/c'}", "servers"),
        ("servers: {}\ndefault: east", "there is no server 'east'"),
        ("servers: {}\nsites: {lab: east}", "there is no server 'east'"),
        ("servers: {}\nmore: 1", "more"),
        ("servers: {}\ndefault: []", "default: names no server"),
        (f"{_EAST}\ndefault: [east, west]", "there is no server 'west'"),
        (f"{_EAST}\nshards: [west]", "there is no server 'west'"),
        (f"{_EAST}\nshards: [own]", "'own' cannot be a shard"),
        (f"{_EAST}\nshards: [east, east]", "one is named twice"),
        ("servers: {main: 'mariadb://a@b/c'}\nshards: [main]", "no server can be called 'main'"),
    ],
)
def test_what_cannot_be_is_told_and_no_password(tmp_path, text, said) -> None:
    file = tmp_path / "servers.yaml"
    file.write_text(text)
    with pytest.raises(CannotStart) as told:
        read_history_servers(file)
    assert said in str(told.value)
    assert "secret" not in str(told.value)
