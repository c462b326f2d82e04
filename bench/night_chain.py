"""From a rapid request, and from a release of the roof, to the shutter: the whole chain.

    PYTHONPATH=src:tests .venv/bin/python bench/night_chain.py [--nights 3] [--order parallel]

What is measured is what observes: requests as a hub sends them, the gateway's interlocks, guard,
commands and executor, the planner's answers, and the simulated dome, mount and camera of the
example, on one moved clock (steps of a second, so each figure is up to a second too long). What
takes real time is the planner: its processor time is measured beside it and added. Fields are not
centred here and no star is guided on; what that takes is a camera's exposure, not the chain's.
"""

from __future__ import annotations

import argparse
import random
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace
from system.nights.made_nights import asked, clock_at, dawn_of, site_at
from system.nights.night_world import NightWorld, PlannerHere, live_through

from talaia.gateway.night.planning.planner_answers import PlannerAnswers
from talaia.model.interlocks.enclosure import ClosingOrder
from talaia.model.observing.requests import RequestGroup, Urgency

REQUESTS = 300
NIGHT_S = 3 * 3600.0
# From the end of one measurement to the next (s).
BETWEEN_S = 240.0
# In the morning it does not rain any more: nothing would be dark behind it (the Sun, °).
LATEST_RAIN_SUN = -20.0
# By the design: a rapid request that is visible, and alone, p95.
RAPID_LIMIT_S = 60.0


class Wait(NamedTuple):
    """One wait for the shutter (s).

    Attributes:
        whole: until the shutter was open.
        slew: of that, the telescope was on its way.
        dome: of that, roof or dome moved, and the telescope did not.
        planner: processor time of the planner's answers meanwhile.

    """

    whole: float
    slew: float
    dome: float
    planner: float


class TimedAnswers(PlannerAnswers):
    """Counts the processor time of its answers."""

    spent = 0.0

    def answer_question(self, question):  # noqa: ANN001, ANN201 - as its base has it
        """Answer."""
        before = time.process_time()
        answer = super().answer_question(question)
        TimedAnswers.spent += time.process_time() - before
        return answer


class TimedPlanner(PlannerHere):
    """Answers as the planner's process does."""

    def __init__(self, answered) -> None:  # noqa: ANN001 - as its base has it
        """Know nothing yet."""
        super().__init__(answered)
        self._answers = TimedAnswers()


class ChainNight:
    """One night, in which it becomes urgent, and rains, again and again."""

    def __init__(self, seed: int, folder: Path, order: ClosingOrder) -> None:
        """Throw the dice; ``order`` says whether the telescope may move while the roof opens."""
        self._dice = random.Random(seed)  # noqa: S311 - a seed gives the same night again
        site = site_at(self._dice.uniform(38.0, 50.0))
        if site.place is None:
            raise ValueError("the example has no place")
        self._place = site.place
        roofs = {name: replace(roof, order=order) for name, roof in site.enclosures.items()}
        site = replace(site, enclosures=roofs)
        began = dawn_of(site.place, 1, self._dice.randint(1, 28), sun=-12.0) - NIGHT_S
        self.world = NightWorld(
            site=site, clock=clock_at(began), data=folder, seed=seed, planner=TimedPlanner
        )
        self.rapid: list[Wait] = []
        self.released: list[Wait] = []
        self._revision = 1
        self._groups = [self._request(f"r{number:03d}", began) for number in range(REQUESTS)]

    def _request(self, name: str, began: float) -> RequestGroup:
        dice = self._dice
        return asked(
            name,
            began + dice.uniform(0.0, NIGHT_S),
            self._place,
            frames=dice.randint(2, 12),
            seconds=dice.choice((60.0, 120.0, 240.0)),
            hours_east=dice.uniform(-3.0, 3.0),
            dec=dice.uniform(0.0, 75.0),
            priority=dice.uniform(1.0, 30.0),
        )

    async def live(self, world: NightWorld) -> None:
        """Live through it."""
        world.robot.bring_about("weather", "clear")
        world.start_gateway()
        world.ask(self._groups)
        await world.pass_time(1.0)
        world.arm()
        await world.until(lambda: exposes(world), 1800.0, "the first frame")
        number = 0
        while world.sun < -14.0:
            number += 1
            await world.pass_time(BETWEEN_S * self._dice.uniform(0.5, 1.5))
            # A release late in the night comes when nothing may be observed any more.
            if number % 3 or world.sun > LATEST_RAIN_SUN:
                await world.until(lambda: exposes(world), 1800.0, "a frame")
                await self._measure_rapid(world, f"rapid{number:02d}")
            else:
                await self._measure_release(world)

    async def _measure_rapid(self, world: NightWorld, name: str) -> None:
        urgent = asked(
            name,
            world.unix,
            self._place,
            frames=1,
            seconds=10.0,
            hours_east=self._dice.uniform(-2.5, 2.5),
            dec=self._dice.uniform(15.0, 70.0),
            urgency=Urgency.RAPID_RESPONSE,
            priority=30.0,
        )
        self._revision += 1
        self._groups = [group for group in self._groups if not group.id.startswith("g-rapid")]
        self._groups.append(urgent)
        begins = len(world.truths)
        spent = TimedAnswers.spent
        world.ask(self._groups, self._revision)
        await world.until(
            lambda: exposes(world) and world.hub.states[-1].request == name, 900.0, name
        )
        self.rapid.append(wait_since(world, begins, TimedAnswers.spent - spent))

    async def _measure_release(self, world: NightWorld) -> None:
        world.robot.bring_about("weather", "rain")
        await world.until(lambda: world.truths[-1].roof == "closed", 120.0, "closed")
        await world.pass_time(self._dice.uniform(30.0, 300.0))
        world.robot.bring_about("weather", "clear")
        night = world.site.night
        if night is None or world.gateway is None:
            raise ValueError("there is no night")
        judged = world.gateway.actuation.interlocks
        device, _, command = night.open.command.partition("/")

        def may_open() -> bool:
            now = world.clock.monotonic_ns()
            refused = judged.refusal_reason(device, command, now)
            return not judged.closing_reason(night.enclosure) and not refused

        await world.until(may_open, 600.0, "a release")
        begins, spent = len(world.truths), TimedAnswers.spent
        await world.until(lambda: exposes(world), 900.0, "a frame behind the rain")
        self.released.append(wait_since(world, begins, TimedAnswers.spent - spent))


def exposes(world: NightWorld) -> bool:
    """Tell whether the shutter is open under an open roof."""
    last = world.truths[-1] if world.truths else None
    return last is not None and last.camera == "exposing" and last.roof == "open"


def wait_since(world: NightWorld, begins: int, planner: float) -> Wait:
    """Say how long it was since a step, and what moved."""
    steps = world.truths[begins:]
    slew = sum(one.telescope in {"slewing", "parking"} for one in steps)
    moving = sum(
        one.telescope not in {"slewing", "parking"} and one.roof in {"opening", "closing"}
        for one in steps
    )
    return Wait(float(len(steps)), float(slew), float(moving), planner)


def print_waits(name: str, waits: list[Wait], limit: str) -> None:
    """Print a line of the table."""
    rows = np.array(waits)
    whole = rows[:, 0] + rows[:, 3]
    half, most = np.percentile(whole, [50, 95])
    beyond = np.percentile(rows[:, 0] + rows[:, 3] - rows[:, 1] - rows[:, 2], [50, 95])
    unmoved = np.percentile(whole - rows[:, 1], [50, 95])
    print(
        f"{name}: {len(rows)} times: p50 {half:.1f} s, p95 {most:.1f} s, most {whole.max():.1f} s"
        f" (limit: {limit});"
        f" without the slew p50 {unmoved[0]:.1f} s, p95 {unmoved[1]:.1f} s;"
        f" slewing {np.median(rows[:, 1]):.0f} s, roof moving {np.median(rows[:, 2]):.0f} s,"
        f" beyond both p50 {beyond[0]:.1f} s, p95 {beyond[1]:.1f} s;"
        f" planner {np.median(rows[:, 3]):.2f} s, at most {rows[:, 3].max():.2f} s"
    )


def main() -> int:
    """Live through some nights; 1 when rapid requests wait longer than they may."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nights", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--order", type=ClosingOrder, choices=list(ClosingOrder), default=ClosingOrder.MOUNT_FIRST
    )
    options = parser.parse_args()
    rapid: list[Wait] = []
    released: list[Wait] = []
    for seed in range(options.seed, options.seed + options.nights):
        with tempfile.TemporaryDirectory() as folder:
            night = ChainNight(seed, Path(folder), options.order)
            live_through(lambda night=night: night.world, night.live)  # type: ignore[misc]
        rapid += night.rapid
        released += night.released
    # Each comes when the one before it is long done: none waits for another rapid one.
    print_waits("rapid request, alone -> shutter", rapid, f"p95 {RAPID_LIMIT_S:g} s")
    print_waits("release -> shutter", released, "roof, unpark, settle, slew + 1 s")
    worst = float(np.percentile([one.whole + one.planner for one in rapid], 95))
    return 1 if worst > RAPID_LIMIT_S else 0


if __name__ == "__main__":
    raise SystemExit(main())
