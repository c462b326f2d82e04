"""JSON, fragments and CBOR of the rosbridge protocol: whatever comes, and back."""

from __future__ import annotations

import contextlib
import json
import struct

import cbor2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.wire.errors import PeerError
from talaia.wire.rosbridge.cbor import encode_cbor
from talaia.wire.rosbridge.client_messages import RosbridgeFragment, RosbridgeSubscribe
from talaia.wire.rosbridge.codec import (
    MAX_ROSBRIDGE_FRAME,
    RosbridgeMistake,
    decode_rosbridge,
    encode_rosbridge,
)
from talaia.wire.rosbridge.fragments import LEAST_FRAGMENT, FragmentAssembly

# Enough for each kind of value, at a small cost.
FEW = settings(max_examples=examples(12, many=500))
VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**64 - 1)
    | st.floats(allow_nan=False)
    | st.text()
    | st.binary(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@FEW
@given(VALUES)
def test_cbor_is_read_by_another_library_as_what_was_written(value) -> None:
    assert cbor2.loads(encode_cbor(value)) == value


@pytest.mark.parametrize(
    ("form", "tag"),
    [("<u2", 69), ("<u4", 70), ("<u8", 71), ("i1", 72), ("<i2", 77), ("<i8", 79), ("<f4", 85)],
)
def test_arrays_of_numbers_have_the_tag_of_their_type(form, tag) -> None:
    values = np.array([1, 2, 100], form)
    read = cbor2.loads(encode_cbor(values))
    assert (read.tag, read.value) == (tag, values.tobytes())
    # Bytes alone need none.
    assert cbor2.loads(encode_cbor(np.array([1, 2], "u1"))) == b"\x01\x02"


@FEW
@given(st.text() | VALUES.map(lambda value: json.dumps(value, default=str)))
def test_whatever_a_client_says_is_a_message_or_a_mistake(text) -> None:
    with contextlib.suppress(PeerError):
        assert decode_rosbridge(text).__struct_config__.tag


@FEW
@given(
    st.dictionaries(st.sampled_from(["op", "id", "topic", "msg", "data", "num", "total"]), VALUES)
)
def test_messages_with_any_fields_are_read_or_refused(fields) -> None:
    with contextlib.suppress(RosbridgeMistake):
        said = decode_rosbridge(json.dumps({"op": "fragment", **fields}, default=str))
        assert isinstance(said, RosbridgeFragment)


def test_clients_may_write_null_where_they_have_no_value() -> None:
    text = '{"op":"subscribe","id":7,"topic":"/a","type":null,"throttle_rate":null,"qos":{}}'
    assert decode_rosbridge(text) == RosbridgeSubscribe(id=7, topic="/a")


def test_unknown_operation_is_named_with_its_id() -> None:
    with pytest.raises(RosbridgeMistake, match="brewCoffee") as refused:
        decode_rosbridge('{"op":"brewCoffee","id":"x"}')
    assert refused.value.id == "x"


def test_giant_message_ends_the_connection() -> None:
    with pytest.raises(PeerError) as refused:
        decode_rosbridge(" " * (MAX_ROSBRIDGE_FRAME + 1))
    assert refused.value.code == 1009


@FEW
@given(st.text(min_size=1, max_size=5000), st.integers(1, 3000), st.randoms())
def test_fragments_of_a_message_make_it_in_any_order(text, size, order) -> None:
    frames = encode_rosbridge({"x": text}, fragment_size=size, fragment_id="a", cbor=False)
    if len(frames) == 1:
        assert json.loads(frames[0])["x"] == text
        return
    parts = [decode_rosbridge(frame) for frame in frames]
    assert all(len(part.data) <= max(size, LEAST_FRAGMENT) for part in parts)
    order.shuffle(parts)
    assembly = FragmentAssembly(100_000)
    whole = [found for part in parts if (found := assembly.add_fragment(part)) is not None]
    assert [json.loads(one)["x"] for one in whole] == [text]
    assert assembly.size == 0


@FEW
@given(
    st.lists(
        st.tuples(st.integers(0, 20), st.integers(0, 5), st.integers(1, 5), st.text(max_size=50)),
        max_size=200,
    )
)
def test_fragments_that_never_end_cost_a_bounded_store(sent) -> None:
    assembly = FragmentAssembly(200)
    for number, at, total, data in sent:
        fragment = RosbridgeFragment(id=number, data=data, num=at, total=total)
        with contextlib.suppress(PeerError):
            assembly.add_fragment(fragment)
        assert assembly.size <= 200
        assert len(assembly._open) <= 8


def test_what_is_no_number_is_null_in_json_and_bytes_are_base64() -> None:
    message = {"a": float("nan"), "b": np.array([1, 2], "u1"), "c": np.array([1.5, np.inf])}
    (text,) = encode_rosbridge(message, cbor=False)
    assert json.loads(text) == {"a": None, "b": "AQI=", "c": [1.5, None]}


def test_doubles_keep_their_bits() -> None:
    assert encode_cbor(0.1)[1:] == struct.pack(">d", 0.1)
