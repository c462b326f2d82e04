"""What may be under way: bounded, and never stuck once it was taken."""

from hypothesis import given, strategies as st

from talaia.hub.cluster.window import CreditWindow, TakenCount


@given(st.lists(st.tuples(st.booleans(), st.integers(0, 5000)), max_size=60))
def test_no_more_is_under_way_than_the_limit_and_one_message(steps) -> None:
    window, taken, under_way = CreditWindow(4000), TakenCount(4000), 0
    for sends, size in steps:
        if sends and window.has_room:
            window.spend_bytes(size)
            under_way += size
        elif under_way:
            part = min(size, under_way)
            under_way -= part
            window.earn_bytes(taken.add_taken(part))
        assert under_way < 4000 + 5000


@given(st.lists(st.integers(0, 3000), min_size=1, max_size=40))
def test_whoever_takes_everything_lets_the_sender_go_on(sizes) -> None:
    window, taken = CreditWindow(4000), TakenCount(4000)
    for size in sizes:
        # What was taken and is not told yet never fills the window.
        assert window.has_room
        window.spend_bytes(size)
        window.earn_bytes(taken.add_taken(size))


def test_a_peer_cannot_earn_more_than_was_sent() -> None:
    window = CreditWindow(100)
    window.earn_bytes(10**9)
    window.spend_bytes(100)
    assert not window.has_room
