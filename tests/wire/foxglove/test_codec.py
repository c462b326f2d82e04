"""Our Foxglove codec, judged by what foxglove-sdk's own server said (`record_sdk.py`)."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path

import msgspec
import pytest
from hypothesis import given, strategies as st

from talaia.wire.errors import PeerError, UnknownKind
from talaia.wire.foxglove import codec
from talaia.wire.foxglove.client_messages import (
    FoxgloveCall,
    FoxgloveFetchAsset,
    FoxgloveGetParameters,
    FoxglovePlayback,
    FoxglovePublish,
    FoxgloveSubscribe,
    FoxgloveSubscribeGraph,
    FoxgloveSubscription,
    FoxgloveUnsubscribe,
)
from talaia.wire.foxglove.server_messages import FoxgloveTime, ServerMessage

pytestmark = pytest.mark.pure

FOLDER = Path(__file__).parents[1] / "recorded"
RECORDED = json.loads((FOLDER / "foxglove_sdk_v1.json").read_text())
PLAYED = json.loads((FOLDER / "foxglove_sdk_playback.json").read_text())


def frames(side):
    return [
        base64.b64decode(frame["bytes"]) if "bytes" in frame else frame["text"]
        for frame in RECORDED
        if frame["from"] == side
    ]


SAID = [frame for frame in frames("server") if isinstance(frame, str)]


@pytest.mark.parametrize("frame", SAID, ids=lambda frame: json.loads(frame)["op"])
def test_json_of_the_sdk_is_written_by_us_to_the_letter(frame) -> None:
    assert codec.encode_server(msgspec.json.decode(frame, type=ServerMessage)) == frame


def test_binary_messages_of_the_sdk_are_written_by_us_to_the_byte() -> None:
    recorded = [frame for frame in frames("server") if isinstance(frame, bytes)]
    assert recorded == [
        codec.encode_message_data(7, 1_700_000_000_123_456_789, b'{"value": 2.5}'),
        codec.encode_time(1_700_000_000_000_000_001),
        codec.encode_asset(5, b"mesh"),
        codec.encode_asset(6, None, "OSError: not found"),
        codec.encode_service_response(1, 1, "json", b'{"done": true}'),
    ]


def test_what_the_sdk_understood_is_read_by_us_as_it_was_meant() -> None:
    *understood, nonsense = frames("client")
    assert [codec.decode_client(frame) for frame in understood] == [
        FoxgloveSubscribe(subscriptions=[FoxgloveSubscription(id=7, channel_id=1)]),
        FoxgloveGetParameters(parameter_names=[], id="p1"),
        FoxgloveFetchAsset(uri="package://robot/mesh.stl", request_id=5),
        FoxgloveFetchAsset(uri="package://robot/none", request_id=6),
        FoxgloveCall(service_id=1, call_id=1, encoding="json", data=b"{}"),
        FoxgloveCall(service_id=1, call_id=2, encoding="json", data=b"fail"),
        FoxgloveSubscribeGraph(),
        FoxgloveUnsubscribe(subscription_ids=[7]),
    ]
    with pytest.raises(UnknownKind):
        codec.decode_client(nonsense)


def test_playback_of_the_sdk_is_written_and_read_by_us_to_the_byte() -> None:
    info, *states = [frame for frame in PLAYED if frame["from"] == "server"]
    read = msgspec.json.decode(info["text"], type=ServerMessage)
    assert read.data_end_time == FoxgloveTime(1_700_000_100, 2)
    # Of its library's name we say nothing; all else is written as it was read.
    assert codec.encode_server(read) == info["text"]
    said_ns = 1_700_000_000_123_456_789
    state = codec.encode_playback_state
    assert [base64.b64decode(frame["bytes"]) for frame in states] == [
        state(
            codec.PlaybackStatus.PLAYING, said_ns, speed=2.0, sought=False, request_id="request-0"
        ),
        state(
            codec.PlaybackStatus.PLAYING, said_ns, speed=0.5, sought=True, request_id="request-1"
        ),
        state(codec.PlaybackStatus.ENDED, 99, speed=1.0, sought=False),
    ]
    asked = [frame for frame in PLAYED if frame["from"] == "client"]
    for frame in asked:
        understood = frame["understood"]
        assert codec.decode_client(base64.b64decode(frame["bytes"])) == FoxglovePlayback(
            play=understood["command"].endswith("Play"),
            speed=understood["speed"],
            seek_ns=understood["seek"],
            request_id=understood["id"],
        )
    assert len(asked) == 2


def test_message_that_is_too_large_is_refused_by_its_code() -> None:
    for frame in (bytes(codec.MAX_CLIENT_FRAME + 1), "x" * (codec.MAX_CLIENT_FRAME + 1)):
        with pytest.raises(PeerError) as refused:
            codec.decode_client(frame)
        assert refused.value.code == 1009


@pytest.mark.parametrize(
    "frame",
    [
        "",
        "[]",
        "{}",
        '{"op": 1}',
        '{"op": "subscribe"}',
        '{"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 1}]}',
        '{"op": "subscribe", "subscriptions": [{"id": 4294967296, "channelId": 1}]}',
        "[" * 100_000,
        '{"op": "fetchAsset", "uri": "\\ud800", "requestId": 1}',
        b"\x01\x00\x00",
        b"\x02" + bytes(8),
        struct.pack("<BIII", 2, 1, 1, 2**31) + b"json",
        struct.pack("<BIII", 2, 1, 1, 1) + b"\xff",
        b"\x03" + bytes(5),
        struct.pack("<BBfBQI", 3, 9, 1.0, 0, 0, 0),
        struct.pack("<BBfBQI", 3, 0, 1.0, 0, 0, 2**31) + b"id",
    ],
)
def test_what_is_not_of_the_protocol_is_told_apart_from_what_is_new(frame) -> None:
    with pytest.raises(PeerError) as refused:
        codec.decode_client(frame)
    assert not isinstance(refused.value, UnknownKind)


def test_unknown_binary_kind_is_skipped() -> None:
    for frame in (b"", b"\x09rest"):
        with pytest.raises(UnknownKind):
            codec.decode_client(frame)


@given(st.one_of(st.binary(max_size=200), st.text(max_size=200)))
def test_whatever_comes_is_read_or_refused_as_a_peers_fault(frame) -> None:
    try:
        codec.decode_client(frame)
    except PeerError:
        return


@given(st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1), st.text(max_size=9), st.binary())
def test_call_is_read_as_a_response_is_written(service, call, encoding, data) -> None:
    written = codec.encode_service_response(service, call, encoding, data)
    read = codec.decode_client(b"\x02" + written[1:])
    assert read == FoxgloveCall(service_id=service, call_id=call, encoding=encoding, data=data)


@given(st.integers(0, 2**32 - 1), st.binary())
def test_published_message_is_read_whole(channel, data) -> None:
    frame = struct.pack("<BI", 1, channel) + data
    assert codec.decode_client(frame) == FoxglovePublish(channel_id=channel, data=data)
