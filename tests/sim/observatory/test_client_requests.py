"""The command-line clients' words."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given, strategies as st

from talaia.sim.observatory.client_requests import (
    ClientRequest,
    InvalidRequest,
    parse_number,
    parse_request,
)
from talaia.sim.observatory.servers.devices import DEVICES

pytestmark = pytest.mark.pure


def test_the_founding_words_are_requests() -> None:
    assert parse_request("dome", ["open"]) == ClientRequest("dome", "trigger", "open", {})
    assert parse_request("weather", ["info"]).kind == "trigger"
    goto = parse_request("telescope", ["goto", "5:30:00", "-5.5"])
    assert goto == ClientRequest("telescope", "ask", "goto", {"ra": 5.5, "dec": -5.5})
    assert parse_request("pdu", ["outlet3", "off"]).values == {"data": False}


@pytest.mark.parametrize(
    ("device", "words", "said"),
    [
        ("dome", ["test"], "Invalid dome action"),
        ("dome", [], "Invalid dome action"),
        ("telescope", ["goto"], "goto: expected RA DEC"),
        ("telescope", ["goto", "5.5", "5; rm -rf /"], "'5; rm -rf /' is not a number"),
        ("telescope", ["goto", "nan", "1"], "'nan' is not a number"),
        ("dome", ["open", "; rm -rf /"], "Invalid dome action"),
    ],
)
def test_wrong_words_are_told_and_ask_for_nothing(device: str, words: list[str], said: str) -> None:
    with pytest.raises(InvalidRequest, match="^" + said.replace("(", r"\(")):
        parse_request(device, words)


@given(st.sampled_from(DEVICES), st.lists(st.text(max_size=8), max_size=4))
def test_no_words_break_the_reader(device: str, words: list[str]) -> None:
    with contextlib.suppress(InvalidRequest):
        assert parse_request(device, words).device == device


@given(st.floats(-1e6, 1e6))
def test_a_number_is_read_as_it_was_written(value: float) -> None:
    assert parse_number(repr(value)) == value


def test_minutes_and_seconds_are_sixtieths() -> None:
    assert parse_number("-0:30:36") == pytest.approx(-0.51)
