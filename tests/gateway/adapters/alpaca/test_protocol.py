"""What is asked and what an answer says: ASCOM's words as bytes."""

from __future__ import annotations

import contextlib
import json
from urllib.parse import parse_qs

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.adapters.alpaca.protocol import (
    AlpacaRefused,
    parse_configured,
    parse_discovery,
    parse_value,
    property_path,
    put_form,
)


def answer(**words: object) -> bytes:
    return json.dumps(words).encode()


def test_a_question_names_the_property_its_argument_and_who_asks() -> None:
    path = property_path("switch/0/getswitchvalue?Id=2", 7, 9)
    assert path == "/api/v1/switch/0/getswitchvalue?Id=2&ClientID=7&ClientTransactionID=9"


def test_parameters_are_written_so_that_every_driver_reads_them() -> None:
    fields = parse_qs(put_form({"Light": True, "Duration": 1e-7, "BinX": 2}, 1, 2).decode())
    assert (fields["Light"], fields["Duration"], fields["BinX"]) == (["True"], ["0.0000001"], ["2"])


@pytest.mark.parametrize(
    ("number", "refused", "words"),
    [(0x408, True, "it is parked"), (0x40B, True, "cannot be done now"), (0x500, False, "driver")],
)
def test_an_error_of_ascom_is_told_in_words_and_as_refused_or_failed(
    number: int, *, refused: bool, words: str
) -> None:
    said = answer(ErrorNumber=number, ErrorMessage="no\nway", Value=None)
    with pytest.raises(AlpacaRefused) as raised:
        parse_value(said, 1)
    assert raised.value.refused is refused
    assert words in str(raised.value)
    assert str(raised.value).endswith(f"(ASCOM error 0x{number:X}): no way")


def test_an_answer_to_another_question_does_not_count() -> None:
    with pytest.raises(AlpacaRefused, match="another question"):
        parse_value(answer(Value=True, ClientTransactionID=4), 5)
    assert parse_value(answer(Value=True, ClientTransactionID=5), 5) is True
    # Servers that leave it out are believed.
    assert parse_value(answer(Value=2.5), 5) == 2.5


@given(st.binary(max_size=200))
def test_any_bytes_are_a_value_or_a_problem_in_words(data: bytes) -> None:
    for parse in (lambda: parse_value(data, 1), lambda: parse_configured(data)):
        with contextlib.suppress(AlpacaRefused):
            parse()
    port = parse_discovery(data)
    assert port is None or 1 <= port <= 65_535


def test_only_what_can_stand_in_an_address_is_a_device() -> None:
    listed = [
        {"DeviceName": "Mount", "DeviceType": "Telescope", "DeviceNumber": 0, "UniqueID": "x"},
        {"DeviceName": "Evil", "DeviceType": "../admin", "DeviceNumber": 0},
        {"DeviceName": "Odd", "DeviceType": "Dome", "DeviceNumber": -1},
    ]
    found = parse_configured(answer(Value=listed))
    assert [(one.name, one.device) for one in found] == [("Mount", "telescope/0")]


def test_a_discovery_answer_names_a_port() -> None:
    assert parse_discovery(b'{"AlpacaPort": 11111}') == 11111
    assert parse_discovery(b'{"AlpacaPort": 0}') is None
    assert parse_discovery(b"alpacadiscovery1") is None


def test_answer_that_is_no_text_is_refused() -> None:
    listed = (
        b'{"Value":[{"DeviceName":"a","DeviceType":"Do\xace","DeviceNumber":0,"UniqueID":"x"}]}'
    )
    with pytest.raises(AlpacaRefused):
        parse_configured(listed)
    with pytest.raises(AlpacaRefused):
        parse_value(b'{"Value":[{"DeviceName\xae:"a","DeviceType":"Dome",', 1)
