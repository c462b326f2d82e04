"""Lists within lists, from whoever means ill: refused in words, at whatever depth."""

from __future__ import annotations

import json

import pytest

from talaia.gateway.adapters.json_signals import parse_payload
from talaia.gateway.adapters.rosbridge.protocol import read_message
from talaia.gateway.adapters.socketio.event_data import data_of
from talaia.gateway.errors import FieldError
from talaia.hub.clients.published_message import read_published
from talaia.wire.errors import PeerError
from talaia.wire.foxglove.codec import decode_client
from talaia.wire.nested_json import MOST_LEVELS, decode_nested
from talaia.wire.rosbridge.codec import RosbridgeMistake, decode_rosbridge
from talaia.wire.socketio.socket_packets import SocketAssembly

# Just over the bound; where the decoder still reads what our own code no longer could; beyond both.
DEPTHS = (MOST_LEVELS + 1, 300, 900, 100_000)


def nested(depth: int, begin: str = "[", end: str = "]") -> str:
    return begin * depth + "1" + end * depth


@pytest.mark.parametrize(("begin", "end"), [("[", "]"), ('{"a":', "}"), ('[{"a":', "}]")])
def test_json_is_read_down_to_the_bound_and_no_deeper(begin, end) -> None:
    at_most = MOST_LEVELS // (begin.count("{") + begin.count("["))
    assert decode_nested(text := nested(at_most, begin, end)) == json.loads(text)
    for depth in (at_most + 1, *DEPTHS):
        for data in (nested(depth, begin, end), nested(depth, begin, end).encode()):
            with pytest.raises(ValueError, match=f"nested deeper than {MOST_LEVELS} levels"):
                decode_nested(data)


def test_brackets_side_by_side_or_in_a_text_are_no_depth() -> None:
    for value in ([[]] * 5000, "[{" * 5000, {str(at): {} for at in range(5000)}):
        assert decode_nested(json.dumps(value)) == value


@pytest.mark.parametrize("depth", DEPTHS)
def test_every_reader_of_a_clients_json_refuses_what_is_nested_too_deeply(depth) -> None:
    text = nested(depth)
    with pytest.raises(ValueError, match="nested deeper"):
        read_published("json", "a/msg/B", f'{{"a":{text}}}'.encode())
    with pytest.raises(PeerError, match="nested deeper"):
        SocketAssembly().add_message(f'2["drive",{text}]')
    # Beside what is asked for, a depth that nobody reads is no fault until it cannot be passed by.
    if depth == DEPTHS[-1]:
        with pytest.raises(RosbridgeMistake, match="nested too deeply"):
            decode_rosbridge(f'{{"op":"publish","topic":"/a","msg":{text}}}')
        with pytest.raises(PeerError, match="nested too deeply"):
            decode_client(f'{{"op":"getParameters","other":{text}}}')


@pytest.mark.parametrize("depth", DEPTHS)
def test_every_reader_of_a_robots_json_passes_over_what_is_nested_too_deeply(depth) -> None:
    text = nested(depth)
    with pytest.raises(FieldError, match=r"nested deeper|recursion"):
        read_message(f'{{"op":"publish","msg":{{"a":{text}}}}}')
    with pytest.raises(FieldError, match="nested too deeply"):
        read_message(b"\x81" * depth + b"\x00")
    assert not parse_payload(text.encode()).is_json
    assert data_of([text]) == text
