"""Frames are cut out of the bytes wherever these are divided, and the parser gets all others."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, strategies as st
from websockets.frames import Frame, Opcode

from talaia.hub.api.server.whole_frames import WholeFrame, WholeFrames

if TYPE_CHECKING:
    from collections.abc import Iterable

pytestmark = pytest.mark.pure
LARGEST = 70_000


def written(frame: Frame) -> bytes:
    """Write a frame as a client does, by a library that we did not write."""
    return frame.serialize(mask=True)


def cut(frames: WholeFrames, pieces: Iterable[bytes]) -> list[WholeFrame]:
    return [frame for piece in pieces for frame in frames.cut(piece)]


def divided(data: bytes, at: Iterable[int]) -> list[bytes]:
    ends = sorted({0, len(data), *(place % (len(data) + 1) for place in at)})
    return [data[first:past] for first, past in itertools.pairwise(ends)]


@given(
    st.lists(st.sampled_from([0, 1, 125, 126, 127, 1000, 65_535, 65_536]), min_size=1, max_size=5),
    st.lists(st.integers(0, 2**20), max_size=8),
)
def test_messages_come_out_as_they_were_said_however_they_are_divided(sizes, places) -> None:
    messages = [bytes([number % 251]) * size for number, size in enumerate(sizes)]
    data = b"".join(written(Frame(Opcode.BINARY, message)) for message in messages)
    found = cut(WholeFrames(LARGEST), divided(data, places))
    assert found == [WholeFrame(message, is_message=True) for message in messages]


@given(st.lists(st.integers(0, 2**20), max_size=8))
def test_whatever_is_no_whole_message_of_bytes_is_the_parsers_frame_by_frame(places) -> None:
    others = [
        Frame(Opcode.TEXT, b"words"),
        Frame(Opcode.PING, b"there?"),
        Frame(Opcode.BINARY, b"the beginning", fin=False),
        # Within a message: the parser knows that it does not belong there.
        Frame(Opcode.BINARY, b"another"),
        Frame(Opcode.PONG, b""),
        Frame(Opcode.CONT, b"the end"),
        Frame(Opcode.CLOSE, b"\x03\xe8"),
    ]
    as_written = [written(frame) for frame in others]
    # And one that says it is compressed, by the first of the reserved bits.
    compressed = bytearray(written(Frame(Opcode.BINARY, b"packed")))
    compressed[0] |= 0x40
    as_written.append(bytes(compressed))
    found = cut(WholeFrames(LARGEST), divided(b"".join(as_written), places))
    assert found == [WholeFrame(data, is_message=False) for data in as_written]


def test_after_a_message_of_several_frames_one_of_a_single_frame_is_a_message_again() -> None:
    parts = [
        Frame(Opcode.BINARY, b"a", fin=False),
        Frame(Opcode.CONT, b"b"),
        Frame(Opcode.BINARY, b"c"),
    ]
    found = cut(WholeFrames(LARGEST), map(written, parts))
    assert [frame.is_message for frame in found] == [False, False, True]
    assert found[-1].data == b"c"


def test_what_is_too_large_is_not_gathered_and_passes_as_it_comes() -> None:
    data = written(Frame(Opcode.BINARY, bytes(LARGEST + 1)))
    frames = WholeFrames(LARGEST)
    assert cut(frames, [data[:20]]) == [WholeFrame(data[:20], is_message=False)]
    assert cut(frames, [data[20:]]) == [WholeFrame(data[20:], is_message=False)]


def test_a_message_that_is_not_masked_is_the_parsers_who_refuses_it() -> None:
    data = Frame(Opcode.BINARY, b"bare").serialize(mask=False)
    assert cut(WholeFrames(LARGEST), [data]) == [WholeFrame(data, is_message=False)]
