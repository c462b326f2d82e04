"""The description that is open: undo, problems with their places, and the text to save."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest
from hypothesis import given, strategies as st

from talaia.configurator.description_paths import find_spot, remove_value, value_at, with_value
from talaia.configurator.document import MAX_STEPS, Document
from talaia.configurator.edits import new_site
from talaia.configurator.errors import NoSuchPlace
from talaia.model.yaml_text.load import load_site, read_site

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*/site.yaml"))
AGV = next(each for each in EXAMPLES if each.parent.name == "agv").read_text()
SPEED = ("devices", "base", "signals", "speed")


def named(document: Document, name: str) -> bool:
    return document.apply_change("rename", msgspec.structs.replace(document.site, name=name))


@given(st.lists(st.one_of(st.none(), st.booleans(), st.sampled_from(["a", "b", "c", "d"]))))
def test_undo_and_redo_walk_the_steps_as_a_list_would(moves: list[str | bool | None]) -> None:
    document = Document(new_site("a", "start", "UTC"))
    steps, now = ["start"], 0
    for move in moves:
        if isinstance(move, str):
            if named(document, move):
                steps[now + 1 :] = [move]
                now += 1
        elif move:
            now += document.redo()
        else:
            now -= document.undo()
        assert document.site.name == steps[now]
        assert bool(document.undoes) == (now > 0)
        assert bool(document.redoes) == (now + 1 < len(steps))


def test_the_steps_that_are_kept_are_bounded() -> None:
    document = Document(new_site("a", "start", "UTC"))
    for number in range(MAX_STEPS + 20):
        named(document, str(number))
    undone = 0
    while document.undo():
        undone += 1
    assert undone == MAX_STEPS
    assert document.site.name == "19"


def test_a_document_is_changed_until_it_is_saved_or_all_is_taken_back() -> None:
    document = Document.of_text(AGV)
    assert not document.is_changed
    named(document, "Other")
    assert document.is_changed
    document.undo()
    assert not document.is_changed
    document.redo()
    document.was_saved(document.to_yaml())
    assert not document.is_changed
    document.undo()
    assert document.is_changed


def test_a_new_document_that_nobody_touched_needs_no_saving() -> None:
    document = Document(new_site("robot", "Robot", "UTC"))
    assert not document.is_changed
    named(document, "Other")
    assert document.is_changed
    assert load_site(document.to_yaml()) == document.site


def test_saving_changes_one_line_and_leaves_the_comments() -> None:
    document = Document.of_text(AGV)
    document.apply_change("limit", with_value(document.site, (*SPEED, "maximum"), 0.5))
    before, after = AGV.splitlines(), document.to_yaml().splitlines()
    assert [(a, b) for a, b in zip(before, after, strict=True) if a != b] == [
        ("        maximum: 0.25", "        maximum: 0.5")
    ]


@pytest.mark.parametrize(
    ("path", "value", "node", "field"),
    [
        ((*SPEED, "unit"), "metres in one second of time", SPEED, ("unit",)),
        ((*SPEED, "minimum"), 7.0, SPEED, ("minimum",)),
        ((*SPEED, "source", "topic"), "odom", SPEED, ("source", "topic")),
        (
            ("devices", "base", "drive", "max_turn"),
            -1.0,
            ("devices", "base", "drive"),
            ("max_turn",),
        ),
        (
            ("devices", "base", "drive", "stop", "confirmed_by"),
            ("base/nothing",),
            ("devices", "base", "drive"),
            ("stop", "confirmed_by"),
        ),
        (
            ("devices", "base", "commands", "wander", "arguments", "active", "default"),
            "yes",
            ("devices", "base", "commands", "wander", "arguments", "active"),
            ("default",),
        ),
        (("zone",), "Europe/Madrit", (), ("zone",)),
        (("devices",), {}, (), ("devices",)),
    ],
)
def test_each_problem_leads_to_the_thing_and_its_field(
    path: tuple[str, ...], value: object, node: tuple[str, ...], field: tuple[str, ...]
) -> None:
    document = Document.of_text(AGV)
    assert document.problems == ()
    document.apply_change("break", with_value(document.site, path, value))
    first = document.problems[0]
    assert (first.spot.node, first.spot.field) == (node, field)
    assert str(first)
    document.undo()
    assert document.problems == ()


def test_a_key_with_dots_in_it_is_found_all_the_same() -> None:
    site = load_site(AGV)
    odd = with_value(site, ("devices", "a.b [c]"), site.devices["power"])
    spot = find_spot(odd, "$.devices.a.b [c].signals.charge.unit")
    assert spot.node == ("devices", "a.b [c]", "signals", "charge")
    assert spot.field == ("unit",)


def test_a_place_that_is_not_there_is_told_with_its_path() -> None:
    site = load_site(AGV)
    with pytest.raises(NoSuchPlace, match=r"\$\.devices\.base\.signals\.sped"):
        value_at(site, ("devices", "base", "signals", "sped", "unit"))
    with pytest.raises(NoSuchPlace):
        remove_value(site, ("devices", "nowhere"))


def test_devices_of_a_command_file_are_checked_but_not_saved(tmp_path: Path) -> None:
    (tmp_path / "dome.json").write_text(
        '{"command": {"ros": "ros2 run"}, "devices": {"dome": {"commands": {"open": "dome open"}}}}'
    )
    text = (
        "talaia: 1\nsite: dome\nname: Dome\nconnections:\n  c: {kind: process, file: dome.json}\n"
    )
    (tmp_path / "site.yaml").write_text(text)
    elsewhere = read_site(tmp_path / "site.yaml").devices
    document = Document.of_text(text, elsewhere)
    assert document.problems == ()
    named(document, "Big dome")
    assert "devices" not in document.to_yaml()


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda each: each.parent.name)
def test_every_example_opens_without_a_problem_and_saves_as_it_was(path: Path) -> None:
    document = Document.of_text(path.read_text(), read_site(path).devices)
    assert document.problems == ()
    assert document.to_yaml() == path.read_text()
