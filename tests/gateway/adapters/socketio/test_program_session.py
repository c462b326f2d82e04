"""One program: what it kept while it was away is no reading of now."""

from __future__ import annotations

import asyncio

import pytest
from patience import PATIENCE_S

from talaia.clock import SECOND
from talaia.engineio.engine_connection import EngineConnection, LineGone
from talaia.gateway.adapters.socketio.program_session import ProgramSession
from talaia.wire.socketio.engine_packets import EngineKind, EnginePacket, EngineRevision


class HeldClock:
    """A clock that stands until it is moved."""

    now_ns = 0

    def monotonic_ns(self) -> int:
        return self.now_ns

    def wall_ns(self) -> int:
        return self.now_ns


class Heard:
    """An `EventReceiver` that keeps what it gets."""

    places = ("/", "sensedData")

    def __init__(self) -> None:
        """Have heard nothing."""
        self.events: asyncio.Queue[tuple[str, bool]] = asyncio.Queue()
        self.programs = 0

    def receive_event(self, place, event, args, *, fresh) -> str:
        self.events.put_nowait((event, fresh))
        return "nothing reads it"

    def count_program(self, place, change) -> None:
        self.programs += change

    def describe_site(self) -> dict[str, object]:
        return {}


@pytest.mark.parametrize("revision", EngineRevision)
async def test_data_count_for_interlocks_once_a_program_is_there_for_a_while(revision) -> None:
    clock, heard = HeldClock(), Heard()
    line = EngineConnection(revision, clock=clock)
    serving = asyncio.create_task(ProgramSession(line, heard, clock).read_program())

    async def send(text: str) -> None:
        await line.receive_packet(EnginePacket(EngineKind.MESSAGE, text))

    async with asyncio.timeout(PATIENCE_S):
        await send("0/sensedData,")
        await send('2/sensedData,["kept",1]')
        assert await heard.events.get() == ("kept", False)
        clock.now_ns += 2 * SECOND
        await send('2/sensedData,["fresh",1]')
        assert await heard.events.get() == ("fresh", True)
        # A namespace that there is not, and one that it has left.
        await send("0/other,")
        await send('2/other,["nowhere",1]')
        await send("1/sensedData,")
        await send('2/sensedData,["left",1]')
        await line.close_line()
        with pytest.raises(LineGone):
            await serving
    assert heard.events.empty()
    assert heard.programs == 0
