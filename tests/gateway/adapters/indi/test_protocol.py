"""INDI's wire: what real drivers sent, what no driver should, and what we send back."""

# ruff: noqa: E501, S314 - what is parsed here we have written ourselves
import base64
import math
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.adapters.indi import numbers
from talaia.gateway.adapters.indi.errors import IndiError
from talaia.gateway.adapters.indi.protocol import (
    MAX_PENDING,
    BlobEnd,
    BlobHead,
    BlobPart,
    Deleted,
    DriverMessage,
    Event,
    IndiParser,
    PropertyState,
    SwitchRule,
    Vector,
    VectorKind,
    ask_blobs,
    ask_properties,
    new_vector,
)

RECORDED = Path(__file__).parent / "recorded"
# What XML can carry as it is; line ends and tabs in an attribute become blanks by its rules.
NAMES = st.text(
    st.characters(exclude_categories=("Cs", "Cc"), exclude_characters="\ufffe\uffff\x85\u2028"),
    min_size=1, max_size=30,
)  # fmt: skip


def read(data: bytes) -> list[Event]:
    return IndiParser().parse_data(data)


def blob_of(events: list[Event]) -> bytes:
    return b"".join(each.data for each in events if isinstance(each, BlobPart))


def test_all_that_eleven_real_drivers_say_is_read() -> None:
    events = read((RECORDED / "simulators.xml").read_bytes())
    vectors = [each for each in events if isinstance(each, Vector)]
    assert len(vectors) == 321
    assert len({each.device for each in vectors}) == 11
    pointing = next(each for each in vectors if each.new and each.name == "EQUATORIAL_EOD_COORD")
    assert [each.name for each in pointing.elements] == ["RA", "DEC"]
    assert (pointing.elements[0].minimum, pointing.elements[0].maximum) == (0, 24)
    shutter = next(each for each in vectors if each.new and each.name == "DOME_SHUTTER")
    assert shutter.rule is SwitchRule.AT_MOST_ONE
    assert [each.value for each in shutter.elements] == [False, True]
    assert any(
        isinstance(each, DriverMessage) and "Dome is unparked" in each.message for each in events
    )


@given(st.lists(st.integers(1, 400), min_size=1, max_size=60))
def test_where_the_bytes_are_cut_changes_nothing(cuts: list[int]) -> None:
    data = (RECORDED / "dome-park.xml").read_bytes()
    reader, parts, at = IndiParser(), [], 0
    for cut in [*cuts, len(data)]:
        parts += reader.parse_data(data[at : at + cut])
        at += cut
    assert parts == read(data)


def test_message_ends_where_the_element_does_and_waits_for_nothing_more() -> None:
    reader = IndiParser()
    assert reader.parse_data(b'<delProperty device="Dome"') == []
    assert reader.parse_data(b"/>") == [Deleted("Dome")]


@given(st.binary(max_size=300))
def test_reader_allows_only_its_own_error(data: bytes) -> None:
    try:
        read(data)
    except IndiError:
        return


@given(st.text(max_size=200))
def test_reader_allows_only_its_own_error_inside_a_vector(text: str) -> None:
    head = '<defTextVector device="D" name="P" state="Ok" perm="ro"><defText name="E">'
    try:
        read(f"{head}{text}</defText></defTextVector>".encode("utf-8", "replace"))
    except IndiError:
        return


@pytest.mark.parametrize(
    "data",
    [
        b'<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa">]>',
        b'<!ENTITY a "b">',
        b"</indi>",
        b"<a><b><c><d/></c></b></a>",
        b"<a></b>",
        b'<defTextVector device="D" name="P">' + b"<defText name='E'>x</defText>" * 5000,
        b'<defTextVector device="D" name="P"><defText name="E">' + b"x" * 20_000,
        b'<message device="' + b"x" * (MAX_PENDING + 10),
        b"<setTextVector device='D' name='P'>&lol;</setTextVector>",
    ],
    ids=["doctype", "entity", "root", "depth", "mismatch", "elements", "text", "word", "undefined"],
)
def test_what_indi_does_not_allow_is_refused_before_it_costs_anything(data: bytes) -> None:
    with pytest.raises(IndiError):
        read(data)


def test_bytes_that_are_no_text_do_not_end_the_connection() -> None:
    events = read(b'<message device="Caf\xe9" message="bell \x07 rings"/>')
    assert events == [DriverMessage("Caf\ufffd", "bell \ufffd rings")]


def blob(data: bytes, size: str = "") -> bytes:
    body = base64.encodebytes(data)
    return (
        b'<setBLOBVector device="CCD" name="CCD1" state="Ok">\n<oneBLOB name="CCD1" size="'
        + (size or str(len(data))).encode()
        + b'" format=".fits">\n'
        + body
        + b"</oneBLOB></setBLOBVector>"
    )


@given(st.binary(max_size=2000), st.integers(1, 200))
def test_picture_comes_whole_however_it_is_cut(data: bytes, step: int) -> None:
    raw, reader, events = blob(data), IndiParser(), []
    for at in range(0, len(raw), step):
        events += reader.parse_data(raw[at : at + step])
    assert events[0] == BlobHead("CCD", "CCD1", "CCD1", ".fits", len(data))
    assert blob_of(events) == data
    assert BlobEnd("") in events


def test_picture_passes_in_pieces_and_is_not_kept() -> None:
    reader = IndiParser()
    raw = blob(bytes(3_000_000))
    largest = 0
    for at in range(0, len(raw), 65_536):
        for event in reader.parse_data(raw[at : at + 65_536]):
            if isinstance(event, BlobPart):
                largest = max(largest, len(event.data))
    assert 0 < largest <= 65_536


def test_picture_over_the_bound_is_passed_over_and_says_so() -> None:
    reader = IndiParser(max_blob=1000)
    events = reader.parse_data(blob(bytes(5000)) + b'<delProperty device="X"/>')
    assert len(blob_of(events)) <= 1000
    assert any(isinstance(each, BlobEnd) and "larger" in each.problem for each in events)
    assert events[-1] == Deleted("X")


def test_picture_cut_short_says_so() -> None:
    raw = b'<setBLOBVector device="C" name="B"><oneBLOB name="B" size="9" format=".fits">QUJ</oneBLOB>'
    assert any(isinstance(each, BlobEnd) and "cut short" in each.problem for each in read(raw))


@given(NAMES, NAMES, NAMES, st.text(max_size=50))
def test_hostile_names_and_texts_stay_what_they_are(
    device: str, name: str, element: str, text: str
) -> None:
    document = ElementTree.fromstring(new_vector(VectorKind.TEXT, device, name, {element: text}))
    assert document.tag == "newTextVector"
    assert [each.tag for each in document] == ["oneText"]
    assert document.get("device") == device
    assert document.get("name") == name
    assert document[0].get("name") == element
    for asked in (ask_properties(device, name), ask_blobs(device)):
        assert ElementTree.fromstring(asked).get("device") == device


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_never_sent(value: float) -> None:
    with pytest.raises(ValueError, match="not a number"):
        new_vector(VectorKind.NUMBER, "D", "P", {"E": value})


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_number_is_read_back_as_it_was_written(value: float) -> None:
    assert numbers.parse_number(numbers.write_number(value)) == value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12:30:00", 12.5), ("-0:30", -0.5), ("12 30 36", 12.51), ("10;15", 10.25),
        (" +1.5e3 ", 1500.0), ("-12:30:36.0", -12.51), (".5", 0.5), ("7.", 7.0),
    ],
)  # fmt: skip
def test_sexagesimal_and_plain_numbers_are_read(text: str, value: float) -> None:
    assert numbers.parse_number(text) == pytest.approx(value)


@pytest.mark.parametrize("text", ["", "nan", "inf", "-inf", "abc", "1:2:3:4", "0x10", "1_000", "١"])
def test_what_is_no_number_is_unknown(text: str) -> None:
    value = numbers.parse_number(text)
    assert math.isnan(value) or text == "١"


@pytest.mark.parametrize(
    ("value", "how", "shown"),
    [
        (12.5, "%010.6m", "  12:30:00"), (-0.5, "%9.6m", " -0:30:00"), (5.999999, "%8.6m", " 6:00:00"),
        (1.25, "%5.3m", " 1:15"), (41.2691, "%10.8m", "41:16:08.8"), (41.2691, "%11.9m", "41:16:08.76"),
        (3.14159, "%6.2f", "3.14"), (7.0, "%.f", "7"), (7.0, "%d", "7"), (2.5, "%n%n%n", "2.5"),
        (math.nan, "%6.2f", "nan"), (1.5, "%99999.99f", "1.5"),
    ],
)  # fmt: skip
def test_numbers_are_shown_by_the_drivers_format(value: float, how: str, shown: str) -> None:
    assert numbers.format_number(value, how).strip() == shown.strip()


@given(st.floats(-1e6, 1e6), st.sampled_from([3, 5, 6, 8, 9]))
def test_sexagesimal_is_the_value_to_its_last_digit(value: float, fraction: int) -> None:
    shown = numbers.format_number(value, f"%1.{fraction}m")
    step = {3: 60, 5: 600, 6: 3600, 8: 36_000, 9: 360_000}[fraction]
    assert numbers.parse_number(shown) == pytest.approx(value, abs=0.51 / step + 1e-9)
    assert ":60" not in shown


def test_state_words_are_the_protocols() -> None:
    assert [str(each) for each in PropertyState] == ["Idle", "Ok", "Busy", "Alert"]
