"""Focuser, filter wheel, pointing and the sky between the stars."""

from __future__ import annotations

import math

import numpy as np
import pytest

from talaia.model.units.astronomy import (
    J2000,
    Horizontal,
    angular_separation,
    julian_day,
    precess_coordinates,
)
from talaia.sim.observatory.models.filter_wheel import FilterWheel
from talaia.sim.observatory.models.focuser import PLAY, Focuser
from talaia.sim.observatory.models.optics import best_focus, blur_profile, flat_field
from talaia.sim.observatory.models.sky_brightness import (
    Moonlight,
    moon_position,
    moonlight,
    sky_magnitude,
)
from talaia.sim.observatory.models.telescope import Telescope
from talaia.sim.observatory.servers.devices import MONTSEC

NIGHT = 1_795_302_000.0  # 2026-11-21 23:00 UTC
DOWN = Moonlight(Horizontal(-30.0, 0.0), 60.0)


def settled(focuser: Focuser) -> Focuser:
    while focuser.moving:
        focuser.step(0.1)
    return focuser


def test_the_mirror_lags_behind_the_motor_by_the_play_after_a_turn() -> None:
    focuser = Focuser()
    focuser.goto(26000)
    assert settled(focuser).mirror == 26000 - PLAY
    focuser.goto(25900)
    assert settled(focuser).mirror == 25900
    focuser.move_by(10)
    assert settled(focuser).mirror == 25900
    assert "expected 0 to" in focuser.goto(-1).message


def test_a_stuck_focuser_never_ends_until_it_is_stopped() -> None:
    focuser = Focuser()
    focuser.stuck = True
    ticket = focuser.goto(20000)
    focuser.step(1000)
    assert not ticket.ended
    focuser.stop()
    assert (ticket.good, focuser.position) == (False, 25000)


def test_a_cold_tube_and_a_thick_filter_ask_for_another_focus() -> None:
    focuser = Focuser()
    focuser.feel_air(12.0)
    focuser.feel_air(2.0)
    for _ in range(3600):
        focuser.step(1.0)
    assert focuser.celsius == pytest.approx(2.2, abs=0.1)
    assert best_focus(2.0) - best_focus(12.0) == 180
    assert best_focus(10.0, "Ha") - best_focus(10.0, "L") == 45


def test_the_wheel_turns_the_shorter_way_and_says_no_filter_meanwhile() -> None:
    wheel = FilterWheel()
    ticket = wheel.select("Ha")
    assert (wheel.position, wheel.name) == (0, "")
    wheel.step(1.6)
    assert (ticket.message, wheel.name) == ("the filter is Ha", "Ha")
    assert "expected one of L, R, G, B, Ha" in wheel.select("U").message
    assert "expected 1 to 5" in wheel.goto(6).message


def test_a_star_out_of_focus_is_a_ring_of_the_same_light() -> None:
    for defocus in (0.0, 8.0):
        profile, reach = blur_profile(3.0, defocus)
        far = np.arange(len(profile)) / 4.0
        light = (profile * 2 * math.pi * far * 0.25)[far <= reach].sum()
        assert light == pytest.approx(1.0, abs=0.05)
    assert np.argmax(profile) > 4
    focused = blur_profile(3.0, 0.0)[0]
    half = np.interp(-focused[0] / 2, -focused, np.arange(len(focused)) / 4.0)
    assert half * 2 == pytest.approx(3.0, abs=0.1)


def test_a_flat_field_is_the_same_again_and_another_for_another_filter() -> None:
    one = flat_field(200, 100, "R").copy()
    flat_field.cache_clear()
    assert (flat_field(200, 100, "R") == one).all()
    assert not np.allclose(flat_field(200, 100, "B"), one)
    assert 0.8 < one.min() < one.max() < 1.05


def tracking() -> tuple[Telescope, float]:
    telescope = Telescope(MONTSEC, NIGHT)
    telescope.unpark()
    telescope.goto(2.5, 60)
    for second in range(120):
        telescope.step(1.0, NIGHT + second)
    assert telescope.state == "tracking"
    return telescope, NIGHT + 120


def off(telescope: Telescope, place: tuple[float, float]) -> tuple[float, float]:
    axis = telescope.axis
    east = (axis[0] - place[0]) * 54000 * math.cos(math.radians(place[1]))
    return east, (axis[1] - place[1]) * 3600


def test_a_mount_points_minutes_of_arc_away_until_it_is_synced() -> None:
    telescope, _ = tracking()
    assert math.hypot(*off(telescope, (2.5, 60))) > 150
    axis = telescope.axis
    assert telescope.sync(*axis).good
    assert telescope.radec == (pytest.approx(axis[0]), pytest.approx(axis[1]))
    assert math.hypot(*off(telescope, telescope.radec)) < 0.1
    assert "more than 5" in telescope.sync(3.5, 60).message


def test_stars_drift_while_it_tracks_and_a_nudge_moves_it_back() -> None:
    telescope, unix = tracking()
    before = off(telescope, (2.5, 60))
    for second in range(300):
        telescope.step(1.0, unix + second)
    after = off(telescope, (2.5, 60))
    assert 2.0 < math.dist(before, after) < 9.0
    assert telescope.guide(before[0] - after[0], before[1] - after[1]).good
    assert off(telescope, (2.5, 60)) == (
        pytest.approx(before[0], abs=0.05),
        pytest.approx(before[1], abs=0.05),
    )
    assert "60 arc seconds" in telescope.guide(61, 0).message


def test_the_moon_stands_where_astropy_has_it() -> None:
    coordinates = pytest.importorskip("astropy.coordinates")
    from astropy.time import Time
    from astropy.utils import iers

    # No table of the Earth's turning is needed here, and none may be fetched.
    with iers.conf.set_temp("auto_download", value=False), iers.conf.set_temp("auto_max_age", None):
        for unix in (NIGHT, NIGHT + 9e6, NIGHT + 2e7):
            time = Time(unix, format="unix")
            judge = coordinates.get_body("moon", time)
            ra, dec = precess_coordinates(*moon_position(julian_day(unix)), julian_day(unix), J2000)
            at = Horizontal(judge.dec.deg, judge.ra.deg)
            # Seen from the Earth's middle, by a formula of ten terms.
            assert angular_separation(Horizontal(dec, ra * 15), at) < 0.6


def test_moon_twilight_and_clouds_make_the_sky_brighter() -> None:
    zenith = Horizontal(89.0, 0.0)
    dark = sky_magnitude(zenith, -40.0, DOWN, 0.0)
    full = sky_magnitude(zenith, -40.0, Moonlight(Horizontal(50.0, 100.0), 2.0), 0.0)
    half = sky_magnitude(zenith, -40.0, Moonlight(Horizontal(50.0, 100.0), 90.0), 0.0)
    assert dark == pytest.approx(21.5)
    # Krisciunas and Schaefer's table 2 has 3 to 4 magnitudes for a full Moon.
    assert full < half < dark
    assert 2.5 < dark - full < 4.5
    assert sky_magnitude(zenith, -40.0, DOWN, 80.0) < dark
    bright = [sky_magnitude(zenith, alt, DOWN, 0.0) for alt in range(-20, 40)]
    assert bright == sorted(bright, reverse=True)
    assert 0.0 <= moonlight(MONTSEC, NIGHT).phase_angle <= 180.0
