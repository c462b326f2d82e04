"""The faults of several hubs, one row each: what is done to them, and what must hold.

Each row drives the robot when it begins, and again when the fault is over; an alarm comes up in the
midst of it; the crowd sends and looks on all the while.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import os
import random
import time
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import NamedTuple
from zlib import crc32

import websockets
from patience import lasts_for

from talaia.wire.frames import (
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    PIECE,
    FileOffer,
    FilePiece,
    FileProgress,
)

from ..faults.doing import back, pause
from ..faults.ledgers import Findings
from .cluster_world import MAIN, ClusterWorld, Member, freeze, wake
from .load import Load, cluster_load


@contextlib.asynccontextmanager
async def driven(
    world: ClusterWorld, chance: random.Random, findings: Findings
) -> AsyncIterator[Load]:
    """Drive, do what is inside, and drive again when all is well."""
    async with cluster_load(world, findings) as load:
        async with load.driving() as driver:
            await load.run.mark(driver)
            await pause(chance)
            load.begin_fault()
            yield load
            await load.run.let_go()
        async with back(findings):
            await load.drive_again()


@contextlib.asynccontextmanager
async def lead_changes(
    world: ClusterWorld, findings: Findings, shard: str = ""
) -> AsyncIterator[Member]:
    """Give the hub that leads, and wait until another one does; what is inside is its fault.

    ``shard``: which one it leads; none: that of the robot's site.
    """
    shard = shard or world.shard
    lead, counts, at = await world.lead(shard), world.times_led(shard), time.monotonic_ns()
    yield lead
    await world.another_leads(lead, counts, shard)
    findings.figures["another led after, s"].append((time.monotonic_ns() - at) / 1e9)


async def cut_from_bus(hub: Member, load: Load, chance: random.Random) -> None:
    """Let a hub hear no other one for some seconds, in which an alarm comes up."""
    with hub.bus.dark():
        await load.raise_alarm()
        await lasts_for(chance.uniform(3.0, 5.0))


async def k1(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """`kill -9` the hub that leads: another one does, and everybody comes to it."""
    async with driven(world, chance, findings) as load:
        async with lead_changes(world, findings) as lead:
            at = lead.kill()
            await load.raise_alarm()
            await load.must_stop(at)
        lead.start()


async def k2(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """`kill -9` a hub that waits, with all that came in by it."""
    async with driven(world, chance, findings) as load:
        busiest, *_ = await world.others()
        busiest.kill()
        await load.raise_alarm()
        busiest.start()


async def k3(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """The hub that leads stands still until another one leads, and wakes up."""
    async with driven(world, chance, findings) as load:
        async with lead_changes(world, findings) as lead:
            at = freeze(lead)
            await load.raise_alarm()
            await load.must_stop(at)
        wake(lead)


async def k4(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """The hub that leads is cut from NATS: it leads on, and who came to others comes to it."""
    async with driven(world, chance, findings) as load:
        lead = await world.lead()
        led = lead.times_led(world.shard)
        await cut_from_bus(lead, load, chance)
        if lead.times_led(world.shard) != led or not lead.runs:
            findings.breach("lead", "a hub that has the database does not lead on")


async def k5(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """A hub that waits is cut from NATS: who came to it comes to the others."""
    async with driven(world, chance, findings) as load:
        busiest, *_ = await world.others()
        await cut_from_bus(busiest, load, chance)


async def k6(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """The hub that leads is cut from the database: another one leads."""
    async with (
        driven(world, chance, findings) as load,
        contextlib.AsyncExitStack() as dark,
        lead_changes(world, findings) as lead,
    ):
        dark.enter_context(lead.database.dark())
        await load.raise_alarm()


async def k7(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """`kill -9` the server of NATS, of three, by which the lead speaks: they go on by another."""
    async with driven(world, chance, findings) as load:
        node = world.nats.node_of((await world.lead()).name)
        node.kill()
        await load.raise_alarm()
        node.start()


async def k8(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """A split: two hubs believe that they lead, then it heals."""
    async with driven(world, chance, findings) as load, contextlib.AsyncExitStack() as dark:
        async with lead_changes(world, findings) as lead:
            dark.enter_context(lead.bus.dark())
            dark.enter_context(lead.database.dark())
            await load.raise_alarm()
        # A hub is ready where the main shard is reached; of another one it does not say so.
        if world.shard == MAIN and not await lead.is_ready():
            findings.breach("row", "the one that was cut off did not believe that it leads")


async def k9(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """The clock of one hub is an hour off; it takes the lead over, and gives it back."""
    hours = (1, -1)[findings.turn % 2]
    findings.counted[f"{hours:+d} h"] += 1
    async with driven(world, chance, findings) as load:
        wrong, other = await world.others()
        for member in (wrong, other):
            await member.leave()
        wrong.offset_s = 3600.0 * hours
        wrong.start()
        wrong.offset_s = 0.0
        await world.ready_at(wrong)
        async with lead_changes(world, findings) as lead:
            at = lead.kill()
            await load.raise_alarm()
            await load.must_stop(at)
        for member in (lead, other):
            member.start()
        for member in (lead, other):
            await world.ready_at(member)
        async with lead_changes(world, findings):
            await wrong.leave()
        wrong.start()


async def k10(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """All three hubs are replaced, one after the other, as for a new version."""
    async with driven(world, chance, findings) as load:
        await load.raise_alarm()
        for name, member in world.members.items():
            code = await member.leave()
            if code != 0:
                findings.breach("row", f"{name} ended with {code}")
            member.start()
            await world.ready_at(member)


async def k11(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """The object store is away, full and slow while recordings are brought; the lead dies, too."""
    troubles = deque(("away", "full", "slow"))
    troubles.rotate(-findings.turn)
    async with driven(world, chance, findings) as load:
        # Two of them alone, and with the third the hub that leads is killed.
        *alone, last = troubles
        for trouble in reversed(alone):
            await bring_within(world, findings, trouble)
        async with bringing_within(world, findings, last), lead_changes(world, findings) as lead:
            at = lead.kill()
            await load.raise_alarm()
            await load.must_stop(at)
        lead.start()


async def s2(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """`kill -9` the hub that leads the main shard: the robot is of another one, and goes on."""
    async with driven(world, chance, findings) as load:
        async with lead_changes(world, findings, MAIN) as lead:
            lead.kill()
            await load.raise_alarm()
        lead.start()


async def s11(world: ClusterWorld, chance: random.Random, findings: Findings) -> None:
    """The robot's site goes to the main shard, and `kill -9` its lead that holds it; and back."""
    async with driven(world, chance, findings) as load:
        moving = asyncio.create_task(world.move_site("own"))
        async with lead_changes(world, findings) as lead:
            await world.site_held()
            at = lead.kill()
            await load.raise_alarm()
            await load.must_stop(at)
        lead.start()
        await moving
        began = time.monotonic_ns()
        await world.move_site(world.shard)
        findings.figures["moved back within, s"].append((time.monotonic_ns() - began) / 1e9)


async def bring_within(world: ClusterWorld, findings: Findings, trouble: str) -> None:
    """Let a recording come while the store has a trouble, and be there after it."""
    async with bringing_within(world, findings, trouble):
        pass


@contextlib.asynccontextmanager
async def bringing_within(
    world: ClusterWorld, findings: Findings, trouble: str
) -> AsyncIterator[None]:
    """Let a recording come while the store has a trouble; what is inside happens meanwhile."""
    line = world.store_line
    findings.counted[trouble] += 1
    name = f"20260101T120000Z-{os.urandom(3).hex()}"
    body = os.urandom(PIECE + 5)
    if trouble == "away":
        line.away = True
    elif trouble == "full":
        line.refusal = (507, "XMinioStorageFull")
    else:
        line.slow_s = 1.5
    bringing = asyncio.create_task(_bring_recording(world, name, body))
    try:
        # By then the hub has all of it, and the store has nothing.
        await lasts_for(1.0)
        yield
        if trouble != "slow" and bringing.done():
            findings.breach("I1", f"a file is acknowledged that the store, {trouble}, lacks")
    finally:
        line.away, line.refusal, line.slow_s = False, None, 0.0
    async with asyncio.timeout(60):
        await bringing
    path = f"/api/sites/crowd0/recordings/{name}/file"
    async with world.client() as client:
        answer = await client.get(path, headers={"Cookie": await world.cookie()})
    if answer.content != body:
        findings.breach("I1", f"an acknowledged file is not there ({answer.status_code})")


async def _bring_recording(world: ClusterWorld, name: str, body: bytes) -> None:
    """Hand a file over as a gateway does, again after each loss, until it is acknowledged."""
    keys = dict(line.split() for line in (world.folder / "crowd-keys").read_text().splitlines())
    headers = {"Authorization": f"Bearer {keys['crowd0']}"}
    address = f"ws://localhost:{world.port}/gateway/files"
    while True:
        with contextlib.suppress(OSError, TimeoutError, websockets.WebSocketException):
            async with websockets.connect(
                address, additional_headers=headers, proxy=None, ping_interval=None
            ) as socket:
                await _send_file(socket, name, body)
                return
        await asyncio.sleep(0.3)


async def _send_file(socket: websockets.ClientConnection, name: str, body: bytes) -> None:
    """Send a file over one connection, until the hub has it."""
    digest = hashlib.sha256(body).hexdigest()
    asked: FileOffer | FilePiece = FileOffer(
        id=name, size=len(body), digest=digest, begin_us=1, end_us=2
    )
    while True:
        await socket.send(FILES_FROM_GATEWAY.encode(asked))
        has = FILES_FROM_HUB.decode(await socket.recv())
        if not isinstance(has, FileProgress):
            raise ConnectionError("the hub says good-bye")
        if has.done:
            return
        data = body[has.have : has.have + PIECE]
        asked = FilePiece(id=name, at=has.have, check=crc32(data), data=data)


class Row(NamedTuple):
    """One line of the table; ``short``: it is also of each run of the tests."""

    name: str
    what: str
    run: Callable[[ClusterWorld, random.Random, Findings], Awaitable[None]]
    short: bool
    divided: bool = False


# The others are near to one of these, and wait as long.
_SHORT = (k1, k7, k8, k10, k11)
ROWS = [
    Row(
        run.__name__.upper(),
        (run.__doc__ or "").rstrip(".").replace("\n", " "),
        run,
        run in _SHORT,
    )
    for run in (k1, k2, k3, k4, k5, k6, k7, k8, k9, k10, k11)
]
# The same where the robot's site and half of the crowd are of a shard of their own; in a world of
# its own, so after the others.
ROWS += [
    Row(
        f"S{run.__name__[1:]}",
        "Sites divided: " + (run.__doc__ or "").rstrip(".").replace("\n", " "),
        run,
        run in (k1, s2),
        divided=True,
    )
    for run in (k1, s2, k3, k6, k8, k10, s11)
]

__all__ = ["ROWS", "Row"]
