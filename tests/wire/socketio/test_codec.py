"""Packets of Engine.IO and Socket.IO, whatever comes; python-engineio and python-socketio judge."""

from __future__ import annotations

import contextlib

import engineio
import pytest
import socketio
from hypothesis import given, settings, strategies as st
from many_examples import examples
from socketIO_client.parsers import decode_engineIO_content, encode_engineIO_content

from talaia.wire.errors import PeerError
from talaia.wire.socketio.engine_packets import (
    MAX_SOCKETIO_BODY,
    EngineKind,
    EnginePacket,
    EngineRevision,
    decode_body,
    decode_frame,
    encode_body,
    encode_frame,
)
from talaia.wire.socketio.socket_packets import (
    SocketAssembly,
    SocketKind,
    SocketPacket,
    encode_socket,
)

# Enough for each kind of value, at a small cost.
FEW = settings(max_examples=examples(12, many=500))
OLD, NEW = EngineRevision.OLD, EngineRevision.NEW
ASCII = st.text(st.characters(max_codepoint=126, min_codepoint=32))
PACKETS = st.lists(
    st.builds(EnginePacket, st.just(EngineKind.MESSAGE), ASCII | st.binary(max_size=40)),
    min_size=1,
    max_size=5,
)
# python-engineio reads no more in one body.
TEXTS = st.lists(
    st.builds(EnginePacket, st.sampled_from(EngineKind), ASCII), min_size=1, max_size=16
)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.text() | st.binary(max_size=20),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.text().filter(lambda name: name != "_placeholder"), inner, max_size=3)
    ),
    max_leaves=8,
)


@FEW
@given(PACKETS, st.booleans())
def test_body_is_read_as_it_was_written_in_both_revisions(packets, as_text) -> None:
    for revision in EngineRevision:
        body = encode_body(packets, revision, as_text=as_text)
        assert decode_body(body, revision) == packets
        for packet in packets:
            assert decode_frame(encode_frame(packet, revision), revision) == packet


@FEW
@given(TEXTS)
def test_python_engineio_reads_bodies_of_the_new_revision(packets) -> None:
    read = engineio.payload.Payload(
        encoded_payload=encode_body(packets, NEW, as_text=False).decode()
    )
    assert [packet.packet_type for packet in read.packets] == [each.kind for each in packets]


@FEW
@given(TEXTS)
def test_founding_client_and_the_hub_read_each_others_bodies(packets) -> None:
    pairs = [(packet.kind.value, packet.data) for packet in packets]
    read = decode_engineIO_content(encode_body(packets, OLD, as_text=False))
    assert [(kind, data.decode()) for kind, data in read] == pairs
    assert decode_body(bytes(encode_engineIO_content(pairs)), OLD) == packets


def test_lengths_of_the_old_revision_count_letters_as_javascript_does() -> None:
    assert decode_body("6:4🤖abc4:4äöü".encode(), OLD) == [
        EnginePacket(EngineKind.MESSAGE, "🤖abc"),
        EnginePacket(EngineKind.MESSAGE, "äöü"),
    ]


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"4:4a",
        b":4a",
        b"x",
        b"\x00\xff4a",
        b"\x00\x09\xff4a",
        b"\x02\x02\xff4a",
        b"\x00\x02",
        b"\x01\x02\xff\x05a",
        "2:4🤖".encode(),
        b"1:9",
        b"9" * 30,
        b"5:b5AAA",
        b"4:b4=A",
        b"\xff",
    ],
)
def test_body_that_is_none_of_the_old_revision_is_refused(body) -> None:
    if body:
        with pytest.raises(PeerError):
            decode_body(body, OLD)
    else:
        assert decode_body(body, OLD) == []


@pytest.mark.parametrize("body", [b"", b"x", b"9", b"b*", b"4a\x1e", b"\xff", "٣".encode()])
def test_body_that_is_none_of_the_new_revision_is_refused(body) -> None:
    with pytest.raises(PeerError):
        decode_body(body, NEW)


def test_bodies_that_are_too_large_or_of_too_many_packets_are_refused_by_their_code() -> None:
    for revision, body in (
        (NEW, b"4" * (MAX_SOCKETIO_BODY + 1)),
        (NEW, b"\x1e".join([b"2"] * 1001)),
        (OLD, b"1:2" * 1001),
    ):
        with pytest.raises(PeerError) as refused:
            decode_body(body, revision)
        assert refused.value.code == 1009


@FEW
@given(st.binary() | st.text().map(str.encode), st.sampled_from(EngineRevision))
def test_any_body_is_read_or_refused(body, revision) -> None:
    with contextlib.suppress(PeerError):
        decode_body(body, revision)


@FEW
@given(st.lists(VALUES, max_size=3), st.sampled_from(["/", "/sensedData"]), st.none() | st.just(7))
def test_event_is_read_as_it_was_written_and_by_python_socketio(said, namespace, number) -> None:
    packet = SocketPacket(SocketKind.EVENT, namespace, ["metric", *said], number)
    messages = encode_socket(packet)
    if len(messages) > 17:
        return
    assembly = SocketAssembly()
    read = [assembly.add_message(message) for message in messages]
    assert read[-1] == packet
    assert not any(read[:-1])
    assert messages[0].isascii()
    judge = socketio.packet.Packet(encoded_packet=messages[0])
    for attachment in messages[1:]:
        judge.add_attachment(attachment)
    assert (judge.namespace or "/", judge.data, judge.id) == (namespace, packet.data, number)


def test_packets_of_clients_are_read_with_queries_and_without_commas() -> None:
    read = SocketAssembly().add_message
    assert read("0") == SocketPacket(SocketKind.CONNECT)
    assert read("0/sensedData") == SocketPacket(SocketKind.CONNECT, "/sensedData")
    assert read("0/sensedData?a=b") == SocketPacket(SocketKind.CONNECT, "/sensedData")
    connect = SocketPacket(SocketKind.CONNECT, "/sensedData", {"token": "t"})
    assert read('0/sensedData,{"token":"t"}') == connect
    assert read("1/sensedData,") == SocketPacket(SocketKind.DISCONNECT, "/sensedData")
    assert read('212["a"]') == SocketPacket(SocketKind.EVENT, "/", ["a"], 12)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "7",
        "2",
        "2[]",
        "2{}",
        "2[null]",
        '2["a"',
        '21-["a"]',
        '5["a"]',
        "2" + "[" * 100_000,
        '2/x,["a"]]',
        "0/" + "x" * 300,
        '551-["a"]',
    ],
)
def test_text_that_is_no_packet_is_refused(text) -> None:
    with pytest.raises(PeerError):
        SocketAssembly().add_message(text)


def test_attachments_are_bounded_and_belong_to_their_event() -> None:
    with pytest.raises(PeerError, match="belong to no event"):
        SocketAssembly().add_message(b"stray")
    assembly = SocketAssembly()
    assert assembly.add_message('51-["a",{"_placeholder":true,"num":1}]') is None
    with pytest.raises(PeerError, match="no attachment 1"):
        assembly.add_message(b"x")
    assembly = SocketAssembly()
    assembly.add_message('52-["a",{"_placeholder":true,"num":0}]')
    with pytest.raises(PeerError, match="attachments of an event are awaited"):
        assembly.add_message('2["b"]')
    assembly = SocketAssembly()
    assembly.add_message('516-["a"]')
    for _ in range(10):
        assembly.add_message(b"x" * 100_000)
    with pytest.raises(PeerError) as refused:
        assembly.add_message(b"x" * 100_000)
    assert refused.value.code == 1009


@FEW
@given(st.lists(st.text() | st.binary(), max_size=5))
def test_any_messages_are_read_or_refused(messages) -> None:
    assembly = SocketAssembly()
    with contextlib.suppress(PeerError):
        for message in messages:
            assembly.add_message(message)
