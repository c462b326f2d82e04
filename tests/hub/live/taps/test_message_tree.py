"""Messages as trees: the same values as `rosbags` reads, and bounded whatever comes."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import struct
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from talaia.hub.live.taps.message_tree import tree_reader
from talaia.hub.live.taps.type_texts import MessageUnreadable
from talaia.wire.frames import TapSchema

pytestmark = pytest.mark.pure

RULE = "\n" + "=" * 80 + "\n"
NAME = "demo/msg/Whole"
WHOLE = {
    NAME: (
        "int8 LEVEL=2\nbool on\nuint8 small\nfloat64 wide\nstring name\ndemo/Point where\n"
        "demo/Part[] parts\nfloat32[3] three\nint64[] many\nstring[<=4] words\ndemo/Point[2] ends\n"
        "uint16 last"
    ),
    "demo/msg/Point": "int16 x\nfloat64 y",
    "demo/msg/Part": "string label\ndemo/Point[] path\nuint8 code",
}
FLOATS = st.floats(width=32, allow_nan=False, allow_infinity=False)
SMALL = st.integers(0, 255)
TEXTS = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=12)
POINTS = st.fixed_dictionaries({"x": st.integers(-9, 9), "y": FLOATS})
PARTS = st.fixed_dictionaries({"label": TEXTS, "path": st.lists(POINTS, max_size=3), "code": SMALL})
VALUES = st.fixed_dictionaries(
    {
        "on": st.booleans(),
        "small": SMALL,
        "wide": FLOATS,
        "name": TEXTS,
        "where": POINTS,
        "parts": st.lists(PARTS, max_size=3),
        "three": st.lists(FLOATS, min_size=3, max_size=3),
        "many": st.lists(st.integers(-(2**53), 2**53), max_size=5),
        "words": st.lists(TEXTS, max_size=4),
        "ends": st.lists(POINTS, min_size=2, max_size=2),
        "last": st.integers(0, 2**16 - 1),
    }
)
KINDS = {"three": np.float32, "many": np.int64}


def definition(types: dict[str, str]) -> str:
    (_, first), *others = types.items()
    return first + "".join(f"{RULE}MSG: {name.replace('/msg', '')}\n{one}" for name, one in others)


def schema_of(types: dict[str, str], encoding: str = "cdr") -> TapSchema:
    return TapSchema(
        type=next(iter(types)),
        encoding="ros2msg" if encoding == "cdr" else "ros1msg",
        definition=definition(types),
        message_encoding=encoding,
    )


def store_of(types: dict[str, str]) -> Any:
    store = get_typestore(Stores.EMPTY)
    for name, text in types.items():
        store.register(get_types_from_msg(text, name))
    return store


def made(store: Any, name: str, values: dict[str, Any]) -> Any:
    """Make rosbags' message of plain values."""
    kinds = {"where": "demo/msg/Point", "ends": "demo/msg/Point", "path": "demo/msg/Point"}
    kinds["parts"] = "demo/msg/Part"

    def one(field: str, value: Any) -> Any:
        if field in KINDS:
            return np.array(value, KINDS[field])
        if field not in kinds:
            return value
        if isinstance(value, list):
            return [made(store, kinds[field], each) for each in value]
        return made(store, kinds[field], value)

    return store.types[name](**{field: one(field, value) for field, value in values.items()})


WHOLE_STORE = store_of(WHOLE)


@settings(max_examples=examples(60, many=3000), deadline=None)
@given(VALUES, st.sampled_from(["cdr", "cdr_be", "ros1"]))
def test_tree_has_the_values_that_were_serialized(values: dict[str, Any], form: str) -> None:
    message = made(WHOLE_STORE, NAME, values)
    if form == "ros1":
        data = bytes(WHOLE_STORE.serialize_ros1(message, NAME))
    else:
        data = bytes(WHOLE_STORE.serialize_cdr(message, NAME, little_endian=form == "cdr"))
    tree = tree_reader(schema_of(WHOLE, "ros1" if form == "ros1" else "cdr"))(data)
    assert tree == values
    # As it goes to the page.
    assert msgspec.json.decode(msgspec.json.encode(tree)) == values


@settings(max_examples=examples(100, many=5000), deadline=None)
@given(st.binary(max_size=300), st.sampled_from(["cdr", "ros1"]))
def test_bytes_that_are_no_such_message_are_refused_and_nothing_else(
    data: bytes, encoding: str
) -> None:
    with contextlib.suppress(MessageUnreadable):
        tree_reader(schema_of(WHOLE, encoding))(b"\0\1\0\0" + data if encoding == "cdr" else data)


@settings(max_examples=examples(60, many=3000), deadline=None)
@given(VALUES, st.data())
def test_message_that_is_cut_short_is_refused(values: dict[str, Any], more: Any) -> None:
    whole = bytes(WHOLE_STORE.serialize_cdr(made(WHOLE_STORE, NAME, values), NAME))
    # The last field has two bytes, and up to three may fill the end.
    cut = more.draw(st.integers(4, len(whole) - 5))
    with pytest.raises(MessageUnreadable):
        tree_reader(schema_of(WHOLE))(whole[:cut])


def test_long_arrays_and_texts_are_cut_and_say_how_long_they_are() -> None:
    types = {
        "demo/msg/Cloud": "uint8[] data\ndemo/Spot[] spots\nstring text\nstring[] lines\nint32 end",
        "demo/msg/Spot": "float32 x\nfloat64 y\nuint8 k",
    }
    store = store_of(types)
    cloud, spot = (store.types[name] for name in types)
    message = cloud(
        data=np.arange(5_000_000, dtype=np.uint8),
        spots=[spot(x=float(at), y=0.5, k=7) for at in range(1001)],
        text="a" * 3000,
        lines=["line"] * 1500,
        end=77,
    )
    data = bytes(store.serialize_cdr(message, "demo/msg/Cloud"))
    tree = tree_reader(schema_of(types))(data)
    assert tree["data"] == {"$first": list(range(16)), "$of": 5_000_000}
    assert tree["spots"] == {
        "$first": [{"x": float(at), "y": 0.5, "k": 7} for at in range(5)],
        "$of": 1001,
    }
    assert tree["text"] == {"$text": "a" * 2000, "$of": 3001}
    assert tree["lines"] == {"$first": ["line"] * 1000, "$of": 1500}
    # What lies behind all that was stepped over.
    assert tree["end"] == 77


def test_numbers_that_json_has_not_come_as_words() -> None:
    types = {"demo/msg/Odd": "float64[4] odd\nint64 large\nuint64 larger"}
    store = store_of(types)
    message = store.types["demo/msg/Odd"](
        odd=np.array([math.nan, math.inf, -math.inf, 1.5]), large=-(2**53) - 1, larger=2**64 - 1
    )
    tree = tree_reader(schema_of(types))(bytes(store.serialize_cdr(message, "demo/msg/Odd")))
    words = [{"$number": word} for word in ("NaN", "Infinity", "-Infinity")]
    assert tree["odd"] == [*words, 1.5]
    assert tree["large"] == {"$number": "-9007199254740993"}
    assert tree["larger"] == {"$number": "18446744073709551615"}


def test_wide_texts_are_read_as_ros_writes_them() -> None:
    types = {"demo/msg/Wide": "wstring text\nuint8 end"}
    units = "Zoë 🤖".encode("utf-16-le")
    written = struct.pack("<I", len(units) // 2)
    written += b"".join(units[at : at + 2] + b"\0\0" for at in range(0, len(units), 2))
    tree = tree_reader(schema_of(types))(b"\0\1\0\0" + written + b"\x05")
    assert tree == {"text": "Zoë 🤖", "end": 5}


def test_trees_stay_small_however_much_there_is() -> None:
    types = {"demo/msg/Much": "demo/Row[] rows\nint32 end", "demo/msg/Row": "string a\nuint8[] b"}
    store = store_of(types)
    much, row = (store.types[name] for name in types)
    rows = [row(a="x" * 1900, b=np.zeros(60, np.uint8)) for _ in range(900)]
    data = bytes(store.serialize_cdr(much(rows=rows, end=5), "demo/msg/Much"))
    tree = tree_reader(schema_of(types))(data)
    assert tree["end"] == 5
    assert tree["rows"]["$of"] == 900
    assert 100 < len(tree["rows"]["$first"]) < 900
    assert len(msgspec.json.encode(tree)) < 400_000


def test_definitions_that_would_never_end_are_refused() -> None:
    nothing = {"demo/msg/A": "demo/Empty[] none\nuint8 end", "demo/msg/Empty": ""}
    # Four thousand million of what takes no bytes.
    with pytest.raises(MessageUnreadable, match="takes no bytes"):
        tree_reader(schema_of(nothing))
    # Each twice what is in it: 2^40 values in no bytes at all.
    doubled = {f"demo/msg/L{at}": f"demo/L{at + 1} a\ndemo/L{at + 1} b" for at in range(40)}
    doubled["demo/msg/L40"] = ""
    with pytest.raises(MessageUnreadable, match="too many parts"):
        tree_reader(schema_of(doubled))(b"\0\1\0\0")
    texts = {"demo/msg/T": "demo/Part[] parts", "demo/msg/Part": "string[] words"}
    with pytest.raises(MessageUnreadable, match="too many parts"):
        tree_reader(schema_of(texts))(b"\0\1\0\0" + struct.pack("<I", 10**6) + bytes(4 * 10**6))
    with pytest.raises(MessageUnreadable, match="is in itself"):
        tree_reader(schema_of({"demo/msg/Self": "demo/Self inner"}))
    with pytest.raises(MessageUnreadable, match="no definition"):
        tree_reader(TapSchema(type="demo/msg/None", encoding="ros2msg"))


def test_types_that_come_with_ros_are_read_as_rosbags_reads_them() -> None:
    store = get_typestore(Stores.LATEST)
    name = "diagnostic_msgs/msg/DiagnosticArray"
    kinds = store.types
    stamp = kinds["builtin_interfaces/msg/Time"](sec=7, nanosec=8)
    header = kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="base")
    pair = kinds["diagnostic_msgs/msg/KeyValue"](key="temperature", value="71 °C")
    status = kinds["diagnostic_msgs/msg/DiagnosticStatus"](
        level=1, name="arm: motor", message="warm", hardware_id="m1", values=[pair]
    )
    message = kinds[name](header=header, status=[status])
    text, _ = store.generate_msgdef(name, ros_version=2)
    schema = TapSchema(type=name, encoding="ros2msg", definition=text, message_encoding="cdr")
    tree = tree_reader(schema)(bytes(store.serialize_cdr(message, name)))
    assert tree == {
        "header": {"stamp": {"sec": 7, "nanosec": 8}, "frame_id": "base"},
        "status": [
            {
                "level": 1,
                "name": "arm: motor",
                "message": "warm",
                "hardware_id": "m1",
                "values": [{"key": "temperature", "value": "71 °C"}],
            }
        ],
    }
    assert [field.name for field in dataclasses.fields(message)][:2] == ["header", "status"]
