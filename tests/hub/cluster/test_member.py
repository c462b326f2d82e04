"""Hubs of which one loses the bus for a moment: what was under way is over at both ends."""

# ruff: noqa: D107
import asyncio
from fnmatch import fnmatchcase

import pytest
import pytest_asyncio

from talaia.clock import HandClock
from talaia.hub.cluster.member import ClusterMember
from talaia.wire.socket_frame import FRAME_WRITER, SocketFrame


class Ether:
    """The servers between the hubs."""

    def __init__(self) -> None:
        self.buses = []


class HeldBus:
    """A bus of an ether, which may be lost; others are told nothing of that."""

    connected = True

    def __init__(self, ether: Ether) -> None:
        self._ether = ether
        ether.buses.append(self)

    async def open(self, subjects, receive, lost, returned) -> None:
        self._subjects, self._receive = subjects, receive
        self._lost, self._returned = lost, returned

    async def publish(self, lane, subject, data) -> None:
        if not self.connected:
            raise ConnectionError("away")
        for bus in self._ether.buses:
            if bus.connected and any(
                fnmatchcase(subject, name) for name in bus._subjects.get(lane, ())
            ):
                bus._receive(lane, subject, data)

    def lose(self) -> None:
        self.connected = False
        self._lost()

    def regain(self) -> None:
        self.connected = True
        self._returned()

    async def close(self) -> None: ...


async def member_on(ether: Ether, name: str) -> ClusterMember:
    def superseded() -> None:
        raise AssertionError("nobody else leads")

    bus = HeldBus(ether)
    member = ClusterMember(
        bus, HandClock(), key=bytes(32), name=name, version="1", superseded=superseded
    )
    await member.open()
    return member


async def turns() -> None:
    """Let whatever is due have its turns."""
    for _ in range(20):
        await asyncio.sleep(0)


class AskedHub:
    """Two hubs, of which one leads, and a page that comes in at the other."""

    def __init__(self, ether: Ether, lead: ClusterMember, between: ClusterMember) -> None:
        self.ether, self.lead, self.between = ether, lead, between
        # What the application hears at its end, and the code with which the page's socket closes.
        self.ended, self.closed = [], []

    async def answer(self, _scope, receive, send) -> None:
        assert (await receive())["type"] == "websocket.connect"
        await send({"type": "websocket.accept"})
        self.ended.append((await receive())["type"])

    def open_page(self) -> asyncio.Task[None]:
        """Let a page come that never says anything."""
        asked = [{"type": "websocket.connect"}]

        async def ask():
            return asked.pop() if asked else await asyncio.Future()

        async def hear(message) -> None:
            if message["type"] == "websocket.close":
                self.closed.append(message["code"])

        scope = {"type": "websocket", "path": "/ws", "headers": [], "client": None, "server": None}
        return asyncio.create_task(self.between.entrance.serve_request(scope, ask, hear))


@pytest_asyncio.fixture
async def asked() -> AskedHub:
    ether = Ether()
    lead, between = await member_on(ether, "east"), await member_on(ether, "west")
    made = AskedHub(ether, lead, between)
    await lead.begin_leading(made.answer, 1)
    await between._say_notice()
    return made


@pytest.mark.parametrize("loser", [0, 1], ids=["the lead", "the hub between"])
async def test_a_hub_that_lost_the_bus_is_back_and_the_other_end_knows_what_is_over(
    asked: AskedHub, loser: int
) -> None:
    page = asked.open_page()
    await turns()
    asked.ether.buses[loser].lose()
    asked.ether.buses[loser].regain()
    await turns()
    # A page that says nothing would wait for ever for values that nobody sends any more, and what
    # it holds would stay held.
    assert page.done()
    assert asked.closed == [1012]
    assert asked.ended == ["websocket.disconnect"]


async def test_who_comes_before_the_hub_between_was_heard_again_is_let_stay(
    asked: AskedHub,
) -> None:
    asked.ether.buses[0].lose()
    asked.ether.buses[0].regain()
    await turns()
    page = asked.open_page()
    await turns()
    # The lead's next beat; the one of the hub between is not due yet.
    asked.lead._end_broken()
    await turns()
    assert not page.done()
    assert asked.ended == []
    page.cancel()


async def test_a_page_whose_way_the_lead_ends_hears_so_by_a_hub_that_lives_after_all(
    asked: AskedHub,
) -> None:
    page = asked.open_page()
    await turns()
    asked.lead.answering.break_off("the hub between is gone", hub=asked.between.hub)
    await turns()
    assert page.done()
    assert asked.closed == [1012]
    assert asked.ended == ["websocket.disconnect"]


async def test_what_the_lead_writes_to_many_pages_is_written_at_once_by_the_hub_between() -> None:
    ether = Ether()
    lead, between = await member_on(ether, "east"), await member_on(ether, "west")
    writers, wrote, sent = [], [], []

    async def answer(scope, receive, send) -> None:
        await receive()
        await send({"type": "websocket.accept"})
        writers.append(scope["extensions"][FRAME_WRITER]["write"])
        await receive()

    await lead.begin_leading(answer, 1)
    await between._say_notice()

    def asker():
        asked = [{"type": "websocket.connect"}]

        async def ask():
            return asked.pop() if asked else await asyncio.Future()

        return ask

    async def hear(message) -> None:
        sent.append(message["type"])

    def take_frame(frame) -> bool:
        wrote.append(frame)
        return True

    extensions = {FRAME_WRITER: {"write": take_frame}}
    scope = {"type": "websocket", "path": "/ws", "headers": [], "extensions": extensions}
    pages = [
        asyncio.create_task(between.entrance.serve_request({**scope}, asker(), hear))
        for _ in range(3)
    ]
    await turns()
    frame = SocketFrame(b"values")
    assert all(write(frame) for write in writers)
    await turns()
    # Made once, so that its bytes are the same for each socket.
    assert [taken.data for taken in wrote] == [b"values"] * 3
    assert len({id(taken) for taken in wrote}) == 1
    assert sent == ["websocket.accept"] * 3
    for page in pages:
        page.cancel()
    await asyncio.gather(*pages, return_exceptions=True)
