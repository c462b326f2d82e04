"""One trial of a row: what it came to, and how it is judged; and the limits that rows have."""

from __future__ import annotations

import asyncio
import contextlib
import random
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from patience import lasts_for
from websockets.exceptions import ConnectionClosed

from .description import HEARTBEAT_S, LASTING_S, MOUNT_S, MOVE_S, WATCHDOG_S
from .judge import Unsafe, judge
from .world import World

# A closing by the description: the telescope is waited for, then the roof moves.
CLOSE_S = MOUNT_S + MOVE_S
# The station speaks twice a second; the gateway looks ten times.
HEARD_S = 1.0
STATION_S = HEARD_S + CLOSE_S
# An obstacle is over: a roof is asked again after at most this (the guard's backoff).
AGAIN_S = 30.0
NOT_CLOSED = ("enclosure_not_closed", "enclosure_disagrees")
# A gateway starts within this on a machine that others use, too; no promise of the product.
START_S = 40.0
# What a machine that others use takes from a standstill that is meant to be short.
SHORT_S = 3.3
# The guard asks, waits 2 s, asks again, and says so; before that the telescope is waited for.
TOLD_S = HEARD_S + CLOSE_S + 8.0
ALTERNATING_S = HEARD_S + 3 * LASTING_S + CLOSE_S
# The dome's controller misses the heartbeat; the last one came up to 2 s before.
DEAD_S = HEARTBEAT_S + 2.0 + MOVE_S
# INDI's domes take no heartbeat: the watchdog process closes, which has to start and join first.
JOIN_S = 20.0
# After a crash a driver is told to connect at once, and again after 5 s.
RECONNECT_S = 6.0
# How the gateway's disk is from the moment before the fault on, by turns of the seeds.
DISKS = ("healthy", "full", "read-only", "failing")


def disk_of(row: Row, seed: int) -> str:
    """Give how the disk is in a trial."""
    return DISKS[(seed - 1) % len(DISKS)] if row.disks else DISKS[0]


def dead_s(protocol: str) -> float:
    """Give within how long a roof is closed whose gateway is dead or stands still."""
    return WATCHDOG_S + JOIN_S + CLOSE_S if protocol == "INDI" else DEAD_S


@dataclass
class Run:
    """One trial, and what became of it.

    Attributes:
        disk: how the gateway's disk is, from `harm_disk` on; one of `DISKS`.
        closed_s: how long it took to close (s), each time that was judged.
        told_s: how long until a person was told (s).
        violations: what must not have been.
        counted: what else happened.

    """

    world: World
    chance: random.Random
    protocol: str = "ROS 2"
    disk: str = "healthy"
    closed_s: list[float] = field(default_factory=list)
    told_s: list[float] = field(default_factory=list)
    violations: list[str] = field(default_factory=list)
    counted: dict[str, int] = field(default_factory=dict)

    def breach(self, text: str) -> None:
        self.violations.append(text)

    async def closes(
        self, since: int, limit_s: float, *, rated: bool = True, turn_s: float = 3.0
    ) -> None:
        """Wait until the roof is closed and stays so; judge what it did since then."""
        world = self.world
        ends = since + round(limit_s * 1e9)
        while world.truth() != "closed" and time.monotonic_ns() < ends + 1_000_000_000:
            await asyncio.sleep(0.05)
        # It has to stay closed for a while; `judge` says below whether it did.
        await lasts_for(0.8)
        lines = world.lines()
        until = time.monotonic_ns()
        took, wrong = judge(lines, Unsafe(since, until, limit_s, turn_s=turn_s, rated=rated))
        if took is not None:
            self.closed_s.append(took)
        elif not wrong:
            wrong = [f"still open after {limit_s:g} s"]
        self.violations += wrong

    async def told(self, since_wall: int, limit_s: float, *kinds: str) -> None:
        """Wait until a person is told of one of these."""
        kinds = kinds or NOT_CLOSED
        while not (found := self.world.events(since_wall, *kinds)):
            if time.time_ns() - since_wall > limit_s * 1e9:
                self.breach(f"nobody was told {' or '.join(kinds)} within {limit_s:g} s")
                return
            await asyncio.sleep(0.05)
        took = (found[0].time_us * 1000 - since_wall) / 1e9
        self.told_s.append(took)
        if took > limit_s:
            self.breach(f"told after {took:.1f} s of {limit_s:g} s")

    async def pause(self, least: float = 0.0, most: float = 0.8) -> None:
        await lasts_for(self.chance.uniform(least, most))

    async def begin(self) -> None:
        """Have the roof open, with the telescope parked or pointing, and the disk as it is."""
        await self.world.opened(tracking=self.chance.random() < 0.4)
        await self.pause()
        await self.harm_disk()

    async def harm_disk(self) -> None:
        """Let the disk be as this trial wants it, until the end of the trial."""
        if self.disk != DISKS[0]:
            self.world.disk(self.disk)
            await self.pause(0.0, 0.5)

    async def refused(self, device: str, command: str, why: str, who: str = "Bea") -> None:
        """Let a person ask for what must be refused."""
        phase = ""
        for _ in range(5):
            # On a link that is just lost nobody is answered, and nothing is done.
            with contextlib.suppress(AssertionError, ConnectionClosed):
                asked = await self.world.ask(device, command, who)
                phase = str((await self.world.ended(asked, 10.0)).phase)
                break
        if phase != "refused":
            self.breach(f"{device}/{command} {why}: {phase}")


class Row(NamedTuple):
    """A row.

    Attributes:
        limit_s: closed within (s), as the description's own times say.
        obstacle: something keeps it from closing, and the limit counts from its end.
        short: in `make test` also where it is not ROS 2.
        protocols: what it can be done with.
        roof: the kind of enclosure: a dome with a slit, or a clamshell.
        disks: done on a disk that is healthy, full, read-only and failing, by turns of the seeds.

    """

    name: str
    what: str
    run: Callable[[Run], Awaitable[None]]
    limit_s: float
    obstacle: bool = False
    short: bool = False
    protocols: tuple[str, ...] = ("ROS 2", "ROS 1", "INDI")
    roof: str = "dome"
    disks: bool = True

    def limit(self, protocol: str) -> float:
        """Give the limit with a protocol."""
        return dead_s(protocol) if self.name in ("killed", "frozen") else self.limit_s
