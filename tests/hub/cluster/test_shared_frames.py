"""A frame for many sockets crosses once, and each socket has all that it was sent, in order."""

# ruff: noqa: D107
import asyncio

import pytest
from hypothesis import given, settings, strategies as st

from talaia.hub.cluster.bus import BusLane
from talaia.hub.cluster.frames import FrameKind, TunnelFrame
from talaia.hub.cluster.shared_frames import SharedFrames, read_shared
from talaia.hub.cluster.tunnel import TunnelEnd, TunnelName, window_of
from talaia.wire.socket_frame import SocketFrame

SOCKETS = 3


class TwoHubs:
    """A hub that leads and one between, joined by a bus; sockets are open through both."""

    def __init__(self, *, writes: bool = True) -> None:
        # What the lead has posted, by kind; what each socket got; and whether it takes more.
        self.posted: list[FrameKind] = []
        self.got: list[list] = [[] for _ in range(SOCKETS)]
        self.taking = True
        self.lose_shared = self.away = False
        shared = SharedFrames(self.down)
        self.lead, self.between = [], []
        for at in range(SOCKETS):
            name = TunnelName("between", at + 1)
            self.lead.append(
                TunnelEnd(name, BusLane.URGENT, "websocket", post=self.down, shared=shared)
            )

            def write(frame, at=at) -> bool:
                if self.taking:
                    self.got[at].append(frame.data)
                return self.taking

            name = TunnelName("lead", at + 1)
            end = TunnelEnd(
                name, BusLane.URGENT, "websocket", post=self.up, write=write if writes else None
            )
            self.between.append(end)

    async def down(self, name, _lane, frame) -> None:
        if self.away:
            raise ConnectionError("NATS is away")
        # As a bus of sockets has it: it is on its way before anybody else has a turn.
        self.posted.append(frame.kind)
        if frame.kind is not FrameKind.SHARED:
            self.between[name.number - 1].receive_frame(frame)
        elif not self.lose_shared:
            takers, shared = read_shared(frame.payload)
            for number, sequence in takers:
                self.between[number - 1].receive_shared(sequence, shared)
        await asyncio.sleep(0)

    async def up(self, name, _lane, frame) -> None:
        self.lead[name.number - 1].receive_frame(frame)

    async def take(self, at: int) -> None:
        """Hand on what comes for one socket as the entrance does, with a pause in each."""
        while (message := await self.between[at].receive_message()) is not None:
            await asyncio.sleep(0)
            self.got[at].append(message.get("text", message.get("bytes")))

    async def send(self, at: int, data: bytes | str) -> None:
        """Send as an application does: at once where that can be, else as ASGI has it."""
        word = "text" if isinstance(data, str) else "bytes"
        await self.lead[at].send_message({"type": "websocket.send", word: data})


async def turns(count: int = 20) -> None:
    for _ in range(count):
        await asyncio.sleep(0)


STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("everybody"), st.integers(0, 2 * window_of("websocket") // 3)),
        st.tuples(st.just("one"), st.integers(0, SOCKETS - 1)),
        st.tuples(st.just("taking"), st.booleans()),
        st.tuples(st.just("turn"), st.just(0)),
    ),
    max_size=40,
)


@given(steps=STEPS, writes=st.booleans())
@settings(max_examples=60, deadline=None)
async def test_each_socket_has_everything_in_the_order_in_which_it_was_sent(steps, writes) -> None:
    hubs = TwoHubs(writes=writes)
    taking = [asyncio.create_task(hubs.take(at)) for at in range(SOCKETS)]
    sent: list[list] = [[] for _ in range(SOCKETS)]
    for number, (what, how) in enumerate(steps):
        match what:
            case "everybody":
                frame = SocketFrame(number.to_bytes(2) + bytes(how))
                for at, end in enumerate(hubs.lead):
                    sent[at].append(frame.data)
                    if not end.write_shared(frame):
                        await hubs.send(at, frame.data)
            case "one":
                sent[how].append(f"only you {number}")
                await hubs.send(how, f"only you {number}")
            case "taking":
                hubs.taking = how
            case "turn":
                await asyncio.sleep(0)
    for end in hubs.lead:
        await end.end_tunnel()
    async with asyncio.timeout(20):
        await asyncio.gather(*taking)
    assert hubs.got == sent
    assert [end.over for end in hubs.between] == [""] * SOCKETS


async def test_what_many_sockets_get_crosses_once() -> None:
    hubs = TwoHubs()
    for data in (b"first", "second"):
        frame = SocketFrame(data)
        assert all(end.write_shared(frame) for end in hubs.lead)
    await turns()
    assert hubs.posted == [FrameKind.SHARED] * 2
    assert hubs.got == [[b"first", "second"]] * SOCKETS


async def test_a_socket_that_takes_nothing_is_refused_more_and_the_others_go_on() -> None:
    hubs = TwoHubs()
    hubs.between[0]._write = lambda _frame: False
    frame, refused = SocketFrame(bytes(1000)), 0
    for _ in range(3 * window_of("websocket") // 1000):
        refused += not hubs.lead[0].write_shared(frame)
        assert hubs.lead[1].write_shared(frame)
        await turns()
    assert refused > window_of("websocket") // 1000
    # What it was sent waits there, and it has room again once that was taken.
    taking = asyncio.create_task(hubs.take(0))
    await turns(400)
    assert hubs.lead[0].write_shared(frame)
    taking.cancel()
    await asyncio.gather(taking, return_exceptions=True)


async def test_a_lost_shared_frame_ends_each_tunnel_at_the_next_thing_it_is_sent() -> None:
    hubs = TwoHubs()
    hubs.lose_shared = True
    for end in hubs.lead:
        end.write_shared(SocketFrame(b"lost"))
    await turns()
    hubs.lose_shared = False
    await hubs.send(0, b"next")
    hubs.lead[1].write_shared(SocketFrame(b"next"))
    await turns()
    assert [end.over for end in hubs.between] == [
        *["something was lost between two hubs"] * 2,
        None,
    ]
    assert hubs.got == [[]] * SOCKETS


async def test_a_shared_frame_that_cannot_be_posted_ends_the_tunnels_that_it_was_for() -> None:
    hubs = TwoHubs()
    hubs.away = True
    for end in hubs.lead[:2]:
        end.write_shared(SocketFrame(b"nobody hears it"))
    await turns()
    assert [end.over for end in hubs.lead] == ["NATS is away", "NATS is away", None]


async def test_who_asks_for_the_next_and_is_cancelled_holds_up_nobody() -> None:
    hubs = TwoHubs()
    for data in (b"first", b"second", b"third"):
        for end in hubs.lead:
            end.write_shared(SocketFrame(data))
    asking = asyncio.create_task(hubs.send(0, b"never"))
    await asyncio.sleep(0)
    asking.cancel()
    await asyncio.gather(asking, return_exceptions=True)
    await turns()
    assert hubs.got == [[b"first", b"second", b"third"]] * SOCKETS


def test_a_hub_of_before_is_sent_no_shared_frames() -> None:
    end = TunnelEnd(TunnelName("between", 1), BusLane.URGENT, "websocket", post=None)
    assert not end.write_shared(SocketFrame(b"it would not know it"))


@given(payload=st.binary(max_size=200))
def test_nonsense_is_no_shared_frame_or_has_its_takers_whole(payload) -> None:
    read = read_shared(payload)
    if read is not None:
        takers, frame = read
        assert len(payload) >= 16 * len(list(takers)) + len(frame.data)


@pytest.mark.parametrize("data", [b"", b"\xff" * 9, "", "grüß Gott"])
async def test_bytes_stay_bytes_and_text_stays_text(data) -> None:
    posted: list[TunnelFrame] = []

    async def post(_name, _lane, frame) -> None:
        posted.append(frame)

    shared, sent = SharedFrames(post), SocketFrame(data)
    for number in (3, 2**40):
        name = TunnelName("between", number)
        end = TunnelEnd(name, BusLane.URGENT, "websocket", post=post, shared=shared)
        assert end.write_shared(sent)
    await turns()
    takers, frame = read_shared(posted[0].payload)
    assert list(takers) == [(3, 0), (2**40, 0)]
    assert frame.data == data
