"""Forms come from the model: each field shows its value and reads back the same."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from talaia.configurator.description_paths import value_at, with_value
from talaia.configurator.errors import BadValue
from talaia.configurator.form_rows import (
    Row,
    RowKind,
    parse_text,
    rows_at,
    rows_of,
    shown_text,
    stored_value,
    value_of,
)
from talaia.model.detection import Detect
from talaia.model.site import Argument, Command, Device, Drive, Signal, Site, Stream
from talaia.model.yaml_text.load import load_site, read_site

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*/site.yaml"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda each: each.parent.name)
def test_every_field_of_every_example_reads_back_as_it_is_shown(path: Path) -> None:
    site = read_site(path)
    things: list[tuple[str, ...]] = [()]
    for word, device in site.devices.items():
        things.append(("devices", word))
        things += [("devices", word, "signals", each) for each in device.signals]
        things += [("devices", word, "streams", each) for each in device.streams]
        things += [("devices", word, "commands", each) for each in device.commands]
    for place in things:
        thing = value_at(site, place)
        for row in rows_at(site, place):
            value = value_of(thing, row)
            assert parse_text(row, shown_text(row, value)) == value


@pytest.mark.parametrize("shape", [Site, Device, Signal, Stream, Command, Argument, Drive])
def test_every_row_has_a_label_and_the_models_own_words_help(shape: type) -> None:
    rows = rows_of(shape)
    assert len({row.path for row in rows}) == len(rows)
    assert all(row.label and row.label[0].isupper() for row in rows)
    assert any(row.help for row in rows)


def test_a_signal_of_ros_is_not_asked_for_what_indi_needs() -> None:
    sites = {each.parent.name: read_site(each) for each in EXAMPLES}
    agv, indi = sites["agv"], sites["indi"]
    keys = {row.key for row in rows_at(agv, ("devices", "base", "signals", "speed"))}
    assert {"name", "unit", "source.topic", "source.field", "primary"} <= keys
    assert not {"source.property", "source.run", "states", "yaw_from"} & keys
    keys = {row.key for row in rows_at(agv, ("devices", "base", "signals", "wandering"))}
    assert "states" in keys
    assert "unit" not in keys
    device, signal = next(
        (device, signal)
        for device, described in indi.devices.items()
        for signal, source in described.signals.items()
        if source.source.property is not None
    )
    keys = {row.key for row in rows_at(indi, ("devices", device, "signals", signal))}
    assert "source.property" in keys
    assert "source.topic" not in keys


def test_a_camera_has_a_switch_for_object_detection_and_its_fields_while_it_is_on() -> None:
    agv = read_site(next(each for each in EXAMPLES if each.parent.name == "agv"))
    place = ("devices", "camera", "streams", "front")
    agv = with_value(agv, (*place, "detect"), None)
    switch = next(row for row in rows_at(agv, place) if row.key == "detect")
    assert value_of(value_at(agv, place), switch) is False
    keys = {row.key for row in rows_at(agv, place)}
    assert not [key for key in keys if key.startswith("detect.") or key == "source.sees"]
    on = with_value(agv, (*place, *switch.path), stored_value(switch, parse_text(switch, "true")))
    assert value_at(on, (*place, "detect")) == Detect()
    rows = {row.key: row for row in rows_at(on, place)}
    assert {"detect.classes", "detect.confidence", "detect.at", "detect.model"} <= set(rows)
    assert parse_text(rows["detect.classes"], "person\nwine glass\n") == ("person", "wine glass")
    assert (
        with_value(on, (*place, *switch.path), stored_value(switch, parse_text(switch, "false")))
        == agv
    )


ANY = Row(("default",), "Default", RowKind.ANY, optional=True)


@given(
    st.one_of(
        st.booleans(),
        st.integers(-(2**63), 2**63),
        st.floats(allow_nan=False, allow_infinity=False),
        st.from_regex(r"[A-Za-z0-9_. :/-]{1,20}", fullmatch=True).map(str.strip).filter(bool),
    )
)
def test_a_fixed_value_keeps_its_kind(value: object) -> None:
    back = parse_text(ANY, shown_text(ANY, value))
    assert back == value
    assert type(back) is type(value)


@pytest.mark.parametrize(
    ("kind", "text", "said"),
    [
        (RowKind.NUMBER, "fast", "expected a number, found 'fast'"),
        (RowKind.NUMBER, "", "expected a number"),
        (RowKind.NUMBER, "inf", "finite"),
        (RowKind.INTEGER, "1.5", "whole number"),
        (RowKind.PAIRS, "open", "word: value"),
        (RowKind.PAIRS, "a: 1\na: 2", "twice"),
    ],
)
def test_what_is_no_value_is_told_with_what_was_expected(
    kind: RowKind, text: str, said: str
) -> None:
    with pytest.raises(BadValue, match=said):
        parse_text(Row(("x",), "X", kind), text)


def test_a_decimal_comma_is_understood() -> None:
    assert parse_text(Row(("x",), "X", RowKind.NUMBER), "0,25") == 0.25


def test_form_asks_for_what_the_connection_of_a_device_knows() -> None:
    site = load_site("""
talaia: 1
site: test
name: Test
connections:
  broker: {kind: mqtt, url: "mqtt://broker"}
  station: {kind: http, url: "http://station"}
devices:
  a: {name: A, connection: broker, signals: {x: {name: X, source: {topic: a/b, path: c}}}}
  b: {name: B, connection: station, signals: {x: {name: X, source: {get: /a, path: c}}}}
  c: {name: C, connection: broker, signals: {x: {name: X, source: {expression: "{a/x} * 2"}}}}
""")
    own = {"source.topic", "source.path", "source.get", "source.run", "source.field"}
    for device, expected in (
        ("a", {"source.topic", "source.path"}),
        ("b", {"source.get", "source.path"}),
    ):
        keys = {row.key for row in rows_at(site, ("devices", device, "signals", "x"))}
        assert keys & own == expected
        assert "source.expression" in keys
    rows = {row.key: row for row in rows_at(site, ("devices", "c", "signals", "x"))}
    assert value_of(site.devices["c"].signals["x"], rows["source.expression"]) == "{a/x} * 2"
