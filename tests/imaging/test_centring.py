"""A target brought into the middle: the simulated mount, its camera and the solver together."""

from __future__ import annotations

import math

import pytest

from talaia.imaging.centring import Centring
from talaia.imaging.plate_solver import PlateHint, solve_plate
from talaia.imaging.star_catalog import stars_near
from talaia.imaging.star_detection import detect_stars
from talaia.imaging.tangent_plane import angular_distance
from talaia.model.units.astronomy import J2000, precess_coordinates
from talaia.sim.observatory.models.sky_picture import Chip, Shot, draw_picture
from talaia.sim.observatory.models.telescope import Telescope
from talaia.sim.observatory.servers.devices import MONTSEC

NIGHT = 1_795_302_000.0  # 2026-11-21 23:00 UTC
CHIP = Chip(turned=25.0)


def track(telescope: Telescope, place: tuple[float, float], unix: float) -> float:
    """Send it to a place (°, J2000) and wait until it tracks."""
    of_date = precess_coordinates(place[0] / 15.0, place[1], J2000, telescope.jd)
    assert telescope.goto(*of_date).good or telescope.state == "slewing"
    for _ in range(90):
        unix += 1.0
        telescope.step(1.0, unix)
    assert telescope.state == "tracking"
    return unix


def real_place(telescope: Telescope) -> tuple[float, float]:
    ra, dec = precess_coordinates(*telescope.axis, telescope.jd, J2000)
    return ra * 15.0, dec


@pytest.mark.parametrize("target", [(40.0, 60.0), (83.8, -5.4)])
def test_a_target_is_centred_to_five_seconds_of_arc(target: tuple[float, float]) -> None:
    telescope = Telescope(MONTSEC, NIGHT)
    telescope.unpark()
    unix = track(telescope, target, NIGHT)
    assert angular_distance(*real_place(telescope), *target) * 3600 > 100
    centring = Centring(*target)
    for tries in range(1, 6):
        ra, dec = real_place(telescope)
        counts = draw_picture(Shot(ra, dec, 5.0, seeing=2.8, seed=tries), CHIP)
        solved = solve_plate(
            detect_stars(counts), counts.shape, PlateHint(*target, CHIP.scale), stars_near
        )
        assert solved.wcs is not None
        step = centring.add_solution(solved.wcs.ra, solved.wcs.dec)
        if step.done:
            break
        unix = track(telescope, (step.ra, step.dec), unix)
    assert step.done
    assert tries <= 3
    assert angular_distance(*real_place(telescope), *target) * 3600 < 5.0


def test_a_mount_that_does_not_follow_is_given_up() -> None:
    centring = Centring(10.0, 20.0, tries=3)
    assert centring.add_solution(10.1, 20.0).problem == ""
    assert centring.add_solution(10.1, 20.0).problem == ""
    assert "still 338 ″ off" in centring.add_solution(10.1, 20.0).problem


def test_a_mount_that_goes_the_wrong_way_is_stopped() -> None:
    centring = Centring(10.0, 20.0)
    centring.add_solution(10.0, 20.05)
    assert "it got worse" in centring.add_solution(10.0, 20.3).problem


def test_right_ascension_goes_on_over_midnight() -> None:
    step = Centring(0.01, 0.0).add_solution(359.99, 0.0)
    assert step.error == pytest.approx(72.0)
    assert math.isclose(step.ra, 0.03, abs_tol=1e-9)
