"""Samples that somebody looks at go out soon, the others as ever, and each goes out once."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from hypothesis import example, given, strategies as st

from talaia.gateway.samples.batching import Batcher
from talaia.gateway.samples.flush_pace import SOON_S
from talaia.gateway.samples.signal_watch import SignalWatch
from talaia.wire.columns import Columns, unpack_columns
from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch, SignalSubscription

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable

    from talaia.gateway.spool.segment import SampleRecord

USUAL_S = 0.02
CHANNELS = ["dome/a", "dome/b", "cart/c", "cart/d"]


class HandLoop:
    """An event loop whose time is moved by hand."""

    def __init__(self) -> None:  # noqa: D107
        self.now_s = 100.0
        self.woken = 0
        self._soon: deque[Callable[[], None]] = deque()
        self._timers: list[HandTimer] = []

    def call_soon_threadsafe(self, call: Callable[[], None]) -> None:
        self.woken += 1
        self._soon.append(call)

    def call_later(self, delay_s: float, call: Callable[[], None]) -> HandTimer:
        timer = HandTimer(self.now_s + max(delay_s, 0.0), call)
        self._timers.append(timer)
        return timer

    def run_for(self, span_s: float) -> None:
        end_s = self.now_s + span_s
        while True:
            while self._soon:
                self._soon.popleft()()
            due = [timer for timer in self._timers if timer.when_s <= end_s]
            if not due:
                break
            timer = min(due, key=lambda timer: timer.when_s)
            self._timers.remove(timer)
            self.now_s = max(self.now_s, timer.when_s)
            timer.call()
        self.now_s = end_s


class HandTimer:
    """One call at a time."""

    def __init__(self, when_s: float, call: Callable[[], None]) -> None:  # noqa: D107
        self.when_s, self.call = when_s, call

    def cancel(self) -> None:
        self.call = lambda: None


class Gateway:
    """A batcher, with all that came out of it and when."""

    def __init__(self) -> None:  # noqa: D107
        self.loop = HandLoop()
        # Per batch: when, first number, channels and values.
        self.out: list[tuple[float, int, list[int], list[float]]] = []
        # Which devices are read how often (s).
        self.hurried: list[tuple[frozenset[str], float]] = []
        self.batcher = Batcher(
            loop=cast("asyncio.AbstractEventLoop", self.loop),
            boot="b",
            catalogue="c",
            flush=USUAL_S,
            keep=self._keep,
            lose=lambda *_: None,
            now_s=lambda: self.loop.now_s,
            spent_s=lambda: 0.0,
        )
        self.watch = SignalWatch(batches=self.batcher, reader=self, listed=lambda: ("c", CHANNELS))
        self.put = 0

    def watch_devices(self, devices: frozenset[str], turn_s: float) -> None:
        self.hurried.append((devices, turn_s))

    def subscribe(self, *places: int, catalogue: str = "c", every_ms: int = 0) -> None:
        channels = np.array(places, "<u2").tobytes()
        self.watch.subscribe(
            SignalSubscription(catalogue=catalogue, channels=channels, every_ms=every_ms)
        )

    def say(self, *channels: int) -> None:
        """Hand over a sample of each; values count up."""
        values = np.arange(self.put, self.put + len(channels), dtype=np.float64)
        self.put += len(channels)
        times = (self.loop.now_s * 1e6 + np.arange(len(channels))).astype(np.int64)
        self.batcher.put_samples(Columns(np.array(channels, np.uint16), times, values, {}))

    def _keep(self, record: SampleRecord) -> None:
        frame = LINK_FROM_GATEWAY.decode(record.body)
        assert isinstance(frame, SampleBatch)
        part = unpack_columns(frame)
        self.out.append((self.loop.now_s, frame.first, part.channel.tolist(), part.value.tolist()))

    def ages_s(self, channel: int, said: dict[float, float]) -> list[float]:
        """Give how long each sample of a channel waited; ``said`` is when, by its value."""
        return [
            at - said[value]
            for at, _, channels, values in self.out
            for number, value in zip(channels, values, strict=True)
            if number == channel
        ]


def talk(gateway: Gateway, turns: int, turn_s: float, *channels: int) -> dict[float, float]:
    """Hand over a sample of each channel in each turn; give when, by value."""
    said: dict[float, float] = {}
    for _ in range(turns):
        said |= {float(gateway.put + at): gateway.loop.now_s for at in range(len(channels))}
        gateway.say(*channels)
        gateway.loop.run_for(turn_s)
    gateway.loop.run_for(1.0)
    return said


def test_what_is_watched_goes_out_with_the_turn_that_read_it() -> None:
    gateway = Gateway()
    gateway.subscribe(0)
    gateway.loop.run_for(1.0)
    said = talk(gateway, 200, SOON_S, 0)
    assert max(gateway.ages_s(0, said)) < 0.0001


def test_what_nobody_looks_at_keeps_its_pace_beside_what_is_watched() -> None:
    gateway = Gateway()
    gateway.subscribe(0)
    talk(gateway, 200, SOON_S, 0, 2)
    rests = [channels for _, _, channels, _ in gateway.out if 2 in channels]
    assert len(rests) <= 1.0 / (0.75 * USUAL_S) + 2
    # The others of its batches wait for it: none is a batch of one.
    assert sum(len(channels) == 1 for _, _, channels, _ in gateway.out) > 100


def test_without_anybody_who_looks_batches_and_wakes_are_those_of_before() -> None:
    gateway = Gateway()
    talk(gateway, 200, SOON_S, 0, 2)
    assert len(gateway.out) <= 1.0 / (0.75 * USUAL_S) + 2
    assert gateway.loop.woken <= len(gateway.out) + 2


def test_hand_overs_of_each_message_wake_the_loop_no_more_often_than_batches_are_made() -> None:
    gateway = Gateway()
    gateway.subscribe(0)
    talk(gateway, 4000, SOON_S / 20, 0)
    assert len(gateway.out) <= 4000 / 20 / 0.75 + 2
    assert gateway.loop.woken <= 2 * len(gateway.out) + 2


def test_what_is_watched_waits_for_the_next_turn_at_most() -> None:
    gateway = Gateway()
    gateway.subscribe(0)
    # Two at once, and then nothing: no third one makes the batch.
    gateway.loop.run_for(1.0)
    said = {0.0: gateway.loop.now_s}
    gateway.say(0)
    gateway.loop.run_for(0.001)
    said[1.0] = gateway.loop.now_s
    gateway.say(0)
    gateway.loop.run_for(1.0)
    first, second = gateway.ages_s(0, said)
    assert first == 0.0
    assert second <= 1.25 * SOON_S


def test_for_a_chart_batches_are_made_sooner_and_the_robot_is_read_more_often() -> None:
    gateway = Gateway()
    gateway.subscribe(0, every_ms=50)
    assert gateway.hurried == [(frozenset({"dome"}), 0.01)]
    gateway.loop.run_for(1.0)
    said = talk(gateway, 100, 0.01, 0)
    assert max(gateway.ages_s(0, said)) < 0.0001
    gateway.out.clear()
    talk(gateway, 200, SOON_S, 0)
    assert len(gateway.out) <= 1.0 / 0.0075 + 2


def test_who_leaves_makes_it_slow_again_and_so_does_a_lost_link() -> None:
    for leave in (lambda gateway: gateway.subscribe(), lambda gateway: gateway.watch.link_lost()):
        gateway = Gateway()
        gateway.subscribe(0, 1)
        assert gateway.hurried == [(frozenset({"dome"}), SOON_S)]
        leave(gateway)
        assert not gateway.hurried[-1][0]
        talk(gateway, 200, SOON_S, 0)
        assert len(gateway.out) <= 1.0 / (0.75 * USUAL_S) + 2


def test_a_subscription_of_another_list_or_of_no_channel_changes_nothing() -> None:
    gateway = Gateway()
    gateway.subscribe(1, 2, catalogue="other")
    assert gateway.hurried == []
    gateway.subscribe(7, 65_535)
    assert gateway.hurried == [(frozenset(), SOON_S)]
    gateway.watch.subscribe(SignalSubscription(catalogue="c", channels=b"\x00\x00\x01"))
    assert gateway.hurried[-1] == (frozenset({"dome"}), SOON_S)


def test_what_is_watched_is_found_by_the_description_that_counts() -> None:
    gateway = Gateway()
    # Numbers 0 to 3 stand at other places now, and 1 nowhere.
    gateway.batcher.redescribe("d", np.array([2, -1, 0, 1]))
    gateway.batcher.watch_channels("d", np.array([2], np.uint16))
    gateway.loop.run_for(1.0)
    gateway.say(2)
    gateway.loop.run_for(0.0)
    gateway.loop.run_for(SOON_S)
    gateway.out.clear()
    gateway.say(2, 0, 3)
    gateway.loop.run_for(0.0)
    assert [channels for _, _, channels, _ in gateway.out] == [[2]]


Steps = st.lists(
    st.one_of(
        st.tuples(st.just("say"), st.lists(st.integers(0, 3), min_size=1, max_size=5)),
        st.tuples(st.just("watch"), st.lists(st.integers(0, 3), max_size=4)),
        st.tuples(st.just("wait"), st.integers(0, 30)),
        st.tuples(st.just("flush"), st.none()),
    ),
    max_size=80,
)


def turns_of(*steps: tuple[str, Any]) -> list[tuple[str, Any]]:
    """Give steps after a while in which nobody spoke."""
    return [("wait", 30), *steps]


@given(Steps)
# What is watched overtakes what is not, which follows.
@example(turns_of(("watch", [0]), ("wait", 6), ("say", [1, 0, 2, 1]), ("wait", 1), ("say", [1, 0])))
# A channel that waited is watched from here on: its newer samples do not overtake its older ones.
@example(
    turns_of(
        ("watch", [0]),
        ("wait", 6),
        ("say", [0, 1]),
        ("wait", 1),
        ("watch", [0, 1]),
        ("wait", 6),
        ("say", [1, 0]),
        ("wait", 1),
    )
)
def test_each_sample_goes_out_once_in_the_order_of_its_channel_however_people_come_and_go(
    steps: list[tuple[str, Any]],
) -> None:
    gateway = Gateway()
    said: list[tuple[int, float]] = []
    for what, which in steps:
        if what == "say":
            said += [(channel, float(gateway.put + at)) for at, channel in enumerate(which)]
            gateway.say(*which)
        elif what == "watch":
            gateway.subscribe(*which)
        elif what == "wait":
            gateway.loop.run_for(which / 1000)
        else:
            gateway.batcher.flush_batches()
    gateway.loop.run_for(1.0)
    assert [first for _, first, _, _ in gateway.out] == list(
        np.cumsum([0, *(len(channels) for _, _, channels, _ in gateway.out)])[:-1]
    )
    heard = [
        pair
        for _, _, channels, values in gateway.out
        for pair in zip(channels, values, strict=True)
    ]
    for channel in range(4):
        assert [value for number, value in heard if number == channel] == [
            value for number, value in said if number == channel
        ]
