"""What a client sends is cut into the messages that it sent, however its bytes come."""

from __future__ import annotations

from hypothesis import given, strategies as st
from websockets.frames import Frame, Opcode
from websockets.protocol import OPEN
from websockets.server import ServerProtocol

from talaia.hub.api.server.client_frames import FrameCutter

MOST = 300
# Around what is short, and around the lengths that RFC 6455 writes in different ways.
Sizes = st.sampled_from([0, 1, 125, 126, MOST, MOST + 1, 65_535, 65_536])
Frames = st.lists(
    st.tuples(
        st.sampled_from([Opcode.BINARY, Opcode.TEXT, Opcode.PING]),
        Sizes,
        st.booleans(),
    ),
    max_size=6,
)


def sent(frames: list[tuple[Opcode, int, bool]]) -> list[Frame]:
    """Make what a client may send: messages, some in two frames, and pings between."""
    made = []
    for number, (opcode, size, in_two) in enumerate(frames):
        data = bytes([number]) * size
        if opcode is Opcode.PING:
            made.append(Frame(opcode, data[:125]))
        elif in_two:
            # A ping may stand within a message.
            made += [
                Frame(opcode, data, fin=False),
                Frame(Opcode.PING, b"within"),
                Frame(Opcode.CONT, data),
            ]
        else:
            made.append(Frame(opcode, data))
    return made


@given(Frames, st.lists(st.integers(1, 70_000), min_size=1))
def test_a_message_is_cut_out_or_left_to_the_reader_and_none_is_lost_or_comes_twice(
    frames: list[tuple[Opcode, int, bool]], chunks: list[int]
) -> None:
    wanted = sent(frames)
    line = b"".join(frame.serialize(mask=True) for frame in wanted)
    cutter, reader = FrameCutter(MOST), ServerProtocol(state=OPEN)
    got, passed, at = [], 0, 0
    while at < len(line):
        size = chunks[at % len(chunks)]
        for piece in cutter.cut_frames(line[at : at + size]):
            passed += len(piece.data)
            if piece.payload:
                assert len(piece.message) <= MOST
                got.append((Opcode.BINARY, piece.message))
            else:
                reader.receive_data(piece.data)
                got += [(frame.opcode, bytes(frame.data)) for frame in reader.events_received()]
        at += size
    assert reader.parser_exc is None
    assert got == [(frame.opcode, frame.data) for frame in wanted]
    assert passed == len(line)


def test_short_messages_that_come_whole_are_cut_out() -> None:
    line = Frame(Opcode.BINARY, b"a").serialize(mask=True)
    line += Frame(Opcode.BINARY, b"b" * MOST).serialize(mask=True)
    pieces = list(FrameCutter(MOST).cut_frames(line))
    assert [piece.message for piece in pieces] == [b"a", b"b" * MOST]


def test_what_is_not_masked_or_says_more_than_its_length_is_left_to_the_reader() -> None:
    bare = Frame(Opcode.BINARY, b"bare").serialize(mask=False)
    marked = bytearray(Frame(Opcode.BINARY, b"marked").serialize(mask=True))
    # A bit that only an extension gives a meaning.
    marked[0] |= 0x40
    for line in (bare, bytes(marked)):
        assert [piece.payload for piece in FrameCutter(MOST).cut_frames(line)] == [0]


@given(st.lists(st.binary(max_size=40), max_size=20))
def test_any_bytes_are_given_out_as_they_came_but_for_a_head_that_is_not_whole(
    chunks: list[bytes],
) -> None:
    cutter = FrameCutter(MOST)
    out = b"".join(piece.data for chunk in chunks for piece in cutter.cut_frames(chunk))
    came = b"".join(chunks)
    assert came.startswith(out)
    assert len(came) - len(out) < 14
