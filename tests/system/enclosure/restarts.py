"""Rows in which the gateway dies, stands still, or starts."""

from __future__ import annotations

import shutil
import signal
import time
from collections.abc import Awaitable, Callable

import msgspec
from patience import lasts_for

from talaia.model.interlocks.enclosure import ClosingOrder
from talaia.model.site import Site
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.sim.observatory.night import longitude_of_night

from .description import MOVE_S
from .trial import CLOSE_S, HEARD_S, SHORT_S, START_S, Run, dead_s


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
        await lasts_for(2.0)


async def _stall(trial: Run) -> float:
    """Let the gateway stand still for 1 to 3 s; gives how long it did."""
    began = trial.world.signal(signal.SIGSTOP)
    await lasts_for(trial.chance.uniform(1.0, 3.0))
    return (trial.world.signal(signal.SIGCONT) - began) / 1e9


async def late(trial: Run) -> None:
    """The gateway is late by its own load: a safe roof stays open."""
    await trial.begin()
    since = time.monotonic_ns()
    stood = await _stall(trial)
    if stood > SHORT_S:
        trial.counted["the machine stood longer"] = 1
        return
    await lasts_for(3.0)
    if trial.world.truth() != "open":
        asked = [each["said"] for each in trial.world.lines(since) if each["asked"] == "close"]
        trial.breach(f"a safe roof was closed after a standstill of {stood:.1f} s: {asked}")


async def late_and_rain(trial: Run) -> None:
    """It begins to rain while the gateway is late."""
    await trial.begin()
    trial.world.signal(signal.SIGSTOP)
    try:
        await lasts_for(trial.chance.uniform(0.2, 1.5))
        since = await trial.world.fault_at("weather rain")
        await lasts_for(trial.chance.uniform(0.5, 1.5))
    finally:
        trial.world.signal(signal.SIGCONT)
    await trial.closes(since, SHORT_S + HEARD_S + CLOSE_S)


def starts(fault: str, later_s: float = 0.0) -> Callable[[Run], Awaitable[None]]:
    """Make a row in which the gateway is killed, and another starts where the roof must close."""

    async def run(trial: Run) -> None:
        await trial.begin()
        world = trial.world
        assert world.gateway is not None
        world.gateway.kill()
        await world.fault_at(fault)
        since = time.monotonic_ns()
        await world.gateway_up()
        await trial.closes(since, START_S + later_s + HEARD_S + CLOSE_S)
        await trial.refused("dome", "open", "after a restart in bad weather")

    return run


async def starts_in_fair_weather(trial: Run) -> None:
    """A gateway starts where all is well: nothing opens by itself, nor at once by a person."""
    world = trial.world
    await world.does("dome", "close")
    await world.until(lambda: world.truth() == "closed", "the roof is closed")
    await trial.harm_disk()
    assert world.gateway is not None
    world.gateway.kill()
    since = time.monotonic_ns()
    await world.gateway_up()
    phase = await world.does("dome", "open", "Bea")
    if world.locked() and phase == "succeeded":
        trial.breach("a gateway that had just started let a person open")
    if phase != "refused":
        trial.counted["it let go before Bea asked"] = 1
        return
    await world.until(lambda: not world.locked(), "released")
    await lasts_for(2.0)
    moved = [each["said"] for each in world.lines(since) if each["phase"] == "truth"]
    if world.truth() != "closed" or moved:
        trial.breach(f"it opened by itself: {moved}")


async def parallel(trial: Run) -> None:
    """By a description that closes while the telescope parks; which does not."""
    world = trial.world
    site = load_site((world.folder / "site.yaml").read_text())
    dome = msgspec.structs.replace(site.enclosures["dome"], order=ClosingOrder.PARALLEL)
    file = world.folder / "parallel.yaml"
    file.write_text(dump_site(msgspec.structs.replace(site, enclosures={"dome": dome})))
    assert world.gateway is not None
    world.gateway.end()
    gateway = await world.gateway_up(file)
    try:
        await world.until(lambda: not world.locked(), "released")
        await world.opened(tracking=True)
        await trial.harm_disk()
        await world.fault_at("telescope stuck")
        await trial.closes(await world.fault_at("weather rain"), PARALLEL_S)
    finally:
        gateway.end()


PARALLEL_S = HEARD_S + MOVE_S


async def sun_up(trial: Run) -> None:
    """A gateway starts where it is day, and finds the roof open."""
    world = trial.world
    await world.opened(tracking=False)
    assert world.gateway is not None
    world.gateway.end()
    file = world.folder / "by-day.yaml"
    file.write_text(dump_site(at_day(load_site((world.folder / "site.yaml").read_text()))))
    data = world.data / "by-day"
    data.mkdir()
    await trial.harm_disk()
    since = time.monotonic_ns()
    wall = time.time_ns()
    gateway = await world.gateway_up(file, data)
    try:
        await trial.closes(since, START_S + HEARD_S + CLOSE_S)
        await trial.told(wall, START_S + HEARD_S + CLOSE_S, "enclosure_closes")
    finally:
        gateway.end()
        shutil.rmtree(data)


def at_day(site: Site) -> Site:
    """Move a site's place to where it is noon."""
    assert site.place is not None
    noon = (longitude_of_night(time.time()) + 360.0) % 360.0 - 180.0
    return msgspec.structs.replace(
        site, place=msgspec.structs.replace(site.place, longitude=noon), zone="UTC"
    )
