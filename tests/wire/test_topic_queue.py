"""What waits for a line: bounded, and the newest count."""

from __future__ import annotations

from hypothesis import given, strategies as st

from talaia.wire.topic_queue import ArrivalMeter, RateGate, TopicQueue

SECOND_US = 1_000_000


def queue(share: int = 100, most: int = 1000, age_us: int = SECOND_US) -> TopicQueue[int]:
    return TopicQueue(share=share, most=most, age_us=age_us)


def drained(waiting: TopicQueue[int]) -> list[tuple[object, int]]:
    found = []
    while (one := waiting.next_message()) is not None:
        found.append(one)
    return found


def test_of_a_topic_that_comes_often_the_oldest_give_way() -> None:
    waiting = queue()
    for number in range(10):
        waiting.add("a", number, 40, now_us=number, kept=False)
    assert drained(waiting) == [("a", 8), ("a", 9)]
    assert waiting.dropped == 8


def test_the_newest_is_held_whatever_its_size() -> None:
    waiting = queue()
    waiting.add("a", 1, 5000, now_us=0, kept=False)
    waiting.add("b", 2, 5000, now_us=0, kept=True)
    assert drained(waiting) == [("b", 2)]
    waiting.add("a", 3, 5000, now_us=0, kept=False)
    assert drained(waiting) == [("a", 3)]


def test_what_is_much_older_than_the_newest_is_left_out() -> None:
    waiting = queue()
    waiting.add("a", 1, 1, now_us=0, kept=False)
    waiting.add("a", 2, 1, now_us=SECOND_US, kept=False)
    waiting.add("a", 3, 1, now_us=SECOND_US + 1, kept=False)
    assert drained(waiting) == [("a", 2), ("a", 3)]


def test_what_is_to_be_kept_is_kept() -> None:
    waiting = queue()
    for number in range(20):
        waiting.add("map", number, 40, now_us=number * SECOND_US, kept=True)
        waiting.add("scan", number, 10, now_us=number * SECOND_US, kept=False)
    found = drained(waiting)
    assert [item for topic, item in found if topic == "map"] == list(range(20))
    assert ("scan", 19) in found


def test_topics_take_turns() -> None:
    waiting = queue()
    for number in range(3):
        waiting.add("a", number, 1, now_us=0, kept=False)
    waiting.add("b", 7, 1, now_us=0, kept=False)
    assert drained(waiting) == [("a", 0), ("b", 7), ("a", 1), ("a", 2)]


def test_a_topic_that_is_skipped_keeps_its_turn() -> None:
    waiting = queue()
    waiting.add("a", 1, 1, now_us=0, kept=False)
    waiting.add("b", 2, 1, now_us=0, kept=False)
    assert waiting.next_message(skip={"a"}) == ("b", 2)
    assert waiting.next_message(skip={"a"}) is None
    assert waiting.next_message() == ("a", 1)


@given(
    st.lists(
        st.tuples(st.sampled_from("abcd"), st.integers(0, 400), st.booleans(), st.booleans()),
        max_size=200,
    )
)
def test_it_is_bounded_in_order_and_counts_right(steps) -> None:
    waiting = queue()
    held: list[tuple[str, int, int]] = []
    taken: list[tuple[object, int]] = []
    for number, (topic, size, kept, takes) in enumerate(steps):
        waiting.add(topic, number, size, now_us=number, kept=kept)
        held.append((topic, number, size))
        assert waiting.bytes <= 1000 + size
        if takes and (found := waiting.next_message()) is not None:
            taken.append(found)
    taken += drained(waiting)
    assert waiting.bytes == 0
    assert len(taken) + waiting.dropped == len(steps)
    # The newest of all has come through, and each topic in its order.
    assert not steps or steps[-1][0] in {topic for topic, _ in taken}
    for topic in "abcd":
        numbers = [item for name, item in taken if name == topic]
        assert numbers == sorted(numbers)


def test_a_topic_comes_seldom_below_five_a_second() -> None:
    seldom, often = ArrivalMeter(), ArrivalMeter()
    assert all(seldom.count_arrival(number * 250_000) for number in range(100))
    found = [often.count_arrival(number * 100_000) for number in range(100)]
    assert not any(found[10:])


def test_a_rate_is_kept_although_publishers_jitter() -> None:
    gate = RateGate(10)
    jitter = [0, 4_000, -3_000, 2_000]
    passed = sum(gate.passes(n * 33_333 + jitter[n % 4]) for n in range(300))
    assert 95 <= passed <= 101
    # After silence nothing is made up for.
    assert gate.passes(100 * SECOND_US)
    assert not gate.passes(100 * SECOND_US + 1)
    assert all(RateGate(0).passes(0) for _ in range(10))
