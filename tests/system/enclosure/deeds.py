"""Rows in which people ask, stop, override, or act at the dome itself."""

from __future__ import annotations

import asyncio
import time

from patience import lasts_for

from .description import LASTING_S, MAX_AGE_S, MOVE_S
from .trial import CLOSE_S, HEARD_S, STATION_S, Run


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


async def override_ends(trial: Run) -> None:
    """Wind is overridden for some seconds, and the roof opened; then the override is over."""
    world = trial.world
    await world.opened(tracking=trial.chance.random() < 0.4)
    await trial.closes(await world.fault_at("weather set wind 60"), HEARD_S + LASTING_S + CLOSE_S)
    seconds = trial.chance.uniform(4.0, 6.0)
    wall = time.time_ns()
    asked = time.monotonic_ns()
    await world.override("weather", seconds)
    await world.until(lambda: world.overridden("weather"), "the override")
    await world.does("dome", "open")
    if world.truth() != "open":
        trial.counted["it was not open in time"] = 1
    await trial.harm_disk()
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
    await trial.refused("dome", "open", "in bad weather")
    await trial.closes(since, limit)


async def between_limits(trial: Run) -> None:
    """Wind falls below the limit that closes, and not below the one that lets go."""
    await trial.begin()
    world = trial.world
    since = await world.fault_at("weather set wind 60")
    await trial.closes(since, STATION_S + LASTING_S)
    for _ in range(3):
        await world.fault_at(f"weather set wind {trial.chance.uniform(35.5, 44.5):.1f}")
        # Longer than an interlock waits once all is well.
        await trial.pause(1.0, 1.5)
        await trial.refused("dome", "open", "with wind between the limits")
        await trial.refused("telescope", "unpark", "with wind between the limits")
    if world.truth() != "closed":
        trial.breach(f"it is {world.truth()}")


async def closed_already(trial: Run) -> None:
    """In the rain people ask a closed roof to close, and to open what may not be."""
    await trial.begin()
    world = trial.world
    since = await world.fault_at("weather rain")
    await trial.closes(since, STATION_S)
    closed = time.monotonic_ns()
    phase = await world.does("dome", "close", "Ada")
    if phase != "succeeded":
        trial.breach(f"closing what is closed: {phase}")
    await trial.refused("dome", "open", "in the rain")
    await trial.refused("telescope", "unpark", "in the rain")
    await lasts_for(1.0)
    moved = [each["said"] for each in world.lines(closed) if each["phase"] == "truth"]
    if moved:
        trial.breach(f"a closed roof moved: {moved}")


async def power_cut(trial: Run) -> None:
    """A person asks for the dome's outlet to be switched off: refused while it is open."""
    await trial.begin()
    world = trial.world
    # A disk that takes nothing refuses it, too; here it is the interlock's matter.
    phase = await world.does("power", "outlet1", "Bea", active=False)
    if phase != "refused":
        trial.breach(f"the dome's outlet was switched off while it is open: {phase}")
    await trial.closes(await world.fault_at("weather rain"), HEARD_S + CLOSE_S)
