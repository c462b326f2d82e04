"""The rows of the enclosure's table: what is done to a roof, and what must hold.

Long, because the rows are read beside each other, as in the table that they fill.
"""

from __future__ import annotations

import asyncio
import random
import time
from collections.abc import Awaitable, Callable

from .deeds import (
    between_limits,
    closed_already,
    foreign_open,
    foreign_stop,
    override_ends,
    person_stops,
    power_cut,
    rain_not_overridden,
    two_people,
)
from .description import FROZEN_S, LASTING_S, LINK_LOSS_S, MAX_AGE_S, MOVE_S
from .restarts import (
    PARALLEL_S,
    frozen,
    killed,
    late,
    late_and_rain,
    parallel,
    starts,
    starts_in_fair_weather,
    sun_up,
)
from .trial import (
    AGAIN_S,
    ALTERNATING_S,
    CLOSE_S,
    DEAD_S,
    HEARD_S,
    RECONNECT_S,
    SHORT_S,
    START_S,
    STATION_S,
    TOLD_S,
    Row,
    Run,
    disk_of,
)
from .world import World

__all__ = ["ROWS", "Row", "Run", "run_trial"]


def weather(limit_s: float, *faults: str) -> Callable[[Run], Awaitable[None]]:
    """Make a row of a fault of the weather or its station."""

    async def run(trial: Run) -> None:
        await trial.begin()
        for each in faults:
            since = await trial.world.fault_at(each)
        await trial.closes(since, limit_s)

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


def lying_open(fault: str, limit_s: float) -> Callable[[Run], Awaitable[None]]:
    """Make a row of a switch that goes on to say open: closed all the same, and people are told."""

    async def run(trial: Run) -> None:
        await trial.begin()
        await trial.world.fault_at(fault)
        wall = time.time_ns()
        since = await trial.world.fault_at("weather rain")
        await trial.closes(since, limit_s)
        await trial.told(wall, TOLD_S)

    return run


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
    await trial.harm_disk()
    await trial.pause(0.0, 0.9)
    since = await world.fault_at("weather rain")
    await trial.closes(since, HEARD_S + CLOSE_S, turn_s=HEARD_S + 0.5)


def beside(fault: str, limit_s: float) -> Callable[[Run], Awaitable[None]]:
    """Make a row in which telescope or camera do not do what a closing asks of them first."""

    async def run(trial: Run) -> None:
        world = trial.world
        await world.opened(tracking=True)
        await trial.pause()
        await trial.harm_disk()
        await world.fault_at(fault)
        await trial.closes(await world.fault_at("weather rain"), limit_s)

    return run


def disk(trouble: str) -> Callable[[Run], Awaitable[None]]:
    """Make a row of a disk that takes nothing, while it rains."""

    async def run(trial: Run) -> None:
        await trial.begin()
        trial.world.disk(trouble)
        await trial.pause(0.2, 1.5)
        since = await trial.world.fault_at("weather rain")
        await trial.closes(since, HEARD_S + CLOSE_S)

    return run


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


ROS = ("ROS 2", "ROS 1")
# A clamshell closes first, whatever its telescope does.
_SHELLS = HEARD_S + MOVE_S
ROWS: tuple[Row, ...] = (
    Row("rain", "Rain", weather(STATION_S, "weather rain"), STATION_S, short=True),
    Row("wind", "Wind over its limit", weather(STATION_S + LASTING_S, "weather wind"),
        STATION_S + LASTING_S),
    Row("humid", "Humidity over its limit", weather(STATION_S + LASTING_S, "weather humid"),
        STATION_S + LASTING_S),
    Row("clouds", "Clouds over their limit", weather(STATION_S + LASTING_S, "weather clouds"),
        STATION_S + LASTING_S),
    Row("gust", "Gusts over their limit", weather(STATION_S, "weather set gust 90"), STATION_S),
    # With a humidity that says nothing of it.
    Row("dew", "Dew point near the temperature",
        weather(STATION_S, "weather set temperature 11", "weather set dew_point 10"), STATION_S),
    Row("silent", "The station falls silent", weather(STATION_S + MAX_AGE_S, "weather hang"),
        STATION_S + MAX_AGE_S),
    Row("wind-code", "Error code: wind −999", weather(STATION_S, "weather set wind -999"),
        STATION_S),
    Row("humidity-code", "Error code: humidity −40 %",
        weather(STATION_S, "weather set humidity -40"), STATION_S),
    Row("clouds-code", "Error code: clouds −998", weather(STATION_S, "weather set clouds -998"),
        STATION_S),
    Row("nan", "Wind is not a number", weather(STATION_S + MAX_AGE_S, "weather set wind nan"),
        STATION_S + MAX_AGE_S),
    Row("infinity", "Wind is infinite", weather(STATION_S + MAX_AGE_S, "weather set wind inf"),
        STATION_S + MAX_AGE_S),
    Row("minus-infinity", "Temperature is minus infinity",
        weather(STATION_S + MAX_AGE_S, "weather set temperature -inf"), STATION_S + MAX_AGE_S),
    Row("frozen-values", "Values frozen bit for bit",
        weather(STATION_S + FROZEN_S, "weather freeze"), STATION_S + FROZEN_S),
    Row("old-stamps", "Old stamps that go on arriving",
        weather(STATION_S + MAX_AGE_S, "weather old stamps"), STATION_S + MAX_AGE_S, short=True),
    Row("alternating", "Good and bad values by turns", alternating, ALTERNATING_S),
    Row("lying-closed", "A closed switch that lies: closed",
        obstacle("dome lying closed", ends="dome ok"), AGAIN_S + CLOSE_S, obstacle=True),
    Row("lying-opened", "A switch that lies: open", lying_open("dome lying opened", STATION_S),
        STATION_S),
    Row("shutter-stuck", "The shutter is stuck", obstacle("dome stuck", ends="dome ok"),
        AGAIN_S + CLOSE_S, obstacle=True),
    Row("dome-hung", "The dome's server hangs", obstacle("dome hang", ends="dome ok", rated=False),
        AGAIN_S + CLOSE_S, obstacle=True),
    Row("outlet-off", "The dome's outlet is off",
        obstacle("pdu do outlet1 off", ends="pdu do outlet1 on"), AGAIN_S + CLOSE_S, obstacle=True,
        protocols=ROS),
    Row("outlet-asked", "A person asks for the dome's outlet to be off while it is open", power_cut,
        STATION_S, protocols=ROS),
    Row("local", "The switch on site is on local", obstacle("dome local", ends="dome ok"),
        AGAIN_S + CLOSE_S, obstacle=True),
    Row("rain-while-opening", "Rain while it opens", rain_while_opening, STATION_S),
    Row("mount-stuck", "The telescope does not park", beside("telescope stuck", STATION_S),
        STATION_S),
    Row("mount-hung", "The telescope's server hangs", beside("telescope hang", STATION_S),
        STATION_S),
    Row("camera-hung", "The camera does not end its exposure", beside("camera hang", STATION_S),
        STATION_S, protocols=ROS),
    Row("parallel", "Closing beside a telescope that does not park (order parallel)", parallel,
        PARALLEL_S),
    Row("disk-full", "The gateway's disk is full, and it rains", disk("full"), STATION_S,
        disks=False),
    Row("disk-read-only", "The gateway's disk is read-only, and it rains", disk("read-only"),
        STATION_S, short=True, disks=False),
    Row("disk-failing", "The gateway's disk fails, and it rains", disk("failing"), STATION_S,
        disks=False),
    Row("killed", "The gateway is killed, then it rains", killed, DEAD_S),
    Row("frozen", "The gateway stands still, then it rains", frozen, DEAD_S),
    Row("late", "The gateway is late by 1 to 3 s: a safe roof stays open", late, 0.0),
    Row("late-and-rain", "It begins to rain while the gateway is late", late_and_rain,
        SHORT_S + STATION_S),
    Row("driver-crashed", "The INDI driver is killed and comes back, and it rains", driver_crashed,
        RECONNECT_S + STATION_S, short=True, protocols=("INDI",)),
    Row("hub-away", "The hub is away", hub_away, LINK_LOSS_S + CLOSE_S),
    Row("two-people", "Bea opens while Ada's close is under way", two_people, MOVE_S),
    Row("foreign-open", "Opened at the dome itself while it rains", foreign_open, STATION_S,
        short=True),
    Row("foreign-stop", "Stopped at the dome itself while it closes", foreign_stop,
        STATION_S + 2 * MOVE_S),
    Row("person-stops", "A person stops the closing in the rain, and another resumes it",
        person_stops, STATION_S),
    Row("between-limits", "Wind between its two limits: nobody opens", between_limits,
        STATION_S + LASTING_S),
    Row("closed-already", "A closed roof is asked to close, and to open in the rain",
        closed_already, STATION_S),
    Row("starts-in-rain", "A gateway starts in the rain with the roof open",
        starts("weather rain"), START_S + STATION_S),
    Row("starts-blind", "A gateway starts beside a silent station with the roof open",
        starts("weather hang", MAX_AGE_S), START_S + MAX_AGE_S + STATION_S),
    Row("starts-fair", "A gateway starts in fair weather: nothing opens, nor at once by a person",
        starts_in_fair_weather, 0.0),
    Row("sun-up", "A gateway starts by day with the roof open", sun_up, START_S + STATION_S),
    Row("override-ends", "An override of wind ends with the roof open", override_ends, STATION_S),
    Row("no-override", "Rain and silence are not overridden", rain_not_overridden,
        STATION_S + MAX_AGE_S),
)  # fmt: skip
# INDI's trial driver has no parts.
_CLAMSHELLS = (
    Row("shells-rain", "Clamshell: rain", weather(_SHELLS, "weather rain"), _SHELLS),
    Row("shells-silent", "Clamshell: the station falls silent",
        weather(_SHELLS + MAX_AGE_S, "weather hang"), _SHELLS + MAX_AGE_S),
    Row("shells-mount", "Clamshell: the telescope does not park, and is not waited for",
        beside("telescope stuck", _SHELLS), _SHELLS),
    Row("shell-stuck", "Clamshell: one shell is stuck",
        obstacle("dome west stuck", ends="dome ok"), AGAIN_S + MOVE_S, obstacle=True),
    Row("shell-lying-closed", "Clamshell: one shell's end switch lies: closed",
        obstacle("dome east lying closed", ends="dome ok"), AGAIN_S + MOVE_S, obstacle=True),
    Row("shell-lying-opened", "Clamshell: one shell's end switch lies: open",
        lying_open("dome west lying opened", _SHELLS), _SHELLS),
    Row("shells-opening", "Clamshell: rain while it opens", rain_while_opening, _SHELLS),
    Row("shells-killed", "Clamshell: the gateway is killed, then it rains", killed, DEAD_S),
)  # fmt: skip
ROWS += tuple(each._replace(roof="clamshell", protocols=ROS) for each in _CLAMSHELLS)


async def run_trial(world: World, row: Row, seed: int, protocol: str) -> Run:
    """Do a row once, from a settled world."""
    # The same for each protocol, and another for each row.
    chance = random.Random(f"{row.name}:{seed}")  # noqa: S311
    run = Run(world, chance, protocol, disk_of(row, seed))
    await world.settle()
    await row.run(run)
    return run
