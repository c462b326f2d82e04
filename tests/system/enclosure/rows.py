"""The rows of the enclosure's table: what is done to a roof, and what must hold.

Long, because the rows are read beside each other, as in the table that they fill.
"""

from __future__ import annotations

import asyncio
import random
import signal
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import msgspec

from talaia.model.site import Site
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.sim.observatory.night import longitude_of_night

from .description import (
    FROZEN_S,
    HEARTBEAT_S,
    LASTING_S,
    LINK_LOSS_S,
    MAX_AGE_S,
    MOUNT_S,
    MOVE_S,
    WATCHDOG_S,
)
from .judge import Unsafe, judge
from .world import World

# A closing by the description: the telescope is waited for, then the roof moves.
CLOSE_S = MOUNT_S + MOVE_S
# The station speaks twice a second; the gateway looks ten times.
HEARD_S = 1.0
# An obstacle is over: a roof is asked again after at most this (the guard's backoff).
AGAIN_S = 30.0
NOT_CLOSED = ("enclosure_not_closed", "enclosure_disagrees")
# A gateway starts within this on a machine that others use, too; no promise of the product.
START_S = 40.0
# What a machine that others use takes from a standstill that is meant to be short.
SHORT_S = 3.3


@dataclass
class Run:
    """One trial, and what became of it.

    Attributes:
        closed_s: how long it took to close (s), each time that was judged.
        told_s: how long until a person was told (s).
        violations: what must not have been.
        counted: what else happened.

    """

    world: World
    chance: random.Random
    protocol: str = "ROS 2"
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
        # It has to stay closed for a while.
        await asyncio.sleep(0.8)
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
        await asyncio.sleep(self.chance.uniform(least, most))

    async def begin(self) -> None:
        """Have the roof open, with the telescope parked or pointing."""
        await self.world.opened(tracking=self.chance.random() < 0.4)
        await self.pause()


class Row(NamedTuple):
    """A row.

    Attributes:
        limit_s: closed within (s), as the description's own times say.
        obstacle: something keeps it from closing, and the limit counts from its end.
        short: in `make test` also where it is not ROS 2.
        protocols: what it can be done with.

    """

    name: str
    what: str
    run: Callable[[Run], Awaitable[None]]
    limit_s: float
    obstacle: bool = False
    short: bool = False
    protocols: tuple[str, ...] = ("ROS 2", "ROS 1", "INDI")

    def limit(self, protocol: str) -> float:
        """Give the limit with a protocol."""
        return dead_s(protocol) if self.name in ("killed", "frozen") else self.limit_s


def weather(fault: str, limit_s: float) -> Callable[[Run], Awaitable[None]]:
    """Make a row of a fault of the weather or its station."""

    async def run(trial: Run) -> None:
        await trial.begin()
        await trial.closes(await trial.world.fault_at(fault), limit_s)

    return run


async def alternating(trial: Run) -> None:
    """Good and bad values by turns: bad for at least half of the time."""
    await trial.begin()
    since = await trial.world.fault_at("weather set wind 70")
    bad = True
    ends = time.monotonic() + 3 * LASTING_S
    while time.monotonic() < ends and trial.world.truth() != "closed":
        await asyncio.sleep(trial.chance.uniform(0.5, 0.7) if bad else 0.5)
        bad = not bad
        trial.world.order(f"weather set wind {70 if bad else 8}")
    trial.world.order("weather set wind 70")
    await trial.closes(since, ALTERNATING_S)


def obstacle(
    *faults: str, ends: str, rated: bool = True, rain_first: bool = False
) -> Callable[[Run], Awaitable[None]]:
    """Make a row in which the roof cannot close: a person is told, and it closes afterwards."""

    async def run(trial: Run) -> None:
        await trial.begin()
        world = trial.world
        orders = [*faults, "weather rain"]
        if rain_first:
            orders.reverse()
        wall = time.time_ns()
        for each in orders:
            await world.fault_at(each)
            await trial.pause(0.0, 0.3)
        await trial.told(wall, TOLD_S)
        since = await world.fault_at(ends)
        await trial.closes(since, AGAIN_S + CLOSE_S, rated=rated)

    return run


# The guard asks, waits 2 s, asks again, and says so; before that the telescope is waited for.
TOLD_S = HEARD_S + CLOSE_S + 8.0
ALTERNATING_S = HEARD_S + 3 * LASTING_S + CLOSE_S


async def lying_open(trial: Run) -> None:
    """A switch that goes on to say open: it is closed all the same, and a person is told."""
    await trial.begin()
    await trial.world.fault_at("dome lying opened")
    wall = time.time_ns()
    since = await trial.world.fault_at("weather rain")
    await trial.closes(since, HEARD_S + CLOSE_S)
    await trial.told(wall, TOLD_S)


async def rain_while_opening(trial: Run) -> None:
    """Rain begins in the middle of an opening."""
    world = trial.world
    if trial.chance.random() < 0.4:
        await world.does("telescope", "unpark")
        world.order("telescope do goto_altaz 70 0")
    for _ in range(20):
        await world.ask("dome", "open")
        await asyncio.sleep(0.25)
        if world.truth() == "opening":
            break
    await trial.pause(0.0, 0.9)
    since = await world.fault_at("weather rain")
    await trial.closes(since, HEARD_S + CLOSE_S, turn_s=HEARD_S + 0.5)


async def mount_stuck(trial: Run) -> None:
    """The telescope does not park: after its time the roof closes all the same."""
    world = trial.world
    await world.opened(tracking=True)
    await trial.pause()
    await world.fault_at("telescope stuck")
    since = await world.fault_at("weather rain")
    await trial.closes(since, HEARD_S + CLOSE_S)


def disk(trouble: str) -> Callable[[Run], Awaitable[None]]:
    """Make a row of a disk that takes nothing, while it rains."""

    async def run(trial: Run) -> None:
        await trial.begin()
        trial.world.disk(trouble)
        await trial.pause(0.2, 1.5)
        since = await trial.world.fault_at("weather rain")
        await trial.closes(since, HEARD_S + CLOSE_S)

    return run


async def killed(trial: Run) -> None:
    """`kill -9` the gateway; then it rains."""
    await trial.begin()
    world = trial.world
    assert world.gateway is not None
    since = world.gateway.kill()
    await trial.pause(0.0, 2.0)
    await world.fault_at("weather rain")
    await trial.closes(since, dead_s(trial.protocol), rated=False)


async def frozen(trial: Run) -> None:
    """The gateway stands still; then it rains."""
    await trial.begin()
    since = trial.world.signal(signal.SIGSTOP)
    try:
        await trial.pause(0.0, 2.0)
        await trial.world.fault_at("weather rain")
        await trial.closes(since, dead_s(trial.protocol), rated=False)
    finally:
        trial.world.signal(signal.SIGCONT)
        await asyncio.sleep(2.0)


# The dome's controller misses the heartbeat; the last one came up to 2 s before.
DEAD_S = HEARTBEAT_S + 2.0 + MOVE_S
# INDI's domes take no heartbeat: the watchdog process closes, which has to start and join first.
JOIN_S = 20.0


def dead_s(protocol: str) -> float:
    """Give within how long a roof is closed whose gateway is dead or stands still."""
    return WATCHDOG_S + JOIN_S + CLOSE_S if protocol == "INDI" else DEAD_S


async def driver_crashed(trial: Run) -> None:
    """The INDI driver is killed; the server starts it again, and it rains."""
    await trial.begin()
    world = trial.world
    before = world.driver()
    world.driver_killed()
    await world.until(lambda: world.driver() != before, "the driver is back")
    await trial.pause(0.0, 3.0)
    since = await world.fault_at("weather rain")
    await trial.closes(since, RECONNECT_S + HEARD_S + CLOSE_S)
    if "rain" not in world.locked():
        trial.breach("the rain is not known after the driver is back")


# After a crash a driver is told to connect at once, and again after 5 s.
RECONNECT_S = 6.0


async def _stall(trial: Run) -> float:
    """Let the gateway stand still for 1 to 3 s; gives how long it did."""
    began = trial.world.signal(signal.SIGSTOP)
    await asyncio.sleep(trial.chance.uniform(1.0, 3.0))
    return (trial.world.signal(signal.SIGCONT) - began) / 1e9


async def late(trial: Run) -> None:
    """The gateway is late by its own load: a safe roof stays open."""
    await trial.begin()
    since = time.monotonic_ns()
    stood = await _stall(trial)
    if stood > SHORT_S:
        trial.counted["the machine stood longer"] = 1
        return
    await asyncio.sleep(3.0)
    if trial.world.truth() != "open":
        asked = [each["said"] for each in trial.world.lines(since) if each["asked"] == "close"]
        trial.breach(f"a safe roof was closed after a standstill of {stood:.1f} s: {asked}")


async def late_and_rain(trial: Run) -> None:
    """It begins to rain while the gateway is late."""
    await trial.begin()
    trial.world.signal(signal.SIGSTOP)
    try:
        await asyncio.sleep(trial.chance.uniform(0.2, 1.5))
        since = await trial.world.fault_at("weather rain")
        await asyncio.sleep(trial.chance.uniform(0.5, 1.5))
    finally:
        trial.world.signal(signal.SIGCONT)
    await trial.closes(since, SHORT_S + HEARD_S + CLOSE_S)


async def hub_away(trial: Run) -> None:
    """The hub is away: the description's link loss closes, again where the shutter stuck."""
    await trial.begin()
    world = trial.world
    kept = world.notices_file.stat().st_size if world.notices_file.exists() else 0
    sticks = trial.chance.random() < 0.5
    if sticks:
        await world.fault_at("dome stuck")
    since = await world.hub_away()
    if not sticks:
        await trial.closes(since, LINK_LOSS_S + CLOSE_S)
        return
    trial.counted["stuck at first"] = 1
    began = time.monotonic()

    def told() -> bool:
        return world.notices_file.exists() and "NOT CLOSED" in world.notices_file.read_text()[kept:]

    while not told() and time.monotonic() < began + LINK_LOSS_S + TOLD_S:
        await asyncio.sleep(0.1)
    if told():
        trial.told_s.append(time.monotonic() - began)
    else:
        trial.breach("nobody was told by the gateway's own way that it is not closed")
    await trial.closes(await world.fault_at("dome ok"), AGAIN_S + CLOSE_S)


async def two_people(trial: Run) -> None:
    """Bea's open is refused while Ada's close is under way."""
    await trial.begin()
    world = trial.world
    since = time.monotonic_ns()
    close = await world.ask("dome", "close", "Ada")
    await world.until(lambda: world.truth() in ("closing", "closed"), "Ada's close")
    await trial.pause(0.0, 0.9)
    under_way = world.truth() == "closing"
    opened = await world.does("dome", "open", "Bea")
    if under_way and opened != "refused":
        state = await world.ended(close)
        trial.breach(f"Bea's open {opened}, Ada's close {state.phase}")
    if opened == "refused":
        trial.counted["Bea was refused"] = 1
        await trial.closes(since, MOVE_S)
    else:
        trial.counted["Ada's close had ended"] = 1


async def foreign_open(trial: Run) -> None:
    """Somebody opens at the dome itself while it rains."""
    await trial.begin()
    world = trial.world
    await trial.closes(await world.fault_at("weather rain"), HEARD_S + CLOSE_S)
    await trial.pause(0.0, 2.0)
    since = await world.fault_at("dome do open")
    await world.until(lambda: world.truth() != "closed", "it opens")
    await trial.closes(since, HEARD_S + CLOSE_S, turn_s=HEARD_S + 0.5)


async def foreign_stop(trial: Run) -> None:
    """Somebody stops the closing roof at the dome itself."""
    await trial.begin()
    world = trial.world
    since = await world.fault_at("weather rain")
    await world.until(lambda: world.truth() == "closing", "it closes")
    for _ in range(trial.chance.randint(1, 2)):
        await trial.pause(0.0, 0.7)
        await world.fault_at("dome do stop")
    await trial.closes(since, HEARD_S + CLOSE_S + 2 * MOVE_S)


async def person_stops(trial: Run) -> None:
    """A person stops the closing in the rain: an alarm, until a person resumes it."""
    await trial.begin()
    world = trial.world
    await world.fault_at("weather rain")
    await world.until(lambda: world.truth() in ("closing", "closed"), "it closes")
    await trial.pause(0.0, 0.6)
    if world.truth() == "closed":
        trial.counted["had closed already"] = 1
        return
    wall = time.time_ns()
    await world.does("dome", "stop", "Bea")
    if world.truth() != "closed":
        await trial.told(wall, 5.0, "enclosure_not_closed")
        since = time.monotonic_ns()
        await world.ask("dome", "close", "Ada")
        # Ada's own close and the gateway's, which goes on at once.
        await trial.closes(since, HEARD_S + CLOSE_S, rated=False)


async def starts_in_rain(trial: Run) -> None:
    """The gateway is killed, and another starts while it rains and the roof is open."""
    await trial.begin()
    world = trial.world
    assert world.gateway is not None
    world.gateway.kill()
    await world.fault_at("weather rain")
    since = time.monotonic_ns()
    await world.gateway_up()
    await trial.closes(since, START_S + HEARD_S + CLOSE_S)
    phase = await world.does("dome", "open", "Bea")
    if phase != "refused":
        trial.breach(f"an open in the rain after a restart {phase}")


async def sun_up(trial: Run) -> None:
    """A gateway starts where it is day, and finds the roof open."""
    world = trial.world
    await world.opened(tracking=False)
    assert world.gateway is not None
    world.gateway.end()
    file = world.folder / "by-day.yaml"
    file.write_text(dump_site(at_day(load_site((world.folder / "site.yaml").read_text()))))
    since = time.monotonic_ns()
    wall = time.time_ns()
    gateway = await world.gateway_up(file, world.folder / f"by-day-{since}")
    try:
        await trial.closes(since, START_S + HEARD_S + CLOSE_S)
        await trial.told(wall, START_S + HEARD_S + CLOSE_S, "enclosure_closes")
    finally:
        gateway.end()


def at_day(site: Site) -> Site:
    """Move a site's place to where it is noon."""
    assert site.place is not None
    noon = (longitude_of_night(time.time()) + 360.0) % 360.0 - 180.0
    return msgspec.structs.replace(
        site, place=msgspec.structs.replace(site.place, longitude=noon), zone="UTC"
    )


async def override_ends(trial: Run) -> None:
    """Wind is overridden for some seconds, and the roof opened; then the override is over."""
    await trial.begin()
    world = trial.world
    await trial.closes(await world.fault_at("weather set wind 60"), HEARD_S + LASTING_S + CLOSE_S)
    seconds = trial.chance.uniform(4.0, 6.0)
    wall = time.time_ns()
    asked = time.monotonic_ns()
    await world.override("weather", seconds)
    await world.until(lambda: world.overridden("weather"), "the override")
    await world.opened(tracking=False)
    since = asked + round(seconds * 1e9)
    while time.monotonic_ns() < since:
        await asyncio.sleep(0.05)
    await trial.closes(since, HEARD_S + CLOSE_S)
    await trial.told(wall, seconds + 5.0, "override_ended")


async def rain_not_overridden(trial: Run) -> None:
    """Rain is never overridden, nor is a station that says nothing."""
    await trial.begin()
    world = trial.world
    fault = trial.chance.choice(["weather rain", "weather hang"])
    limit = HEARD_S + CLOSE_S + (MAX_AGE_S if fault == "weather hang" else 0)
    since = await world.fault_at(fault)
    await world.until(lambda: "rain" in world.locked(), "rain locks")
    wall = time.time_ns()
    await world.override("rain", 60)
    await trial.told(wall, 5.0, "override_refused")
    phase = await world.does("dome", "open", "Bea")
    if phase != "refused":
        trial.breach(f"an open in bad weather {phase}")
    await trial.closes(since, limit)


async def power_cut(trial: Run) -> None:
    """A person asks for the dome's outlet to be switched off: refused while it is open."""
    await trial.begin()
    world = trial.world
    phase = await world.does("power", "outlet1", "Bea", active=False)
    if phase != "refused":
        trial.breach(f"the dome's outlet was switched off while it is open: {phase}")
    await trial.closes(await world.fault_at("weather rain"), HEARD_S + CLOSE_S)


ROS = ("ROS 2", "ROS 1")
_STATION = HEARD_S + CLOSE_S
ROWS = (
    Row("rain", "Rain", weather("weather rain", _STATION), _STATION, short=True),
    Row("wind", "Wind over its limit", weather("weather wind", _STATION + LASTING_S),
        _STATION + LASTING_S),
    Row("humid", "Humidity over its limit", weather("weather humid", _STATION + LASTING_S),
        _STATION + LASTING_S),
    Row("clouds", "Clouds over their limit", weather("weather clouds", _STATION + LASTING_S),
        _STATION + LASTING_S),
    Row("silent", "The station falls silent", weather("weather hang", _STATION + MAX_AGE_S),
        _STATION + MAX_AGE_S),
    Row("wind-code", "Error code: wind −999", weather("weather set wind -999", _STATION), _STATION),
    Row("humidity-code", "Error code: humidity −40 %",
        weather("weather set humidity -40", _STATION), _STATION),
    Row("clouds-code", "Error code: clouds −998", weather("weather set clouds -998", _STATION),
        _STATION),
    Row("nan", "Wind is not a number", weather("weather set wind nan", _STATION + MAX_AGE_S),
        _STATION + MAX_AGE_S),
    Row("infinity", "Wind is infinite", weather("weather set wind inf", _STATION + MAX_AGE_S),
        _STATION + MAX_AGE_S),
    Row("minus-infinity", "Temperature is minus infinity",
        weather("weather set temperature -inf", _STATION + MAX_AGE_S), _STATION + MAX_AGE_S),
    Row("frozen-values", "Values frozen bit for bit",
        weather("weather freeze", _STATION + FROZEN_S), _STATION + FROZEN_S),
    Row("old-stamps", "Old stamps that go on arriving",
        weather("weather old stamps", _STATION + MAX_AGE_S), _STATION + MAX_AGE_S, short=True),
    Row("alternating", "Good and bad values by turns", alternating, ALTERNATING_S),
    Row("lying-closed", "A closed switch that lies: closed",
        obstacle("dome lying closed", ends="dome ok"), AGAIN_S + CLOSE_S, obstacle=True),
    Row("lying-opened", "A switch that lies: open", lying_open, _STATION),
    Row("shutter-stuck", "The shutter is stuck", obstacle("dome stuck", ends="dome ok"),
        AGAIN_S + CLOSE_S, obstacle=True),
    Row("dome-hung", "The dome's server hangs", obstacle("dome hang", ends="dome ok", rated=False),
        AGAIN_S + CLOSE_S, obstacle=True),
    Row("outlet-off", "The dome's outlet is off",
        obstacle("pdu do outlet1 off", ends="pdu do outlet1 on"), AGAIN_S + CLOSE_S, obstacle=True,
        protocols=ROS),
    Row("outlet-asked", "A person asks for the dome's outlet to be off while it is open", power_cut,
        _STATION, protocols=ROS),
    Row("local", "The switch on site is on local", obstacle("dome local", ends="dome ok"),
        AGAIN_S + CLOSE_S, obstacle=True),
    Row("rain-while-opening", "Rain while it opens", rain_while_opening, _STATION),
    Row("mount-stuck", "The telescope does not park", mount_stuck, _STATION),
    Row("disk-full", "The gateway's disk is full, and it rains", disk("full"), _STATION),
    Row("disk-read-only", "The gateway's disk is read-only, and it rains", disk("read-only"),
        _STATION, short=True),
    Row("disk-failing", "The gateway's disk fails, and it rains", disk("failing"), _STATION),
    Row("killed", "The gateway is killed, then it rains", killed, DEAD_S),
    Row("frozen", "The gateway stands still, then it rains", frozen, DEAD_S),
    Row("late", "The gateway is late by 1 to 3 s: a safe roof stays open", late, 0.0),
    Row("late-and-rain", "It begins to rain while the gateway is late", late_and_rain,
        SHORT_S + _STATION),
    Row("driver-crashed", "The INDI driver is killed and comes back, and it rains", driver_crashed,
        RECONNECT_S + _STATION, short=True, protocols=("INDI",)),
    Row("hub-away", "The hub is away", hub_away, LINK_LOSS_S + CLOSE_S),
    Row("two-people", "Bea opens while Ada's close is under way", two_people, MOVE_S),
    Row("foreign-open", "Opened at the dome itself while it rains", foreign_open, _STATION,
        short=True),
    Row("foreign-stop", "Stopped at the dome itself while it closes", foreign_stop,
        _STATION + 2 * MOVE_S),
    Row("person-stops", "A person stops the closing in the rain, and another resumes it",
        person_stops, _STATION),
    Row("starts-in-rain", "A gateway starts in the rain with the roof open", starts_in_rain,
        START_S + _STATION),
    Row("sun-up", "A gateway starts by day with the roof open", sun_up, START_S + _STATION),
    Row("override-ends", "An override of wind ends with the roof open", override_ends, _STATION),
    Row("no-override", "Rain and silence are not overridden", rain_not_overridden,
        _STATION + MAX_AGE_S),
)  # fmt: skip


async def run_trial(world: World, row: Row, seed: int, protocol: str) -> Run:
    """Do a row once, from a settled world."""
    # The same for each protocol, and another for each row.
    run = Run(world, random.Random(f"{row.name}:{seed}"), protocol)  # noqa: S311
    await world.settle()
    await row.run(run)
    return run
