"""Frames: what goes in comes out, and what is hostile is refused with a close code."""

from __future__ import annotations

from contextlib import suppress

import msgspec
import pytest
from hypothesis import given, strategies as st

from talaia.wire import browser, frames
from talaia.wire.errors import PeerError
from talaia.wire.shape import Codec

CODECS: list[Codec] = [
    frames.LINK_FROM_GATEWAY,
    frames.LINK_FROM_HUB,
    frames.MEDIA_FROM_GATEWAY,
    frames.MEDIA_FROM_HUB,
    browser.FROM_BROWSER,
    browser.TO_BROWSER,
    browser.MEDIA_TO_BROWSER,
    browser.MEDIA_FROM_BROWSER,
]
DRIVE = frames.Drive(
    device="base", session="s", epoch=3, seq=9, tick=77, held_ms=4.5, linear=0.1, angular=-1.0
)


def test_a_frame_survives_both_forms() -> None:
    for codec, message in (
        (frames.LINK_FROM_HUB, DRIVE),
        (
            frames.LINK_FROM_GATEWAY,
            frames.Samples(
                boot="b", first=7, catalogue="c", base_us=1, channel=b"\0\1", offset=b"\0" * 4,
                value=b"\0" * 8, texts={0: "on"},
            ),
        ),
        (browser.FROM_BROWSER, browser.Subscribe(sub=1, site="agv", channels=["base/speed"])),
    ):  # fmt: skip
        assert codec.decode(codec.encode(message)) == message
        assert codec.decode(codec.encode_text(message)) == message


def test_a_newer_peers_unknown_field_is_ignored_and_a_missing_one_takes_its_default() -> None:
    fields = msgspec.to_builtins(DRIVE) | {"from_the_future": [1, 2, 3]}
    del fields["held_ms"]
    message = frames.LINK_FROM_HUB.decode(msgspec.msgpack.encode(fields))
    assert message == msgspec.structs.replace(DRIVE, held_ms=0.0)


@pytest.mark.parametrize("codec", CODECS, ids=lambda each: str(id(each)))
@given(data=st.binary(max_size=400))
def test_any_bytes_are_a_frame_or_a_peer_error(codec: Codec, data: bytes) -> None:
    with suppress(PeerError):
        codec.decode(data)


@pytest.mark.parametrize("codec", CODECS, ids=lambda each: str(id(each)))
@given(text=st.text(max_size=200))
def test_any_text_is_a_frame_or_a_peer_error(codec: Codec, text: str) -> None:
    with suppress(PeerError):
        codec.decode(text)


def test_a_frame_over_the_limit_is_refused_before_it_is_read() -> None:
    with pytest.raises(PeerError) as caught:
        browser.MEDIA_FROM_BROWSER.decode(b"\0" * 5000)
    assert caught.value.code == 1009


def test_a_deeply_nested_frame_is_refused() -> None:
    with pytest.raises(PeerError):
        frames.LINK_FROM_HUB.decode(b"\x91" * 5000 + b"\xc0")


def test_a_negative_or_huge_sequence_is_refused() -> None:
    for seq in (-1, 2**63):
        fields = msgspec.to_builtins(DRIVE) | {"seq": seq}
        with pytest.raises(PeerError):
            frames.LINK_FROM_HUB.decode(msgspec.msgpack.encode(fields))


def test_a_driving_frame_cannot_come_from_the_gateway() -> None:
    with pytest.raises(PeerError, match="unknown kind"):
        frames.LINK_FROM_GATEWAY.decode(frames.LINK_FROM_HUB.encode(DRIVE))
