"""A client's line: who is silent is gone, what waits is bounded, and a WebSocket takes over."""

from __future__ import annotations

import asyncio

import pytest
from patience import PATIENCE_S

from talaia.clock import MS, SystemClock
from talaia.engineio.engine_connection import (
    EngineConnection,
    EngineTimes,
    LineGone,
)
from talaia.wire.errors import PeerError
from talaia.wire.socketio.engine_packets import EngineKind, EnginePacket, EngineRevision

OLD, NEW = EngineRevision.OLD, EngineRevision.NEW
QUICK = EngineTimes(ping_ns=20 * MS, timeout_ns=30 * MS)
PROBE = EnginePacket(EngineKind.PING, "probe")


def line_of(revision=NEW) -> EngineConnection:
    return EngineConnection(revision, user=1, clock=SystemClock(), times=QUICK)


@pytest.mark.parametrize(("revision", "pinged"), [(OLD, []), (NEW, [EngineKind.PING])])
async def test_client_that_is_silent_is_gone_and_only_a_new_one_is_pinged(revision, pinged) -> None:
    line = line_of(revision)
    async with asyncio.timeout(PATIENCE_S):
        await line.keep_alive()
    await line.close_line()
    # However often it was due: one ping waits for a client that does not read.
    kinds = [packet.kind for packet in await line.pull_packets()]
    assert kinds == [*pinged, EngineKind.CLOSE]
    with pytest.raises(LineGone):
        await line.pull_packets()
    with pytest.raises(LineGone):
        await line.next_message()
    with pytest.raises(LineGone):
        await line.send_messages(["late"])


async def test_ping_of_an_old_client_is_answered_with_its_own_words() -> None:
    line = line_of(OLD)
    await line.receive_packet(EnginePacket(EngineKind.PING, "words"))
    assert await line.pull_packets() == [EnginePacket(EngineKind.PONG, "words")]


async def test_session_waits_while_much_waits_and_pings_add_nothing_to_it() -> None:
    line = line_of(OLD)
    await line.send_messages(["x" * 300_000])
    second = asyncio.create_task(line.send_messages(["second"]))
    for _ in range(100):
        await line.receive_packet(EnginePacket(EngineKind.PING, "y" * 10_000))
    assert not second.done()
    assert line.waiting_bytes == 300_001
    await line.pull_packets()
    async with asyncio.timeout(PATIENCE_S):
        await second
    assert [packet.data for packet in await line.pull_packets()] == ["second"]


async def test_poll_has_few_packets_and_the_rest_comes_in_order() -> None:
    line = line_of()
    await line.send_messages([str(number) for number in range(40)])
    pulled = [await line.pull_packets(polling=True) for _ in range(3)]
    assert [len(packets) for packets in pulled] == [16, 16, 8]
    assert [int(packet.data) for packets in pulled for packet in packets] == list(range(40))
    assert line.waiting_bytes == 0


async def test_websocket_takes_over_and_the_waiting_poll_ends_with_nothing() -> None:
    line = line_of()
    poll = asyncio.create_task(line.pull_packets(polling=True))
    await asyncio.sleep(0)
    assert await line.offer_upgrade(PROBE) == EnginePacket(EngineKind.PONG, "probe")
    async with asyncio.timeout(PATIENCE_S):
        assert await poll == [EnginePacket(EngineKind.NOOP)]
    with pytest.raises(PeerError):
        await line.offer_upgrade(PROBE)
    await line.end_upgrade(done=True)
    with pytest.raises(PeerError), line.hold_poll():
        pass
    await line.send_messages(["after"])
    assert [packet.data for packet in await line.pull_packets()] == ["after"]


async def test_upgrade_that_comes_to_nothing_leaves_polling_as_it_was() -> None:
    line = line_of()
    with pytest.raises(PeerError):
        await line.offer_upgrade(EnginePacket(EngineKind.MESSAGE, "40"))
    await line.offer_upgrade(PROBE)
    await line.end_upgrade(done=False)
    with line.hold_poll():
        await line.send_messages(["on"])
        assert [packet.data for packet in await line.pull_packets(polling=True)] == ["on"]
