"""Fields of Protocol Buffers as Google's own library reads and writes them."""

from __future__ import annotations

import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FieldDescriptorProto as Field
from hypothesis import given, strategies as st

from talaia.wire.errors import PeerError
from talaia.wire.protobuf import (
    bytes_field,
    double_field,
    float_field,
    read_fields,
    read_text,
    read_whole,
    signed_64,
    varint_field,
)

KINDS = {
    "whole": Field.TYPE_INT64,
    "text": Field.TYPE_STRING,
    "data": Field.TYPE_BYTES,
    "double": Field.TYPE_DOUBLE,
    "single": Field.TYPE_FLOAT,
    "flag": Field.TYPE_BOOL,
}


def made_message():
    """Describe a message with a field of each kind, as a compiler would."""
    described = descriptor_pb2.FileDescriptorProto(name="t.proto", package="t", syntax="proto3")
    message = described.message_type.add(name="Message")
    for number, (name, kind) in enumerate(KINDS.items(), start=1):
        message.field.add(name=name, number=number * 100, type=kind, label=Field.LABEL_OPTIONAL)
    pool = descriptor_pool.DescriptorPool()
    pool.Add(described)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName("t.Message"))


Message = made_message()
WHOLE = st.integers(-(2**63), 2**63 - 1)


@given(
    WHOLE, st.text(), st.binary(), st.floats(allow_nan=False), st.floats(width=32), st.booleans()
)
def test_what_is_written_google_reads_and_the_other_way_round(
    whole, text, data, double, single, flag
) -> None:
    written = (
        varint_field(100, whole)
        + bytes_field(200, text)
        + bytes_field(300, data)
        + double_field(400, double)
        + float_field(500, single)
        + varint_field(600, flag)
    )
    read = Message.FromString(written)
    assert (read.whole, read.text, read.data, read.double, read.flag) == (
        whole,
        text,
        data,
        double,
        flag,
    )
    # What is 0 or empty Google leaves out.
    found = dict(read_fields(Message(whole=whole, text=text, data=data).SerializeToString()))
    assert signed_64(read_whole(found.get(100, 0))) == whole
    assert read_text(found.get(200, b"")) == text
    assert found.get(300, b"") == data


@given(st.binary(max_size=60))
def test_odd_bytes_are_refused_and_never_hurt(data) -> None:
    try:
        found = list(read_fields(data))
    except PeerError:
        return
    assert sum(len(value) for _, value in found if isinstance(value, bytes)) <= len(data)


@pytest.mark.parametrize("data", [b"\x08", b"\x0a\x05ab", b"\xff" * 11, b"\x0b", b"\x00\x00"])
def test_message_that_is_cut_off_or_none_is_refused(data) -> None:
    with pytest.raises(PeerError):
        list(read_fields(data))
