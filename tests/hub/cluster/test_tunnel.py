"""Both ends of a tunnel: messages as they were sent, in order, or an end that both notice."""

import asyncio

import pytest
from hypothesis import given, settings, strategies as st

from talaia.hub.cluster.bus import BusLane
from talaia.hub.cluster.frames import LARGEST_PIECE, TunnelFrame
from talaia.hub.cluster.tunnel import TunnelBroken, TunnelEnd, TunnelName, window_of

NAME = TunnelName("hub", 1)


def two_ends(lose=lambda _number: False):
    """Give two ends that are joined; of what goes down, ``lose`` loses some by its number."""
    ends = []

    async def down(_name, _lane, frame: TunnelFrame) -> None:
        if not lose(frame.sequence):
            ends[1].receive_frame(frame)

    async def up(_name, _lane, frame: TunnelFrame) -> None:
        ends[0].receive_frame(frame)

    ends += [
        TunnelEnd(NAME, BusLane.URGENT, "websocket", post=down),
        TunnelEnd(NAME, BusLane.URGENT, "websocket", post=up),
    ]
    return ends


async def all_of(end) -> list:
    return [message async for message in messages_of(end)]


async def messages_of(end):
    while (message := await end.receive_message()) is not None:
        yield message


@given(sizes=st.lists(st.integers(0, 3 * LARGEST_PIECE), max_size=8))
@settings(max_examples=30, deadline=None)
async def test_messages_of_any_size_come_whole_and_in_order(sizes) -> None:
    sender, taker = two_ends()
    sent = [
        {"type": "websocket.send", "bytes": bytes([at]) * size} for at, size in enumerate(sizes)
    ]

    async def send() -> None:
        for message in sent:
            await sender.send_message(message)
        await sender.end_tunnel()

    _, come = await asyncio.gather(send(), all_of(taker))
    assert come == sent
    assert taker.over == ""


@given(lost=st.integers(0, 9))
@settings(deadline=None)
async def test_a_lost_frame_ends_the_tunnel_and_nothing_behind_it_comes(lost) -> None:
    sender, taker = two_ends(lambda number: number == lost)
    for at in range(10):
        await sender.send_message({"type": "websocket.send", "text": str(at)})
    assert taker.over == (None if lost == 9 else "something was lost between two hubs")
    await sender.end_tunnel()
    assert taker.over == "something was lost between two hubs"
    # What came before the hole is not acted on either: it is of the past.
    assert await taker.receive_message() is None


async def test_a_sender_waits_for_a_peer_that_takes_nothing() -> None:
    sender, taker = two_ends()
    message = {"type": "websocket.send", "bytes": bytes(window_of("websocket"))}
    await sender.send_message(message)
    waiting = asyncio.create_task(sender.send_message(message))
    # As many turns of the loop as a send without a window would take, and more.
    for _ in range(20):
        await asyncio.sleep(0)
    assert not waiting.done()
    await taker.receive_message()
    await waiting


async def test_whoever_waits_for_room_is_told_that_the_other_end_is_gone() -> None:
    sender, _ = two_ends()
    message = {"type": "websocket.send", "bytes": bytes(window_of("websocket"))}
    await sender.send_message(message)
    waiting = asyncio.create_task(sender.send_message(message))
    await asyncio.sleep(0)
    sender.break_off("the hub that led is gone")
    with pytest.raises(TunnelBroken, match="the hub that led is gone"):
        await waiting


@pytest.mark.parametrize("breaker", [0, 1])
async def test_what_is_broken_off_at_one_end_is_over_at_the_other(breaker) -> None:
    ends = two_ends()
    await ends[0].send_message({"type": "websocket.receive", "text": "first"})
    await ends[1].send_message({"type": "websocket.send", "text": "second"})
    ends[breaker].break_off("the hub between is gone")
    await ends[breaker].end_tunnel()
    # That one may have nothing to say, and would wait for ever.
    assert ends[1 - breaker].over == "the hub between is gone"


async def test_an_end_is_not_answered_by_an_end() -> None:
    sent = []
    ends = []

    async def down(_name, _lane, frame: TunnelFrame) -> None:
        sent.append(frame.kind.name)
        ends[1].receive_frame(frame)

    async def up(_name, _lane, frame: TunnelFrame) -> None:
        sent.append(frame.kind.name)

    ends += [TunnelEnd(NAME, BusLane.URGENT, "websocket", post=post) for post in (down, up)]
    await ends[0].end_tunnel("the asker has gone")
    await ends[1].end_tunnel("the hub ends")
    assert sent == ["END"]


async def test_what_cannot_be_posted_ends_the_tunnel() -> None:
    async def refuse(*_) -> None:
        raise ConnectionError("NATS is away")

    end = TunnelEnd(NAME, BusLane.BULK, "http", post=refuse)
    with pytest.raises(TunnelBroken, match="NATS is away"):
        await end.send_message({"type": "http.request", "body": b""})
    assert end.over == "NATS is away"
