"""Hubs of which one loses the bus for a moment: what was under way is over at both ends."""

# ruff: noqa: D107
import asyncio
from fnmatch import fnmatchcase

import pytest

from talaia.clock import HandClock
from talaia.hub.cluster.member import ClusterMember


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


@pytest.mark.parametrize("loser", [0, 1], ids=["the lead", "the hub between"])
async def test_a_hub_that_lost_the_bus_is_back_and_the_other_end_knows_what_is_over(loser) -> None:
    ether, ended, closed = Ether(), [], []

    async def app(_scope, receive, send) -> None:
        assert (await receive())["type"] == "websocket.connect"
        await send({"type": "websocket.accept"})
        ended.append((await receive())["type"])

    asked = [{"type": "websocket.connect"}]

    async def ask():
        return asked.pop() if asked else await asyncio.Future()

    async def hear(message) -> None:
        if message["type"] == "websocket.close":
            closed.append(message["code"])

    lead, between = await member_on(ether, "east"), await member_on(ether, "west")
    await lead.begin_leading(app, 1)
    await between._say_notice()
    scope = {"type": "websocket", "path": "/ws", "headers": [], "client": None, "server": None}
    page = asyncio.create_task(between.entrance.serve_request(scope, ask, hear))
    await turns()
    ether.buses[loser].lose()
    ether.buses[loser].regain()
    await turns()
    # A page that says nothing would wait for ever for values that nobody sends any more, and what
    # it holds would stay held.
    assert page.done()
    assert closed == [1012]
    assert ended == ["websocket.disconnect"]
