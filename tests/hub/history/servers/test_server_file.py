"""What the file of servers says, and what is wrong with one."""

import pytest

from talaia.hub.errors import CannotStart
from talaia.hub.history.servers.server_file import read_history_servers
from talaia.hub.store.history_servers.home_tables import OWN

pytestmark = pytest.mark.pure


def test_a_new_site_is_where_its_name_says_or_where_all_are(tmp_path) -> None:
    file = tmp_path / "servers.yaml"
    file.write_text(
        "servers: {east: 'postgresql://a@b/c', west: 'mariadb://a@b/c'}\n"
        "default: east\nsites: {lab: west, hall: own}\n"
    )
    found = read_history_servers(file)
    assert [found.first_home(site) for site in ("lab", "hall", "agv")] == ["west", OWN, "east"]
    file.write_text("servers: {east: 'postgresql://a@b/c'}\n")
    assert read_history_servers(file).first_home("agv") == OWN


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("servers: {own: 'postgresql://a@b/c'}", "own database"),
        ("servers: {east: 'oracle://a:secret@b/c'}", "no engine"),
        ("servers: {East Side: 'postgresql://a@b/c'}", "servers"),
        ("servers: {}\ndefault: east", "there is no server 'east'"),
        ("servers: {}\nsites: {lab: east}", "there is no server 'east'"),
        ("servers: {}\nmore: 1", "more"),
    ],
)
def test_what_cannot_be_is_told_and_no_password(tmp_path, text, said) -> None:
    file = tmp_path / "servers.yaml"
    file.write_text(text)
    with pytest.raises(CannotStart) as told:
        read_history_servers(file)
    assert said in str(told.value)
    assert "secret" not in str(told.value)
