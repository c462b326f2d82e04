"""Messages are read in turns, and all pages together leave the hub most of its time."""

from __future__ import annotations

import asyncio
import itertools

import pytest

from talaia.clock import SystemClock
from talaia.hub.live.taps.tree_lane import TreeLane
from talaia.hub.live.taps.type_texts import MessageUnreadable

LARGE = bytes(20_000)


def counted() -> dict[str, object]:
    return {"a": sum(range(300_000))}


async def test_large_messages_are_read_one_after_another_with_rests_between() -> None:
    clock = SystemClock()
    lane, reads = TreeLane(clock), []

    def read(_data: bytes) -> dict[str, object]:
        began_ns = clock.monotonic_ns()
        found = counted()
        reads.append((began_ns, clock.monotonic_ns()))
        return found

    await asyncio.gather(*(lane.encode_tree(read, LARGE) for _ in range(4)))
    for (began_ns, ended_ns), (next_ns, _) in itertools.pairwise(reads):
        assert next_ns - ended_ns >= 2 * (ended_ns - began_ns)


async def test_small_message_does_not_wait_for_large_ones() -> None:
    lane = TreeLane(SystemClock())
    large = asyncio.create_task(lane.encode_tree(lambda _data: counted(), LARGE))
    await asyncio.sleep(0)
    assert await lane.encode_tree(lambda _data: {"b": 2}, b"small") == '{"b":2}'
    assert not large.done()
    await large


async def test_message_that_cannot_be_read_gives_the_turn_on() -> None:
    def unreadable(_data: bytes) -> dict[str, object]:
        raise MessageUnreadable("no such message")

    lane = TreeLane(SystemClock())
    with pytest.raises(MessageUnreadable):
        await lane.encode_tree(unreadable, LARGE)
    with pytest.raises(MessageUnreadable, match="too large to be shown"):
        await lane.encode_tree(lambda _data: {"a" * 2_000_000: 1}, LARGE)
    assert await lane.encode_tree(lambda _data: {}, LARGE) == "{}"
