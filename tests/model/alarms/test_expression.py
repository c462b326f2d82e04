"""The text of a condition: what it says, what it cannot know, and where a mistake is."""

from __future__ import annotations

import math
from contextlib import suppress

import pytest
from hypothesis import given, strategies as st

from talaia.model.alarms.expression import MAX_LENGTH, ExpressionError, ValueKind, parse_condition

KINDS = {"a/b": ValueKind.NUMBER, "a/c": ValueKind.NUMBER, "a/s": ValueKind.TEXT}


@pytest.mark.parametrize(
    ("text", "values", "holds"),
    [
        ("{a/b} < 11.5", {"a/b": 11.0}, True),
        ("{a/b} < 11.5", {"a/b": 12.0}, False),
        ('{a/b} < 11.5 and not {a/s} == "on"', {"a/b": 11.0, "a/s": "on"}, False),
        ("max({a/b}, {a/c}) - min({a/b}, {a/c}) > 2", {"a/b": 1.0, "a/c": 4.0}, True),
        ("abs({a/b}) >= 1.5e0", {"a/b": -2.0}, True),
        ("2 + 3 * 4 == 14 and (2 + 3) * 4 == 20 and 8 / 4 / 2 == 1 and 5 - 3 - 1 == 1", {}, True),
        ("1 < 2 or 1 > 2 and 1 > 2", {}, True),
        ("not not -{a/b} == --2", {"a/b": -2.0}, True),
        # What is not known stays so, unless the rest decides.
        ("{a/b} > 1", {}, None),
        ("{a/b} > 1", {"a/b": math.nan}, None),
        ("{a/b} / {a/c} > 1", {"a/b": 1.0, "a/c": 0.0}, None),
        ("1e300 * 1e300 > 1", {}, None),
        ("not {a/b} > 1", {}, None),
        ("{a/b} > 1 and {a/c} > 1", {"a/c": 0.0}, False),
        ("{a/b} > 1 and {a/c} > 1", {"a/c": 2.0}, None),
        ("{a/b} > 1 or {a/c} > 1", {"a/c": 2.0}, True),
        ("{a/b} > 1 or {a/c} > 1", {"a/c": 0.0}, None),
    ],
)
def test_condition_is_judged(text, values, holds) -> None:
    assert parse_condition(text, KINDS).evaluate_expression(values) is holds


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{a/x} > 1", "at letter 1: there is no signal 'a/x'"),
        ("1 < 2 < 3", "at letter 7: write two comparisons with `and` between them"),
        ("a > 1", "at letter 1: 'a' is no signal: those stand in braces"),
        ("1 >", "at letter 4: it ends too soon"),
        ("{a/b}", "at letter 1: expected a yes or no, found a number"),
        ('{a/s} < "x"', "at letter 7: texts can only be == or !="),
        ('{a/s} == "x" + 1', "at letter 10: expected a number, found a text"),
        ("{a/s} == 1", "at letter 7: a text cannot be compared with a number"),
        ("abs(1, 2) > 1", "at letter 1: abs takes one number"),
        ("1 > 2)", "at letter 6: ')' is not expected here"),
        ("__import__(1)", "at letter 1: there is no function '__import__'"),
        ("__import__('os')", 'at letter 12: "\'" is not expected here'),
        ("1 > 2; 1", "at letter 6: ';' is not expected here"),
        ("(" * 30 + "1 > 2", "nested deeper than 24 levels"),
        ("1 > " + "+".join(["1"] * 200), "too many sums and products"),
        ("1 > 1" + " " * MAX_LENGTH, f"longer than {MAX_LENGTH} letters"),
    ],
)
def test_mistake_is_told_with_its_place(text, said) -> None:
    with pytest.raises(ExpressionError) as told:
        parse_condition(text, KINDS)
    assert said in str(told.value)


_WORDS = ["{a/b}", "{a/s}", "1", "0", '"on"', "and", "or", "not", "(", ")", "<", "==", "+", "-"]
_WORDS += ["*", "/", "abs(", "min(", ",", "{", '"', "x", "1e999", "."]


@given(st.lists(st.sampled_from(_WORDS), max_size=30).map(" ".join), st.floats())
def test_nothing_but_a_condition_or_its_mistake_comes_of_any_text(text, number) -> None:
    with suppress(ExpressionError):
        assert parse_condition(text, KINDS).evaluate_expression({"a/b": number, "a/s": "on"}) in {
            True,
            False,
            None,
        }


@given(st.text(max_size=60))
def test_hostile_text_is_refused_and_nothing_else(text) -> None:
    with suppress(ExpressionError):
        parse_condition(text, KINDS)
