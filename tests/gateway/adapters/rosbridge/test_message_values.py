"""Messages that a rosbridge server took apart, put together again.

The judge is `rosbags`: it reads the bytes by nothing but the text that goes along with them.
"""

from __future__ import annotations

import base64
import functools
import json
import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, strategies as st
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from talaia.gateway.adapters.ros2.type_definitions.message_definition import BadDefinition
from talaia.gateway.adapters.rosbridge.protocol import read_message
from talaia.gateway.adapters.rosbridge.robot_definitions import learn_type
from talaia.gateway.errors import FieldError

from .cbor_writer import TypedArray, written

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

    from talaia.gateway.adapters.rosbridge.robot_definitions import ServerType

pytestmark = pytest.mark.pure

NAME = "own_msgs/msg/Everything"
_RULE = "=" * 80
INNER = f"""{_RULE}
MSG: own_msgs/Inner
float32 x
string[] words
"""
# As rosapi tells it. What CBOR cannot carry stands in a type of its own.
TEXT_2 = f"""# everything
int32 MOST=7
bool on
int8 small
uint64 large
float32 half
float64 whole
string name
uint8[] bytes
int16[] shorts
float32[] reals
bool[] flags
string[] names
own_msgs/Inner one
own_msgs/Inner[] some
own_msgs/Inner[2] pair
{INNER}"""
HARD_2 = f"""byte level
wstring wide
float64[3] covariance
uint8[4] key
float32[<=2] few
string<=5 short
string[<=2] tags
own_msgs/Inner[<=2] some
{INNER}"""
HEADER_1 = """uint32 seq
time stamp
string frame_id
"""
TEXT_1 = f"""Header header
duration took
byte sign
char letter
float64[] reals
uint8[3] key
{_RULE}
MSG: std_msgs/Header
{HEADER_1}"""

TEXTS = st.text(st.characters(blacklist_categories=["Cs"], blacklist_characters="\0"), max_size=5)
FINITE = st.floats(allow_nan=False, allow_infinity=False)
FLOAT32 = st.floats(width=32, allow_nan=False)
INNERS = st.fixed_dictionaries({"x": FLOAT32, "words": st.lists(TEXTS, max_size=3)})


def ints(bits: int, *, signed: bool = True) -> st.SearchStrategy[int]:
    low = -(2 ** (bits - 1)) if signed else 0
    return st.integers(low, low + 2**bits - 1)


VALUES_2 = st.fixed_dictionaries(
    {
        "on": st.booleans(),
        "small": ints(8),
        "large": ints(64, signed=False),
        "half": FLOAT32,
        "whole": st.floats(allow_nan=False),
        "name": TEXTS,
        "bytes": st.binary(max_size=9),
        "shorts": st.lists(ints(16), max_size=4),
        "reals": st.lists(FLOAT32, max_size=4),
        "flags": st.lists(st.booleans(), max_size=3),
        "names": st.lists(TEXTS, max_size=3),
        "one": INNERS,
        "some": st.lists(INNERS, max_size=2),
        "pair": st.lists(INNERS, min_size=2, max_size=2),
    }
)
HARD_VALUES = st.fixed_dictionaries(
    {
        "level": ints(8, signed=False),
        "wide": TEXTS,
        "covariance": st.lists(FINITE, min_size=3, max_size=3),
        "key": st.binary(min_size=4, max_size=4),
        "few": st.lists(st.floats(width=32, allow_nan=False, allow_infinity=False), max_size=2),
        "short": st.text("abc", max_size=5),
        "tags": st.lists(TEXTS, max_size=2),
        "some": st.lists(INNERS, max_size=2),
    }
)  # fmt: skip
# As `rosbridge_suite` writes them in CBOR.
ARRAYS = {"shorts": (77, "<i2"), "reals": (85, "<f4")}


def as_json(values: dict) -> str:
    """Write a frame as the server does: bytes as base64, what JSON has no number for as null."""

    def plain(value: object) -> object:
        match value:
            case bytes():
                return base64.b64encode(value).decode()
            case float() if not math.isfinite(value):
                return None
            case dict():
                return {key: plain(each) for key, each in value.items()}
            case list():
                return [plain(each) for each in value]
        return value

    return json.dumps({"op": "publish", "topic": "/t", "msg": plain(values)})


def as_cbor(values: dict) -> bytes:
    typed = {
        key: TypedArray(*ARRAYS[key], value) if key in ARRAYS else value
        for key, value in values.items()
    }
    return written({"op": "publish", "topic": "/t", "msg": typed})


@functools.cache
def reading_store(name: str, text: str) -> Typestore:
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(text, name))
    return store


def read_back(kind: ServerType, data: bytes, name: str) -> object:
    store = reading_store(name, kind.definition.definition)
    ros1 = kind.definition.message_encoding == "ros1"
    return store.deserialize_ros1(data, name) if ros1 else store.deserialize_cdr(data, name)


def plain(value: object) -> object:
    """Turn what rosbags read into what it was made of."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, list):
        return [plain(each) for each in value]
    if hasattr(value, "__dataclass_fields__"):
        return {
            key: plain(getattr(value, key))
            for key in value.__dataclass_fields__
            if key[0] != "_" and key != "MOST"
        }
    return value


def expected(values: dict) -> dict:
    return {key: list(each) if isinstance(each, bytes) else each for key, each in values.items()}


KIND_2 = learn_type(NAME, TEXT_2, 2)


@given(VALUES_2)
def test_what_came_as_cbor_is_the_message_that_was_sent(values: dict) -> None:
    data = KIND_2.serializer.serialize_message(read_message(as_cbor(values)).body)
    assert plain(read_back(KIND_2, data, NAME)) == expected(values)


@given(VALUES_2)
def test_what_came_as_json_is_the_same_but_for_numbers_without_end(values: dict) -> None:
    data = KIND_2.serializer.serialize_message(read_message(as_json(values)).body)
    read = plain(read_back(KIND_2, data, NAME))
    for key in ("half", "whole"):
        if math.isinf(values[key]):
            assert math.isnan(read.pop(key))
            del values[key]
    assert len(read["reals"]) == len(values["reals"])
    for found, sent in zip(read.pop("reals"), values.pop("reals"), strict=True):
        assert found == sent or (math.isinf(sent) and math.isnan(found))
    inner = [read.pop("one"), *read.pop("some"), *read.pop("pair")]
    sent_inner = [values.pop("one"), *values.pop("some"), *values.pop("pair")]
    assert [each["words"] for each in inner] == [each["words"] for each in sent_inner]
    assert read == expected(values)


HARD_NAME = "own_msgs/msg/Hard"
HARD = learn_type(HARD_NAME, HARD_2, 2)


@given(HARD_VALUES)
def test_what_cbor_cannot_carry_comes_as_json(values: dict) -> None:
    assert KIND_2.cbor
    assert not HARD.cbor
    data = HARD.serializer.serialize_message(read_message(as_json(values)).body)
    # rosbags knows no wide texts: as it has them, they are words of four bytes.
    text = HARD.definition.definition.replace("wstring wide", "uint32[] wide")
    read = plain(reading_store(HARD_NAME, text).deserialize_cdr(data, HARD_NAME))
    units = np.frombuffer(values.pop("wide").encode("utf-16-le"), "<u2")
    assert read.pop("wide") == units.tolist()
    # Nor a byte without a sign.
    assert read.pop("level") % 256 == values.pop("level")
    for each in (*read["some"], *values["some"]):
        each["x"] = 0.0 if not math.isfinite(each["x"]) else each["x"]
    assert read == expected(values)


def test_messages_of_ros_1_are_written_as_it_writes_them() -> None:
    kind = learn_type("own_msgs/msg/Old", TEXT_1, 1)
    assert not kind.cbor
    values = {
        "header": {"seq": 3, "stamp": {"secs": 4_000_000_000, "nsecs": 5}, "frame_id": "base"},
        "took": {"secs": -1, "nsecs": 7},
        "sign": -3,
        "letter": 200,
        "reals": [1.5, None],
        "key": base64.b64encode(b"\x01\xff\x03").decode(),
    }
    message = json.dumps({"op": "publish", "topic": "/t", "msg": values})
    data = kind.serializer.serialize_message(read_message(message).body)
    # By the letter of ROS 1's serialization.
    assert data.hex() == (
        "03000000" "00286bee" "05000000" "04000000" "62617365"
        "ffffffff" "07000000" "fd" "c8"
        "02000000" "000000000000f83f" "000000000000f87f" "01ff03"
    )  # fmt: skip
    assert kind.definition == ("ros1msg", TEXT_1, "ros1")


def test_a_type_of_which_the_robot_says_nothing_is_taken_from_a_distribution() -> None:
    for ros, text in ((2, ""), (2, "# failed to get full definition text"), (1, "")):
        kind = learn_type("nav_msgs/msg/Odometry", text, ros)
        values = {
            "op": "publish",
            "msg": {"child_frame_id": "wheel", "pose": {"pose": {"position": {"x": 2}}}},
        }
        data = kind.serializer.serialize_message(read_message(json.dumps(values)).body)
        read = read_back(kind, data, "nav_msgs/msg/Odometry")
        assert (read.child_frame_id, read.pose.pose.position.x) == ("wheel", 2.0)
        # What did not come is empty.
        assert (read.header.frame_id, read.pose.covariance.sum()) == ("", 0.0)
    with pytest.raises(BadDefinition, match="Start rosapi"):
        learn_type("own_msgs/msg/Unknown", "", 2)


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"small": 128}, "'small': expected int8, found 128"),
        ({"name": 3}, "'name': expected a text"),
        ({"names": "x"}, "'names': expected a list"),
        ({"names": [1]}, "'names': expected a text"),
        ({"shorts": [99999]}, "'shorts': is no list of int16"),
        ({"bytes": "%%"}, "'bytes': is no list of uint8"),
        ({"one": 3}, "'one': expected own_msgs/msg/Inner"),
        ({"pair": []}, "'pair': expected 2 elements, found 0"),
    ],
)
def test_what_does_not_fit_is_refused_by_the_name_of_its_field(values: dict, why: str) -> None:
    message = read_message(json.dumps({"op": "publish", "msg": values}))
    with pytest.raises(FieldError) as refused:
        KIND_2.serializer.serialize_message(message.body)
    assert why in str(refused.value)
