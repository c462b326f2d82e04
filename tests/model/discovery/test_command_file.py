"""The founding observatory's JSON command file as it stands."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from talaia.model.checks.site_checks import check_site
from talaia.model.connection import ProcessConnection
from talaia.model.discovery.command_file import read_classic, site_of
from talaia.model.errors import DescriptionError
from talaia.model.site import DeviceKind, SignalType
from talaia.model.yaml_text.load import dump_site, load_site, read_site

RECORDED = Path(__file__).parents[2] / "wire" / "recorded" / "observatory_commands.json"


def test_the_contracts_file_is_a_site_that_can_run() -> None:
    site = site_of(RECORDED.read_text(), "observatory")
    assert check_site(site) == []
    dome = site.devices["dome"]
    assert dome.kind is DeviceKind.DOME
    assert dome.signals["status"].type is SignalType.STATE
    assert dome.signals["status"].states == ("opened", "closed", "moving")
    assert dome.signals["status"].source.run == "dome_servcli client status"
    assert dome.signals["rt"].type is SignalType.TEXT
    assert dome.commands["open"].target == "dome_servcli client open {parameters}"
    goto = site.devices["telescope"].commands["goto"]
    assert [(a.field, a.minimum, a.maximum) for a in goto.arguments.values()] == [
        ("ra", 0.0, 24.0),
        ("dec", -90.0, 90.0),
    ]
    assert set(site.devices["telescope"].signals) == {"getcoord", "altitude", "azimuth"}
    assert load_site(dump_site(site)) == site


def test_a_description_names_the_file_and_may_say_more_of_a_device(tmp_path: Path) -> None:
    (tmp_path / "commands.json").write_text(RECORDED.read_text())
    (tmp_path / "site.yaml").write_text(
        "talaia: 1\nsite: obs\nname: Obs\n"
        "connections: {old: {kind: process, file: commands.json, prefix: talaia sim run}}\n"
        "devices: {weather: {name: Station, connection: old}}\n"
    )
    site = read_site(tmp_path / "site.yaml")
    assert check_site(site) == []
    assert list(site.devices) == ["dome", "weather", "telescope"]
    assert site.devices["weather"].name == "Station"
    connection = site.connections["old"]
    assert isinstance(connection, ProcessConnection)
    assert connection.prefix == "talaia sim run"
    (tmp_path / "commands.json").write_text('{"command": {"ros": "ros2 run"}, "devices": {')
    with pytest.raises(DescriptionError, match=r"commands\.json: line 1, column \d+: is not JSON"):
        read_site(tmp_path / "site.yaml")


def test_a_json_file_alone_is_enough(tmp_path: Path) -> None:
    path = tmp_path / "My observatory 2.json"
    path.write_text(RECORDED.read_text())
    assert read_site(path).site == "my_observatory"


@pytest.mark.parametrize(
    ("text", "where", "said"),
    [
        ("", "line 1, column 1", "is not JSON"),
        ("[1]", "$", "expected an object {…}, found list"),
        ("{}", "$.devices", "found nothing"),
        ('{"devices": {}}', "$.devices", "there is no device"),
        ('{"devices": {"a": {}}, "command": {"ros2": "x"}}', "$.command.ros2", "unknown key"),
        ('{"devices": {"a": 3}}', "$.devices.a", "found int"),
        (
            '{"devices": {"a": {"commands": {"open": ["sh", "-c"]}}}}',
            "$.devices.a.commands.open",
            "expected a text, found ['sh', '-c']",
        ),
        (
            '{"devices": {"a": {"messages": {"x": {}}}}}',
            "$.devices.a.messages.x",
            "there is no commands.info.x",
        ),
        ('{"devices": {"a": {}, "a": {}}}', "$", "the key 'a' is written twice"),
        ("[" * 100_000, "$", "nested too deeply"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(text: str, where: str, said: str) -> None:
    with pytest.raises(DescriptionError) as caught:
        read_classic(text)
    assert caught.value.where == where
    assert said in str(caught.value)


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["commands", "info", "messages", "a", "open"]), inner)
    ),
    max_leaves=12,
)


@given(st.dictionaries(st.sampled_from(["command", "devices"]), anything))
def test_no_json_breaks_the_reader(document: dict[str, object]) -> None:
    with contextlib.suppress(DescriptionError):
        assert read_classic(json.dumps(document)).devices
