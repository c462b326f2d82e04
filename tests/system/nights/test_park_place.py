"""Where the telescope is parked is read by the gateway, and the planner reckons from there."""

from __future__ import annotations

from pathlib import Path

import pytest

from talaia.gateway.night.planning.planner_question import PlannerQuestion

from .made_nights import asked, clock_at, dawn_of, site_at
from .night_world import NightWorld, PlannerHere, live_through

pytest.importorskip("scipy")


class HearingPlanner(PlannerHere):
    """Keeps what it was asked."""

    heard: list[PlannerQuestion] = []  # noqa: RUF012 - one night at a time

    def ask(self, question: PlannerQuestion) -> None:
        self.heard.append(question)
        super().ask(question)


def test_the_planner_is_told_where_the_parked_telescope_points(tmp_path: Path) -> None:
    site = site_at(48.0)
    assert site.place is not None
    began = dawn_of(site.place, 3, 10, sun=-12.0) - 3 * 3600.0
    place = site.place
    HearingPlanner.heard = []

    async def live(world: NightWorld) -> None:
        world.robot.bring_about("weather", "clear")
        world.start_gateway()
        world.ask([asked("one", began, place)])
        await world.pass_time(1.0)
        world.arm()
        await world.until(lambda: bool(HearingPlanner.heard), 1200.0, "a question")

    live_through(
        lambda: NightWorld(
            site=site, clock=clock_at(began), data=tmp_path, seed=3, planner=HearingPlanner
        ),
        live,
    )
    first = HearingPlanner.heard[0]
    assert first.parked
    # Of the simulated fork: altitude and azimuth.
    assert first.park == pytest.approx((10.0, 10.0), abs=0.1)
