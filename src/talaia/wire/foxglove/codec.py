"""Bytes and JSON of the Foxglove WebSocket protocol to values and back."""

from __future__ import annotations

import struct
from enum import IntEnum

import msgspec

from talaia.wire.errors import PeerError, UnknownKind
from talaia.wire.foxglove.client_messages import (
    FoxgloveCall,
    FoxgloveMessage,
    FoxglovePlayback,
    FoxglovePublish,
    FoxgloveText,
)
from talaia.wire.foxglove.server_messages import ServerMessage

__all__ = [
    "MAX_CLIENT_FRAME",
    "SDK_SUBPROTOCOL",
    "SUBPROTOCOLS",
    "PlaybackStatus",
    "decode_client",
    "encode_asset",
    "encode_message_data",
    "encode_playback_state",
    "encode_server",
    "encode_service_response",
    "encode_time",
]

# As clients offer them; both mean the messages of this package.
SDK_SUBPROTOCOL = "foxglove.sdk.v1"
SUBPROTOCOLS = (SDK_SUBPROTOCOL, "foxglove.websocket.v1")
# Of a client (bytes): the largest is a subscription to thousands of channels.
MAX_CLIENT_FRAME = 1024 * 1024

# First byte of a binary message, each way.
_MESSAGE_DATA, _TIME, _SERVICE_RESPONSE, _ASSET, _PLAYBACK_STATE = 1, 2, 3, 4, 5
_PUBLISH, _CALL, _PLAYBACK = 1, 2, 3

# All numbers are little-endian. Kind, subscription, time; then the message.
_DATA_HEAD = struct.Struct("<BIQ")
# Kind, time.
_TIME_HEAD = struct.Struct("<BQ")
# Kind, service, call, length of the encoding's name; then that and the arguments.
_CALL_HEAD = struct.Struct("<BIII")
# Kind, request, status (1: failed), length of the reason; then that or the file.
_ASSET_HEAD = struct.Struct("<BIBI")
# Kind, the client's channel; then the message.
_PUBLISH_HEAD = struct.Struct("<BI")
# Kind, command (0: play), speed, whether a time is sought, that, length of the request's id.
_PLAYBACK_HEAD = struct.Struct("<BBfBQI")
# Kind, status, time, speed, whether a time was sought, length of the request's id.
_STATE_HEAD = struct.Struct("<BBQfBI")
# A time beyond it would not fit; none before 1970 can be said.
_MOST_NS = 2**64 - 1

# Made once: a decoder works its types out as it is made.
_TEXT: msgspec.json.Decoder[FoxgloveText] = msgspec.json.Decoder(FoxgloveText)
# By these an unknown message is told from a wrong field: msgspec has one error for both.
_KINDS = frozenset(member.__struct_config__.tag for member in FoxgloveText.__args__)
_ENCODER = msgspec.json.Encoder()


class PlaybackStatus(IntEnum):
    """Where the playing of past data stands."""

    PLAYING = 0
    PAUSED = 1
    BUFFERING = 2
    ENDED = 3


class _Op(msgspec.Struct, frozen=True):
    # All that is read of a message of an unknown kind.
    op: str


def decode_client(frame: bytes | str) -> FoxgloveMessage:
    """Read what a client said.

    Raises:
        PeerError: too large (code 1009), or not of the protocol.
        UnknownKind: a message of an ``op`` or of a binary kind that is not known here.

    """
    # Before it is decoded: what is too large costs no more than its receipt.
    if len(frame) > MAX_CLIENT_FRAME:
        raise PeerError(
            f"a message of {len(frame)} bytes is over the limit of {MAX_CLIENT_FRAME}", 1009
        )
    if isinstance(frame, bytes):
        return _decode_binary(frame)
    try:
        return _TEXT.decode(frame)
    except msgspec.ValidationError as error:
        op = _op_of(frame)
        if op is not None and op not in _KINDS:
            raise UnknownKind(op) from error
        raise PeerError(f"a message that is not in the protocol: {error}") from error
    except RecursionError as error:
        raise PeerError("a message that is nested too deeply") from error
    except (msgspec.DecodeError, UnicodeError) as error:
        raise PeerError(f"a message that is no JSON: {error}") from error


def encode_server(message: ServerMessage) -> str:
    """Write what a server says as JSON."""
    return _ENCODER.encode(message).decode()


def encode_message_data(subscription: int, time_ns: int, data: bytes) -> bytes:
    """Write a message of a channel; ``time_ns`` is when it was received (UTC)."""
    return _DATA_HEAD.pack(_MESSAGE_DATA, subscription, min(max(time_ns, 0), _MOST_NS)) + data


def encode_time(time_ns: int) -> bytes:
    """Write the server's time (ns, UTC)."""
    return _TIME_HEAD.pack(_TIME, min(max(time_ns, 0), _MOST_NS))


def encode_service_response(service: int, call: int, encoding: str, data: bytes) -> bytes:
    """Write the answer to a call."""
    said = encoding.encode()
    return _CALL_HEAD.pack(_SERVICE_RESPONSE, service, call, len(said)) + said + data


def encode_asset(request: int, data: bytes | None, problem: str = "") -> bytes:
    """Write a file that was asked for, or why there is none when ``data`` is."""
    said = problem.encode() if data is None else b""
    return _ASSET_HEAD.pack(_ASSET, request, int(data is None), len(said)) + said + (data or b"")


def encode_playback_state(
    status: PlaybackStatus, time_ns: int, *, speed: float, sought: bool, request_id: str = ""
) -> bytes:
    """Write where the playing of past data stands; ``request_id`` is of what this answers."""
    number = request_id.encode()
    time_ns = min(max(time_ns, 0), _MOST_NS)
    return _STATE_HEAD.pack(_PLAYBACK_STATE, status, time_ns, speed, sought, len(number)) + number


def _decode_binary(frame: bytes) -> FoxglovePublish | FoxgloveCall | FoxglovePlayback:
    kind = frame[0] if frame else -1
    if kind == _PUBLISH:
        if len(frame) < _PUBLISH_HEAD.size:
            raise PeerError(f"a published message of {len(frame)} bytes has no head")
        _, channel = _PUBLISH_HEAD.unpack_from(frame)
        return FoxglovePublish(channel_id=channel, data=frame[_PUBLISH_HEAD.size :])
    if kind == _PLAYBACK:
        return _decode_playback(frame)
    if kind != _CALL:
        raise UnknownKind(f"binary {kind}")
    if len(frame) < _CALL_HEAD.size:
        raise PeerError(f"a service call of {len(frame)} bytes has no head")
    _, service, call, length = _CALL_HEAD.unpack_from(frame)
    # The peer chose the length: nothing is read beyond the message.
    begin = _CALL_HEAD.size + length
    if begin > len(frame):
        raise PeerError("the encoding of a service call is longer than the message")
    try:
        encoding = frame[_CALL_HEAD.size : begin].decode()
    except UnicodeDecodeError as error:
        raise PeerError("the encoding of a service call is no text") from error
    return FoxgloveCall(service_id=service, call_id=call, encoding=encoding, data=frame[begin:])


def _decode_playback(frame: bytes) -> FoxglovePlayback:
    if len(frame) < _PLAYBACK_HEAD.size:
        raise PeerError(f"a playback request of {len(frame)} bytes has no head")
    _, command, speed, seeks, seek_ns, length = _PLAYBACK_HEAD.unpack_from(frame)
    number = frame[_PLAYBACK_HEAD.size :]
    # The peer chose the length and the command.
    if command > 1 or len(number) != length:
        raise PeerError("a playback request with an unknown command or a wrong length")
    try:
        request_id = number.decode()
    except UnicodeDecodeError as error:
        raise PeerError("the id of a playback request is no text") from error
    return FoxglovePlayback(
        play=command == 0,
        speed=speed,
        seek_ns=seek_ns if seeks else None,
        request_id=request_id,
    )


def _op_of(frame: str) -> str | None:
    try:
        return msgspec.json.decode(frame, type=_Op).op
    except (msgspec.DecodeError, RecursionError, UnicodeError):
        return None
