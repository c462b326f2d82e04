"""Seeded nights: weather, faults and people, each at its moment. A seed gives the same night."""

from __future__ import annotations

import math
import random
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import NamedTuple

from talaia.gateway.night.imaging.star_parts import PartOutcome
from talaia.model.interlocks.enclosure import Place
from talaia.model.observing.requests import RequestGroup, Urgency

from .judge import judge_night
from .made_nights import asked, clock_at, dawn_of, dusk_of, site_at, some_requests
from .night_world import NightWorld, live_through

FAULTS = (
    "stuck dome",
    "lost guide star",
    "camera time-out",
    "power cut",
    "dead gateway",
    "full disk",
    "hub away all night",
    "person commands",
    "person closes",
    "hands on site",
    "silent weather",
    "dead planner",
    "rapid request",
)
# What begins something, and what ends it.
Deed = Callable[[], Awaitable[None] | None]
Deeds = tuple[Deed, Deed | None]
RAIN_S = (120.0, 900.0)
# What hands at the dome did is theirs for so long while a gateway looks after it (s).
HAND_S = 15.0


class Trial(NamedTuple):
    """How a night went.

    Attributes:
        faults: what happened in it.
        wrong: what was not as it has to be.
        night_s: how long it was.
        took_s: how long it took here.
        completed: requests that were completed, of all.
        frames: of the sky, read out.

    """

    seed: int
    faults: tuple[str, ...]
    wrong: tuple[str, ...]
    night_s: float
    took_s: float
    completed: int
    requests: int
    frames: int


class SeededGuider:
    """A guider whose star is lost from time to time."""

    present = True

    def __init__(self) -> None:
        """Hold nothing."""
        self.clouded = self._guides = False

    async def begin_guiding(self) -> PartOutcome:
        self._guides = not self.clouded
        return PartOutcome(good=self._guides, message="" if self._guides else "no star is found")

    async def dither_star(self, arcseconds: float) -> PartOutcome:
        return PartOutcome(good=not self.clouded, message="the star is lost" * self.clouded)

    async def end_guiding(self) -> PartOutcome:
        self._guides = False
        return PartOutcome(good=True)

    def lost_reason(self) -> str:
        return "the guide star is lost" if self._guides and self.clouded else ""


class SeededNight:
    """One night: its world, and what is to happen in it."""

    def __init__(
        self, seed: int, data: Path, *, hours: float | None, faults: tuple[str, ...] = ()
    ) -> None:
        """Throw the dice; ``hours``: before it is too bright to observe; none: from dusk on."""
        self._dice = dice = random.Random(seed)
        self.seed = seed
        self._site = site_at(dice.uniform(38.0, 50.0))
        place = self._site.place
        assert place is not None
        self._place: Place = place
        month, day = dice.randint(1, 12), dice.randint(1, 28)
        dawn = dawn_of(place, month, day, sun=-12.0)
        # Armed while it is still too bright to open.
        dusk = dusk_of(place, month, day, sun=-5.0) if hours is None else dawn - hours * 3600.0
        self._began, self._hours = dusk, (dawn - dusk) / 3600.0
        self.guider = SeededGuider()
        # Each seed has its own fault for certain, and others by chance.
        more = dice.randint(1, 2) if hours is not None else dice.randint(2, 4)
        self.faults = faults or (FAULTS[seed % len(FAULTS)], *dice.sample(FAULTS, more))
        # When somebody at the dome moved it (s, monotonic).
        self.by_hand: list[tuple[float, float]] = []
        self.world = NightWorld(
            site=self._site, clock=clock_at(self._began), data=data, seed=seed, guider=self.guider
        )
        self.asked: list[str] = []
        self.groups: list[RequestGroup] = []

    def _moment(self) -> float:
        return self._dice.uniform(0.05, 0.8) * self._hours * 3600.0

    def _plan_faults(self) -> None:
        for name in dict.fromkeys(self.faults):
            begin, end = DEEDS[name](self)
            at, lasts = self._moment(), self._dice.uniform(20.0, 600.0)
            # It never sees the roof open.
            at = 60.0 if name == "hub away all night" else at
            self.world.at(at, begin)
            if end is not None:
                self.world.at(at + lasts, end)
        for _ in range(self._dice.randint(0, 2 + int(self._hours / 4.0))):
            at = self._moment()
            words = self._dice.choice(("rain", "wind", "humid", "clouds"))
            self.world.at(at, self.line("weather", words))
            self.world.at(at + self._dice.uniform(*RAIN_S), self.line("weather", "clear"))

    def restart_gateway(self) -> None:
        """Have somebody look after the roof again, whatever hands did to it meanwhile."""
        self.world.start_gateway()
        now = self.world.truths[-1].at
        self.by_hand = [(since, min(until, now + HAND_S)) for since, until in self.by_hand]

    def ask_rapid(self) -> None:
        """Have something become urgent, if there is anybody to hear of it."""
        if self.world.gateway is None or not self.world.hub.there:
            return
        urgent = asked(
            f"rapid{len(self.groups):02d}",
            self.world.unix,
            self._place,
            frames=2,
            seconds=30.0,
            hours_east=self._dice.uniform(-2.0, 2.0),
            dec=self._dice.uniform(15.0, 70.0),
            urgency=Urgency.RAPID_RESPONSE,
            priority=30.0,
        )
        self.groups.append(urgent)
        self.asked.append(urgent.requests[0].id)
        self.world.ask(self.groups, len(self.groups))

    def line(self, device: str, words: str) -> Callable[[], None]:
        return lambda: self.world.robot.bring_about(device, words)

    async def live(self, world: NightWorld) -> None:
        """Live through it, to the morning."""
        world.robot.bring_about("weather", "clear")
        world.start_gateway()
        self.groups = some_requests(self._dice, self._began, self._place, self._hours)
        self.asked = [request.id for group in self.groups for request in group.requests]
        world.ask(self.groups)
        await world.pass_time(self._dice.uniform(1.0, 60.0))
        world.arm()
        self._plan_faults()
        middle = self._began + self._hours * 1800.0
        await world.until(
            lambda: world.sun > -7.5 and world.unix > middle, (self._hours + 3.0) * 3600.0, "dawn"
        )
        # What hinders it is over by then; what has to be safe has a while to become so.
        await self._morning(world)

    async def _morning(self, world: NightWorld) -> None:
        for device in ("dome", "weather", "camera", "telescope"):
            world.robot.bring_about(device, "ok")
        for outlet in (1, 2, 3, 4):
            world.robot.bring_about("pdu", f"do outlet{outlet} on")
        world.robot.bring_about("weather", "clear")
        world.disk_full = False
        if world.gateway is None:
            self.restart_gateway()
        await world.pass_time(300.0)
        world.hub_back()
        await world.pass_time(60.0)


def _deed_of(device: str, words: str, ok: str = "ok") -> Callable[[SeededNight], Deeds]:
    return lambda night: (night.line(device, words), night.line(device, ok))


def _cut_power(night: SeededNight) -> Deeds:
    def switch(state: str) -> Callable[[], None]:
        def act() -> None:
            for outlet in (1, 2, 3, 4):
                night.world.robot.bring_about("pdu", f"do outlet{outlet} {state}")

        return act

    return switch("off"), switch("on")


def _kill(night: SeededNight) -> Deeds:
    async def restart() -> None:
        if night.world.gateway is None:
            night.restart_gateway()

    return night.world.kill_gateway, restart


def _lose_star(night: SeededNight) -> Deeds:
    def cloud(over: bool) -> Callable[[], None]:
        return lambda: setattr(night.guider, "clouded", over)

    return cloud(True), cloud(False)


def _fill_disk(night: SeededNight) -> Deeds:
    def fill(full: bool) -> Callable[[], None]:
        return lambda: setattr(night.world, "disk_full", full)

    return fill(True), fill(False)


def _hub_away(night: SeededNight) -> Deeds:
    return night.world.hub_away, None


def _person(night: SeededNight) -> Deeds:
    def command() -> None:
        address, args = night._dice.choice(
            (
                ("telescope/goto_altaz", {"alt": 60.0, "az": 120.0}),
                ("telescope/stop", {}),
                ("dome/open", {}),
                ("dome/stop", {}),
                ("camera/abort", {}),
                ("camera/expose", {"seconds": 30.0}),
                ("telescope/park", {}),
            )
        )
        night.world.command(address, args)

    return command, command


def _closes(night: SeededNight) -> Deeds:
    return (lambda: night.world.command("dome/close")), None


def _on_site(night: SeededNight) -> Deeds:
    words = night._dice.choice(("do open", "do close", "do stop"))

    def move() -> None:
        now = night.world.truths[-1].at
        # A hand's doing is the hand's until the guard has had its time; a dead one has none.
        alive = night.world.gateway is not None
        night.by_hand.append((now, now + HAND_S if alive else math.inf))
        night.world.robot.bring_about("dome", words)

    return move, move


def _mute_planner(night: SeededNight) -> Deeds:
    def mute(dead: bool) -> Callable[[], None]:
        def act() -> None:
            if night.world.gateway is not None:
                night.world.gateway.service.planner.dead = dead  # type: ignore[attr-defined]

        return act

    return mute(True), mute(False)


def _rapid(night: SeededNight) -> Deeds:
    return night.ask_rapid, night.ask_rapid


DEEDS = {
    "stuck dome": _deed_of("dome", "stuck"),
    "lost guide star": _lose_star,
    "camera time-out": _deed_of("camera", "hang"),
    "power cut": _cut_power,
    "dead gateway": _kill,
    "full disk": _fill_disk,
    "hub away all night": _hub_away,
    "person commands": _person,
    "person closes": _closes,
    "hands on site": _on_site,
    "silent weather": _deed_of("weather", "hang"),
    "dead planner": _mute_planner,
    "rapid request": _rapid,
}


def run_trial(
    seed: int, data: Path, *, hours: float | None = None, faults: tuple[str, ...] = ()
) -> Trial:
    """Live through a seed's night, or the last ``hours`` of it, and judge it."""
    began = time.process_time()
    night = SeededNight(seed, data, hours=hours, faults=faults)
    world = live_through(lambda: night.world, night.live)
    wrong = judge_night(world, night.asked, night.by_hand)
    states = {one.request for one in world.hub.updates.values() if one.state.name == "COMPLETED"}
    length = world.truths[-1].at - world.truths[0].at
    return Trial(
        seed, tuple(dict.fromkeys(night.faults)), tuple(wrong), length,
        time.process_time() - began, len(states), len(night.asked), len(world.robot.lights),
    )  # fmt: skip
