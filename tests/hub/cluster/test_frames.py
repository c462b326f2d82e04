"""Frames between hubs: written and read back, refused when they are nobody's, never out of step."""

from hypothesis import given, strategies as st

from talaia.hub.cluster.frames import FrameKind, FrameSeal, SequenceCheck, TunnelFrame, cut_pieces

KEY = bytes(range(32))
FRAMES = st.builds(
    TunnelFrame,
    st.sampled_from(FrameKind),
    st.integers(0, 2**64 - 1),
    st.integers(0, 2**64 - 1),
    st.binary(max_size=300),
)


@given(frame=FRAMES, subject=st.text(max_size=40))
def test_a_frame_is_read_as_it_was_written(frame, subject) -> None:
    seal = FrameSeal(KEY)
    assert FrameSeal(KEY).read_frame(subject, seal.write_frame(subject, frame)) == frame


@given(frame=FRAMES, at=st.integers(0, 10**6), flip=st.integers(1, 255))
def test_a_frame_that_was_changed_on_the_way_is_none(frame, at, flip) -> None:
    data = bytearray(FrameSeal(KEY).write_frame("a.b", frame))
    data[at % len(data)] ^= flip
    assert FrameSeal(KEY).read_frame("a.b", bytes(data)) is None


@given(frame=FRAMES)
def test_a_frame_fits_no_other_hub_and_no_other_key(frame) -> None:
    data = FrameSeal(KEY).write_frame("hub.one", frame)
    assert FrameSeal(KEY).read_frame("hub.two", data) is None
    assert FrameSeal(KEY[::-1]).read_frame("hub.one", data) is None


@given(data=st.binary(max_size=64))
def test_bytes_of_a_stranger_are_no_frame(data) -> None:
    assert FrameSeal(KEY).read_frame("hub.one", data) is None


@given(data=st.binary(max_size=200), largest=st.integers(1, 64))
def test_pieces_are_the_message_and_only_the_last_says_so(data, largest) -> None:
    pieces = list(cut_pieces(data, largest))
    assert b"".join(piece for _, piece in pieces) == data
    assert all(len(piece) <= largest for _, piece in pieces)
    assert [kind is FrameKind.LAST for kind, _ in pieces] == [False] * (len(pieces) - 1) + [True]


@given(st.lists(st.integers(0, 20), max_size=40))
def test_what_is_accepted_begins_at_nothing_and_has_no_hole(numbers) -> None:
    check = SequenceCheck()
    accepted = [number for number in numbers if check.accept_number(number)]
    assert accepted == list(range(len(accepted)))
