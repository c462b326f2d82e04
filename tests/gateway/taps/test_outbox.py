"""Raw messages on their way to the hub: in pieces, in turns, and never more than the line takes."""

from __future__ import annotations

from collections import deque

from talaia.clock import HandClock
from talaia.gateway.taps.outbox import TAP_RECEIPTS, RawTap, TapOutbox
from talaia.gateway.taps.tap_window import TapWindow
from talaia.wire.frames import MEDIA_FROM_GATEWAY, PIECE, Beat, TapMessage, TopicList

MS = 1_000_000


class Line:
    """Takes so many bytes a second, holds what is sent too fast, and answers each receipt."""

    def __init__(self, outbox: TapOutbox, clock: HandClock, speed: float, way_ms: float) -> None:  # noqa: D107
        self.outbox, self.clock = outbox, clock
        self.speed, self.way_ns = speed, round(way_ms * MS)
        self.got: list[TapMessage] = []
        self.frames = 0
        # When what was sent last will have gone over the line, and what is under way.
        self._free_ns = 0
        self._under_way: deque[tuple[int, bytes]] = deque()
        self._back: deque[tuple[int, int]] = deque()
        # Bytes that waited on the way, at the most.
        self.backlog_ms = 0.0

    def run(self, seconds: float) -> None:
        """Go on in steps of a millisecond."""
        for _ in range(round(seconds * 1000)):
            self.clock.advance(MS)
            now_ns = self.clock.monotonic_ns()
            while (frame := self.outbox.next_frame()) is not None:
                self.frames += 1
                self._free_ns = max(self._free_ns, now_ns) + round(len(frame) / self.speed * 1e9)
                self._under_way.append((self._free_ns + self.way_ns, frame))
                self.backlog_ms = max(self.backlog_ms, (self._free_ns - now_ns) / MS)
            while self._under_way and self._under_way[0][0] <= now_ns:
                self._arrive(MEDIA_FROM_GATEWAY.decode(self._under_way.popleft()[1]), now_ns)
            while self._back and self._back[0][0] <= now_ns:
                self.outbox.take_receipt(self._back.popleft()[1])

    def _arrive(self, message: object, now_ns: int) -> None:
        if isinstance(message, Beat):
            self._back.append((now_ns + self.way_ns, message.n))
        elif isinstance(message, TapMessage):
            self.got.append(message)


def outbox_on(clock: HandClock) -> TapOutbox:
    outbox = TapOutbox(clock)
    outbox.link_up()
    return outbox


def raw(number: int, seq: int, data: bytes, *, kept: bool = False) -> RawTap:
    return RawTap(number, seq, 0, 0, kept, data)


def test_large_messages_go_whole_and_small_ones_between_their_pieces() -> None:
    clock = HandClock()
    outbox = outbox_on(clock)
    line = Line(outbox, clock, 100e6, 1)
    for seq in range(10):
        outbox.enqueue_message(raw(1, seq, bytes([seq]) * 1_000_000, kept=True))
    outbox.enqueue_message(raw(2, 0, b"small"))
    line.run(2)
    assert sum(len(piece.data) for piece in line.got) == 10_000_005
    assert max(len(piece.data) for piece in line.got) <= PIECE
    assert [piece.number for piece in line.got].index(2) < 3
    # Nothing of a topic's next message before the last piece of the one before.
    assert [piece.seq for piece in line.got if piece.number == 1] == sorted(
        piece.seq for piece in line.got if piece.number == 1
    )


def test_a_slow_line_is_used_and_never_filled() -> None:
    clock = HandClock()
    outbox = outbox_on(clock)
    line = Line(outbox, clock, 1.25e6, 20)
    for second in range(200):
        outbox.enqueue_message(raw(1, second, bytes(1_000_000)))
        line.run(0.1)
    line.backlog_ms, before = 0.0, sum(len(piece.data) for piece in line.got)
    for second in range(200, 400):
        outbox.enqueue_message(raw(1, second, bytes(1_000_000)))
        line.run(0.1)
    sent = sum(len(piece.data) for piece in line.got) - before
    # Most of what it takes, and a picture never waits for long behind it.
    assert sent > 0.7 * 1.25e6 * 20
    assert line.backlog_ms < 150
    # What came too fast was left out, and what went was new.
    assert outbox.dropped > 100
    assert line.got[-1].seq > 390


def test_a_fast_line_is_not_held_back() -> None:
    clock = HandClock()
    outbox = outbox_on(clock)
    line = Line(outbox, clock, 200e6, 0.2)
    for seq in range(100):
        outbox.enqueue_message(raw(1, seq, bytes(1_000_000)))
        line.run(0.05)
    assert sum(len(piece.data) for piece in line.got) == 100_000_000


def test_notices_go_before_messages_and_nothing_without_a_connection() -> None:
    clock = HandClock()
    outbox = TapOutbox(clock)
    woken = []
    outbox.on_waiting = lambda: woken.append(1)
    outbox.enqueue_message(raw(1, 0, b"lost"))
    outbox.enqueue_notice(TopicList())
    assert outbox.next_frame() is None
    assert not woken
    outbox.link_up()
    outbox.enqueue_message(raw(1, 1, b"kept"))
    outbox.enqueue_notice(TopicList())
    assert len(woken) == 1
    frames = [MEDIA_FROM_GATEWAY.decode(outbox.next_frame()) for _ in range(2)]
    assert [type(frame) for frame in frames] == [TopicList, TapMessage]
    outbox.enqueue_message(raw(1, 2, b"lost, too"))
    outbox.link_lost()
    outbox.link_up()
    assert outbox.next_frame() is None


def test_what_nobody_wants_any_more_is_forgotten() -> None:
    clock = HandClock()
    outbox = outbox_on(clock)
    for seq in range(3):
        outbox.enqueue_message(raw(1, seq, bytes(200_000), kept=True))
    assert outbox.next_frame() is not None
    outbox.forget_topic(1)
    # Of what has gone the receipt is asked for, and that is all.
    assert isinstance(MEDIA_FROM_GATEWAY.decode(outbox.next_frame()), Beat)
    assert outbox.next_frame() is None


def test_an_empty_message_is_one_piece() -> None:
    outbox = outbox_on(HandClock())
    outbox.enqueue_message(raw(1, 0, b""))
    piece = MEDIA_FROM_GATEWAY.decode(outbox.next_frame())
    assert (piece.size, piece.data) == (0, b"")
    assert outbox.next_frame() is None


def test_a_receipt_that_was_not_asked_for_changes_nothing() -> None:
    window = TapWindow()
    window.arrived(7, 1)
    assert window.has_room()
    assert TAP_RECEIPTS > 2**40


def test_receipts_are_few_where_the_line_bears_much() -> None:
    window, piece, asked = TapWindow(), 64 * 1024, []
    for now_us in range(0, 2_000_000, 1000):
        while window.has_room():
            if (number := window.sent(piece, now_us)) is not None:
                asked.append((number, now_us))
        # All of it has arrived by the next millisecond.
        for number, _ in asked[-100:]:
            window.arrived(number, now_us + 500)
    late = [number for number, now_us in asked if now_us > 1_000_000]
    assert window.piece() == piece
    # Sixteen pieces of a window of 4 MiB for each, not one.
    assert len(late) <= 1000 * (4 * 1024 * 1024 // (256 * 1024)) + 1
