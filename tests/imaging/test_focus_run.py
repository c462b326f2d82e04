"""Focus runs on the simulated telescope, and curves that fail."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from talaia.imaging.focus_fit import FocusPoint, fit_focus
from talaia.imaging.focus_run import FocusRun, FocusSettings
from talaia.imaging.star_detection import detect_stars
from talaia.sim.observatory.models.focuser import Focuser
from talaia.sim.observatory.models.optics import best_focus
from talaia.sim.observatory.models.sky_picture import Chip, Shot, draw_picture


def hyperbola(position: float, best: float = 25_130.0) -> float:
    return math.sqrt(1.5**2 + ((position - best) * 0.02) ** 2)


@given(st.floats(24_900, 25_300), st.floats(0.005, 0.05), st.floats(0.8, 4.0))
@settings(max_examples=40, deadline=None)
def test_the_vertex_of_an_exact_hyperbola_is_found(best: float, slope: float, least: float) -> None:
    at = np.linspace(24_600, 25_600, 9)
    points = [FocusPoint(x, math.hypot(least, slope * (x - best)), 20) for x in at]
    found = fit_focus(points)
    assert found.position == pytest.approx(best, abs=0.5)
    assert found.hfr == pytest.approx(least, abs=0.01)
    assert found.problem == "" or "as large everywhere" in found.problem


@pytest.mark.parametrize(
    ("radii", "said", "side"),
    [
        ([math.nan] * 7, "no stars were seen", 0),
        ([3, 2, math.nan, 2.5, math.nan, math.nan, 3], "stars were seen at 4 positions", -1),
        ([2, 3, 4, 5, 6, 7, 8], "", -1),
        ([2.0, 2.01, 2.0, 2.02, 2.01, 2.03, 2.04], "as large everywhere", None),
        ([4, 2, 4, 2, 4.5, 2, 5], "scatter", None),
        ([2, 3, 3.5, 3.6, 3.5, 3, 2], "do not grow", None),
    ],
)
def test_a_curve_that_is_none_says_why(radii: list[float], said: str, side: int | None) -> None:
    points = [FocusPoint(1000.0 + 50 * i, r, 9 if r == r else 0) for i, r in enumerate(radii)]
    found = fit_focus(points)
    assert found.problem
    assert said in found.problem
    assert side is None or found.side == side


def run_with(focuser: Focuser, run: FocusRun, *, blind: bool = False) -> str:
    """Run it on a simulated telescope; give the problem."""
    for picture in range(40):
        step = run.next_step()
        for position in step.moves:
            focuser.goto(position)
            while focuser.moving:
                focuser.step(0.1)
        if not step.measure:
            return step.problem
        off = focuser.mirror - best_focus(4.0, "R")
        shot = Shot(150.0, 30.0, 4.0, seeing=2.6, defocus=off, clear=0.3, seed=picture)
        found = detect_stars(draw_picture(shot._replace(light=not blind), Chip()))
        run.add_measurement(found.median_hfr, found.total if found.total > 2 else 0)
    return "it never ended"


@pytest.mark.parametrize("start", [25_000, 25_400])
def test_a_run_ends_in_focus_whatever_the_screws_play(start: float) -> None:
    focuser = Focuser()
    run = FocusRun(start)
    assert run_with(focuser, run) == ""
    # Stars grow by a tenth at 25 steps.
    assert focuser.mirror == pytest.approx(best_focus(4.0, "R"), abs=12)
    assert run.fit.quality > 0.9
    assert run.fit.uncertainty < 15
    assert len(run.points) <= 15


def test_a_run_without_stars_goes_back_to_where_it_began() -> None:
    focuser = Focuser()
    assert "no stars were seen" in run_with(focuser, FocusRun(25_000.0), blind=True)
    assert focuser.position == 25_000


def test_a_run_that_finds_no_end_gives_up_and_stays_on_the_way() -> None:
    run = FocusRun(300.0, FocusSettings(lowest=0.0, highest=2000.0))
    visited = []
    for _ in range(60):
        step = run.next_step()
        visited += step.moves
        if not step.measure:
            break
        run.add_measurement(hyperbola(step.moves[-1], -4000.0), 20)
    assert "below the positions" in step.problem
    assert 0 <= min(visited) <= max(visited) <= 2000
