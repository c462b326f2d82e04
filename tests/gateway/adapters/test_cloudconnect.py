"""CloudConnect's /metric text, with either kind of quotes."""

import json

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.adapters.cloudconnect import parse_metric
from talaia.gateway.errors import FieldError

pytestmark = pytest.mark.pure

names = st.text(min_size=1, max_size=30).filter(lambda text: text.strip() == text)
numbers = st.floats(allow_nan=False) | st.integers(-(2**53), 2**53)


@given(names, numbers)
def test_both_quotings_say_the_same(name: str, magnitude: float) -> None:
    row = {"name": name, "magnitude": magnitude}
    assert parse_metric(json.dumps(row)) == (name, float(magnitude))
    if abs(magnitude) != float("inf"):
        assert parse_metric(str(row)) == (name, float(magnitude))


def test_texts_as_met_in_the_field() -> None:
    assert parse_metric("{'name': 'speed1', 'magnitude': 1.4}") == ("speed1", 1.4)
    assert parse_metric('{"name": "ultrasonic2", "magnitude": "0.8"}') == ("ultrasonic2", 0.8)
    assert parse_metric("  {'name': 'light1', 'magnitude': True}\n") == ("light1", 1.0)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "speed1 1.4",
        "[]",
        "{'name': 'a'}",
        "{'magnitude': 1}",
        "{'name': '', 'magnitude': 1}",
        "{'name': 'a', 'magnitude': [1]}",
        "{'name': 'a', 'magnitude': 'fast'}",
        "{'name': 'a', 'magnitude': None}",
        "{'name': 'a', 'magnitude': __import__('os')}",
        "(" * 3000,
        "{'name': 'a', 'magnitude': " + "9" * 4000 + "}",
        "x" * 5000,
    ],
)
def test_what_is_no_metric_is_refused(text: str) -> None:
    with pytest.raises(FieldError):
        parse_metric(text)


@given(st.text(max_size=200))
def test_parser_allows_only_its_own_error(text: str) -> None:
    try:
        metric = parse_metric(text)
    except FieldError:
        return
    assert isinstance(metric.magnitude, float)
