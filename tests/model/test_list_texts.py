"""Lists as one text: what people type, what is wrong with it in words, and what is shown."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given, strategies as st

from talaia.model.arguments import fields_of
from talaia.model.checks.site_checks import check_site
from talaia.model.closed_lists import ArgumentType, CommandKind
from talaia.model.list_texts import list_text, parse_list
from talaia.model.site import Argument, Command
from talaia.model.yaml_text.load import load_site

KINDS = ArgumentType


@pytest.mark.parametrize(
    ("kind", "text", "values"),
    [
        (KINDS.NUMBERS, "1, -2.5,.5", [1.0, -2.5, 0.5]),
        (KINDS.NUMBERS, " [1, 2e3] ", [1.0, 2000.0]),
        (KINDS.NUMBERS, "", []),
        (KINDS.INTEGERS, "9223372036854775807, 2.0", [2**63 - 1, 2]),
        (KINDS.BOOLEANS, "True, off", [True, False]),
        (KINDS.TEXTS, "front left, 12", ["front left", "12"]),
        (KINDS.TEXTS, '["a, b", ""]', ["a, b", ""]),
        (KINDS.BYTES, "0, 255", [0, 255]),
    ],
)
def test_a_list_is_read_with_commas_or_as_json(
    kind: ArgumentType, text: str, values: list[object]
) -> None:
    found = parse_list(kind, text)
    assert found == values
    assert [type(one) for one in found] == [type(one) for one in values]


@pytest.mark.parametrize(
    ("kind", "text", "problem"),
    [
        (KINDS.NUMBERS, "1, two", "item 2: expected a number, found 'two'"),
        (KINDS.NUMBERS, "1,,2", "item 2: expected a number, found ''"),
        (KINDS.NUMBERS, "nan", "item 1: expected a number, found nan"),
        (KINDS.NUMBERS, "1_000", "item 1: expected a number, found '1_000'"),
        (KINDS.NUMBERS, "true", "item 1: expected a number, found True"),
        (KINDS.NUMBERS, "[[1]]", "item 1: expected a number, found [1]"),
        (KINDS.INTEGERS, "1.5", "item 1: expected a whole number, found 1.5"),
        (KINDS.INTEGERS, "inf", "item 1: expected a whole number, found inf"),
        (KINDS.INTEGERS, str(2**63), f"item 1: expected a whole number, found {2**63}"),
        (KINDS.BOOLEANS, "1", "item 1: expected true or false, found 1"),
        (KINDS.TEXTS, "[1]", "item 1: expected a text, found 1"),
        (KINDS.BYTES, "256", "item 1: expected a whole number from 0 to 255, found 256"),
    ],
)
def test_what_does_not_fit_is_said_with_its_place(
    kind: ArgumentType, text: str, problem: str
) -> None:
    assert parse_list(kind, text) == problem


def test_a_json_list_that_does_not_end_is_said() -> None:
    assert "no JSON list" in str(parse_list(KINDS.NUMBERS, "[1, 2"))


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False)))
def test_what_is_shown_can_be_typed_again(values: list[float]) -> None:
    assert parse_list(KINDS.NUMBERS, list_text(values)) == values


@given(st.lists(st.text()))
def test_texts_that_are_shown_can_be_typed_again(values: list[str]) -> None:
    assert parse_list(KINDS.TEXTS, list_text(values)) == values


def test_bytes_are_shown_as_numbers_and_truths_as_json_has_them() -> None:
    assert list_text([b"\x00", b"\xff"]) == "[0, 255]"
    assert json.loads(list_text([True, 1.0, "ä"])) == [True, 1.0, "ä"]


def command(**more: Any) -> Command:
    argument = Argument(type=KINDS.NUMBERS, field="gains", **more)
    return Command(
        name="Set", kind=CommandKind.PARAMETER, target="/n", arguments={"value": argument}
    )


def test_the_range_of_a_list_is_that_of_its_items() -> None:
    inside = command(minimum=0, maximum=1)
    assert fields_of(inside, {"value": "0.5,1"}) == {"gains": "[0.5, 1.0]"}
    assert fields_of(inside, {"value": "0.5,2"}) == "value: item 2: 2.0 is above 1"
    assert fields_of(inside, {"value": 1.5}) == "value: expected a list as text, found 1.5"
    assert "at most 4 characters" in str(fields_of(command(max_length=4), {"value": "1,2,3"}))


SITE = """
talaia: 1
site: robot
name: Robot
ros2: {}
devices:
  base:
    name: Base
    commands:
      tune:
        name: Tune
        kind: %s
        target: /base
        type: %s
        arguments: {gains: {type: numbers, field: gains, default: "%s"}}
"""


def findings(*words: str) -> list[str]:
    return [str(found) for found in check_site(load_site(SITE % words))]


def test_only_parameters_are_lists_and_a_default_is_one() -> None:
    assert findings("parameter", '""', "1, 2") == []
    (found,) = findings("parameter", '""', "1, x")
    assert "item 2: expected a number" in found
    (found,) = findings("service", "a_msgs/srv/A", "1")
    assert "only parameters of ROS nodes are lists" in found
