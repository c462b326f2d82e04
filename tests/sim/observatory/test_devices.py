"""The observatory's devices in time that a hand moves."""

from __future__ import annotations

import io
import math
import warnings
from datetime import UTC, datetime

import numpy
import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.model.units import astronomy
from talaia.sim.observatory.models import cctv
from talaia.sim.observatory.models.camera import CcdCamera, Scene
from talaia.sim.observatory.models.enclosure import EnclosureMechanics, SimulatedEnclosure
from talaia.sim.observatory.models.power import Power
from talaia.sim.observatory.models.telescope import Telescope
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.models.weather import Weather, dew_point
from talaia.sim.observatory.servers.devices import MONTSEC
from talaia.sim.observatory.servers.sequencer import GlobalServer

NIGHT = 1_795_302_000.0  # 2026-11-21 23:00 UTC
NOON = NIGHT - 11 * 3600


def pass_time(model: SimulatedEnclosure, seconds: float) -> None:
    for _ in range(round(seconds * 20)):
        model.step(0.05)


def test_a_shutter_takes_its_time_and_says_so_only_at_its_switch() -> None:
    dome = SimulatedEnclosure()
    ticket = dome.open()
    pass_time(dome, 11.5)
    assert (dome.word, dome.opened, ticket.ended) == ("moving", False, False)
    pass_time(dome, 1)
    assert (dome.word, dome.opened, ticket.good) == ("opened", True, True)
    assert dome.open().message == "the dome is opened"


def test_parked_is_not_closed() -> None:
    dome = SimulatedEnclosure()
    dome.open()
    pass_time(dome, 13)
    dome.turn_to(90)
    pass_time(dome, 20)
    dome.park()
    pass_time(dome, 20)
    assert dome.azimuth == 0
    assert dome.word == "opened"


def test_a_flap_closes_before_the_shutter_and_counts_as_open_until_then() -> None:
    dome = SimulatedEnclosure(EnclosureMechanics(has_flap=True))
    dome.open()
    pass_time(dome, 18)
    assert dome.flap == 1
    dome.close()
    pass_time(dome, 3)
    assert (dome.position, dome.closed) == (1.0, False)
    pass_time(dome, 15)
    assert dome.closed


def test_a_stuck_shutter_ends_its_request_with_words_and_moves_not() -> None:
    dome = SimulatedEnclosure()
    dome.open()
    pass_time(dome, 13)
    dome.stuck = True
    ticket = dome.close()
    pass_time(dome, 5)
    assert (ticket.good, ticket.message, dome.state) == (False, "the shutter is stuck", "error")
    assert not dome.closed


def test_a_lost_encoder_is_no_azimuth_and_turning_is_refused() -> None:
    dome = SimulatedEnclosure()
    ticket = dome.turn_to(180)
    pass_time(dome, 1)
    dome.lost = True
    pass_time(dome, 1)
    assert ticket.ended
    assert not ticket.good
    assert math.isnan(dome.shown_azimuth)
    assert "encoder" in dome.turn_to(10).message


def test_a_lying_switch_says_closed_while_the_shutter_is_open() -> None:
    dome = SimulatedEnclosure()
    dome.open()
    pass_time(dome, 13)
    dome.lying = "closed"
    assert dome.closed
    assert dome.close().good
    assert dome.position == 1


def test_local_control_stops_what_moves_and_refuses_what_comes() -> None:
    dome = SimulatedEnclosure()
    dome.open()
    pass_time(dome, 3)
    dome.local = True
    pass_time(dome, 3)
    assert dome.state == "stopped"
    assert "local control" in dome.open().message


@given(
    st.lists(
        st.tuples(st.sampled_from(["open", "close", "stop", "turn", "park"]), st.floats(0, 20))
    )
)
@settings(max_examples=examples(15, many=600))
def test_whatever_is_asked_the_switches_agree_with_the_shutter(
    asked: list[tuple[str, float]],
) -> None:
    dome = SimulatedEnclosure()
    for what, seconds in asked:
        ticket = dome.turn_to(123.0) if what == "turn" else getattr(dome, what)()
        pass_time(dome, seconds)
        assert 0 <= dome.position <= 1
        assert dome.closed == (dome.position == 0)
        assert dome.opened == (dome.position == 1)
        assert ticket.ended or dome.wanted is not None or dome.turning


def scope(unix: float = NIGHT) -> Telescope:
    return Telescope(MONTSEC, unix)


def run(telescope: Telescope, unix: float, seconds: float) -> float:
    for _ in range(round(seconds * 5)):
        unix += 0.2
        telescope.step(0.2, unix)
    return unix


def test_a_parked_telescope_refuses_to_slew() -> None:
    assert "unpark" in scope().goto(2.5, 60).message


def test_a_telescope_that_parks_refuses_to_unpark_and_goes_on() -> None:
    telescope = scope()
    telescope.unpark()
    telescope.goto_altaz(60, 180)
    unix = run(telescope, NIGHT, 30)
    parking = telescope.park()
    answer = telescope.unpark()
    assert (answer.ended, answer.good) == (True, False)
    assert "is parking" in answer.message
    run(telescope, unix, 60)
    assert (parking.good, telescope.state) == (True, "parked")


def test_a_slew_ends_tracking_its_target_within_the_axes_rate() -> None:
    telescope = scope()
    telescope.unpark()
    ticket = telescope.goto(2.5, 60)
    far = max(abs(astronomy.equatorial_to_horizontal(2.5, 60, MONTSEC, telescope.jd).alt - 10), 1)
    unix = run(telescope, NIGHT, far / 5 * 0.5)
    assert not ticket.ended
    unix = run(telescope, unix, 60)
    assert (ticket.good, telescope.state) == (True, "tracking")
    run(telescope, unix, 600)
    ra, dec = telescope.radec
    assert ra == pytest.approx(2.5, abs=1e-4)
    assert dec == pytest.approx(60, abs=1e-3)


@pytest.mark.parametrize(
    ("ra", "dec", "said"),
    [(25, 0, "RA 25 h"), (-1, 0, "RA -1 h"), (1, 91, "Dec 91"), (float("nan"), 0, "RA nan")],
)
def test_what_is_no_place_in_the_sky_is_refused_and_nothing_moves(
    ra: float, dec: float, said: str
) -> None:
    telescope = scope()
    telescope.unpark()
    ticket = telescope.goto(ra, dec)
    assert (ticket.ended, ticket.good) == (True, False)
    assert said in ticket.message
    assert telescope.state == "idle"


def test_it_never_slews_below_its_horizon_limit() -> None:
    telescope = scope()
    telescope.unpark()
    assert "below the limit" in telescope.goto_altaz(14.9, 100).message
    assert telescope.goto_altaz(15.1, 100).message == ""


def test_it_neither_points_at_the_sun_nor_passes_it() -> None:
    telescope = scope(NOON)
    telescope.unpark()
    sun = telescope.sun
    assert sun.alt > 20
    assert "from the Sun" in telescope.goto_altaz(sun.alt, sun.az).message
    telescope.goto_altaz(30, (sun.az - 80) % 360)
    run(telescope, NOON, 60)
    assert "passes the Sun" in telescope.goto_altaz(30, (sun.az + 80) % 360).message


@given(st.floats(15, 90), st.floats(0, 360), st.integers(0, 23))
@settings(max_examples=examples(12, many=400), deadline=None)
def test_no_slew_by_day_comes_near_the_sun(alt: float, az: float, hour: int) -> None:
    unix = NOON + hour * 3600
    telescope = scope(unix)
    telescope.unpark()
    ticket = telescope.goto_altaz(alt, az)
    began_near = astronomy.angular_separation(telescope.at, telescope.sun) < 30
    while not ticket.ended:
        unix += 0.2
        telescope.step(0.2, unix)
        if telescope.sun.alt > -6 and not began_near:
            assert astronomy.angular_separation(telescope.at, telescope.sun) > 28


def test_tracking_ends_at_the_horizon_limit() -> None:
    telescope = scope()
    telescope.unpark()
    telescope.goto_altaz(16, 270)
    unix = run(telescope, NIGHT, 60)
    telescope.set_tracking(on=True)
    run(telescope, unix, 1800)
    assert telescope.state == "idle"
    assert telescope.at.alt >= 15


def test_the_same_seed_gives_the_same_weather_and_rain_can_be_forced() -> None:
    one, other = Weather(7, NIGHT), Weather(7, NIGHT)
    for each in (one, other):
        for minute in range(100):
            each.step(60, NIGHT + minute * 60)
    assert one.weather_info() == other.weather_info()
    assert one.force_weather("rain") == ""
    assert one.rain > 0
    one.lying = True
    one.step(1, NIGHT)
    assert one.rain == 0
    assert "expected one of" in one.force_weather("frogs")


def test_the_dew_point_is_that_of_the_tables() -> None:
    assert dew_point(20, 50) == pytest.approx(9.26, abs=0.05)
    assert dew_point(10, 100) == pytest.approx(10, abs=0.01)


def expose(camera: CcdCamera, seconds: float, unix: float = NIGHT, **more: str) -> Ticket:
    ticket = camera.start_exposure(seconds, **more)
    while not ticket.ended:
        unix += 0.5
        camera.step(0.5, unix)
    return ticket


def test_an_exposure_counts_down_and_gives_a_fits_file_that_astropy_accepts() -> None:
    fits = pytest.importorskip("astropy.io.fits")
    camera = CcdCamera(Scene(MONTSEC, 5.6, -5.39, dome_open=True, weather={"temperature": 4.0}))
    ticket = camera.start_exposure(10, "light", "M 42 'Orion'")
    camera.step(4, NIGHT)
    assert camera.remaining == 6
    for second in range(1, 10):
        camera.step(1, NIGHT + second)
    assert ticket.good
    assert camera.newest is not None
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        opened = fits.open(io.BytesIO(camera.newest.fits))
        opened.verify("exception")
        header, data = opened[0].header, opened[0].data
    assert data.shape == (510, 765)
    assert data.dtype.name == "uint16"
    assert (header["OBJECT"], header["EXPTIME"]) == ("M 42 'Orion'", 10.0)
    assert header["DATE-OBS"].startswith("2026-11-21T22:59:5")
    assert (header["SITELAT"], header["AMBTEMP"]) == (MONTSEC.latitude, 4.0)
    # Where the mount says that it points, and no solution that nobody has made.
    ra, dec = astronomy.precess_coordinates(
        5.6, -5.39, astronomy.julian_day(NIGHT), astronomy.J2000
    )
    assert (header["RA"], header["DEC"]) == (pytest.approx(ra * 15, abs=1e-3), pytest.approx(dec))
    assert "CRVAL1" not in header


def counts_of(scene: Scene, seconds: float = 30, **more: str) -> numpy.ndarray:
    camera = CcdCamera(scene)
    camera.celsius = camera.setpoint = -20
    camera.cooling = True
    expose(camera, seconds, **more)
    assert camera.newest is not None
    return camera.newest.counts.astype(float)


def test_two_pictures_of_one_field_show_the_same_stars_and_a_closed_dome_shows_none() -> None:
    pictures = [counts_of(Scene(MONTSEC, 2.0, 50.0, dome_open=opened)) for opened in (1, 1, 0)]
    bright = [set(numpy.argsort(picture, axis=None)[-20:].tolist()) for picture in pictures]
    assert len(bright[0] & bright[1]) > 12
    assert len(bright[0] & bright[2]) < 3


def test_the_light_comes_from_where_the_telescope_really_points() -> None:
    at = Scene(MONTSEC, 2.0, 50.0, dome_open=True)
    off = Scene(MONTSEC, 2.0, 50.0, axis=(2.0, 50.02), dome_open=True)
    one, other = counts_of(at), counts_of(off)
    # 0.02 ° to the north is 77.6 pixels: what stood there stands so much lower.
    shift = [
        float(numpy.corrcoef(one[by : by + 400].ravel(), other[:400].ravel())[0, 1])
        for by in range(60, 100)
    ]
    assert numpy.argmax(shift) + 60 == pytest.approx(77.6, abs=1)


def test_a_lamp_in_the_closed_dome_and_the_filter_make_a_flat() -> None:
    dark = counts_of(Scene(MONTSEC, lamp=True), 2.0, frame="dark")
    flat = counts_of(Scene(MONTSEC, lamp=True, filter_name="R"), 2.0, frame="flat")
    brighter = counts_of(Scene(MONTSEC, lamp=True, filter_name="L"), 2.0, frame="flat")
    assert numpy.median(dark) < 110
    assert numpy.median(brighter) / numpy.median(flat) == pytest.approx(0.95 / 0.28, rel=0.1)
    assert flat[:40, :40].mean() < 0.95 * flat[235:275, 360:400].mean()


def test_binning_and_gain_are_those_of_the_next_exposure() -> None:
    fits = pytest.importorskip("astropy.io.fits")
    camera = CcdCamera(
        Scene(MONTSEC, 2.0, 50.0, dome_open=True, filter_name="B", mirror=1.0, focus=2.0)
    )
    camera.start_exposure(1)
    assert camera.set_binning(2).good
    assert camera.set_gain(60).good
    assert not camera.set_binning(1.5).good
    assert not camera.set_gain(float("nan")).good
    for second in range(1, 4):
        camera.step(1, NIGHT + second)
    assert camera.newest is not None
    assert camera.newest.counts.shape == (510, 765)
    expose(camera, 1)
    header = fits.getheader(io.BytesIO(camera.newest.fits))
    assert (header["NAXIS1"], header["XBINNING"], header["FILTER"]) == (382, 2, "B")
    assert (header["XPIXSZ"], header["FOCUSPOS"]) == (18.0, 2)
    # A focuser at the end of its way costs no more time than another.
    assert header["EGAIN"] == pytest.approx(2.3 / 10**0.3)


@pytest.mark.parametrize("seconds", [-1, float("nan"), 3601, 0])
def test_an_exposure_that_makes_no_sense_is_refused(seconds: float) -> None:
    camera = CcdCamera(Scene(MONTSEC))
    ticket = camera.start_exposure(seconds)
    assert (ticket.good, camera.state) == (False, "idle")
    assert "expected 0.04 to 3600 s" in ticket.message


def test_an_exposure_begins_by_the_clock_where_time_passes_faster_than_that() -> None:
    camera = CcdCamera(Scene(MONTSEC))
    camera.step(6.0, NIGHT)
    ticket = camera.start_exposure(20)
    moment = NIGHT
    while not ticket.ended:
        moment += 0.3
        camera.step(6.0, moment)
    assert camera.newest is not None
    assert camera.newest.name.startswith(f"{datetime.fromtimestamp(NIGHT, UTC):%Y%m%dT%H%M%S}-")


def test_an_aborted_exposure_leaves_no_picture() -> None:
    camera = CcdCamera(Scene(MONTSEC))
    ticket = camera.start_exposure(60)
    camera.step(5, NIGHT)
    camera.abort_exposure()
    camera.step(100, NIGHT + 100)
    assert (ticket.good, camera.newest) == (False, None)


def test_the_cooler_reaches_its_set_point_but_no_more_than_it_can() -> None:
    camera = CcdCamera(Scene(MONTSEC, weather={"temperature": 10.0}))
    camera.cool_to(-40)
    for _ in range(900):
        camera.step(1, NIGHT)
    assert camera.celsius == pytest.approx(-25, abs=0.5)


def test_an_outlet_is_rebooted_and_a_wrong_one_is_refused() -> None:
    power = Power()
    assert power.reboot_outlet(3).good
    assert not power.on[2]
    power.step(6)
    assert power.on[2]
    assert "expected 1 to 8" in power.switch_outlet(9, on=True).message


def test_the_wall_camera_sees_the_sky_through_an_open_slit_by_day() -> None:
    shut = cctv.draw_view(cctv.View(0, 180, 10, 10, 1.0))
    opened = cctv.draw_view(cctv.View(1, 180, 10, 10, 1.0))
    assert len(shut) == len(opened) == cctv.WIDTH * cctv.HEIGHT * 3
    middle = (60 * cctv.WIDTH + cctv.WIDTH // 2) * 3
    assert sum(opened[middle : middle + 3]) > sum(shut[middle : middle + 3]) + 200


def test_the_wall_camera_sees_each_shell_of_a_clamshell_by_itself_and_no_slit() -> None:
    def sky(east: float, west: float) -> tuple[bool, bool, bool]:
        """Whether there is sky at the left (east), in the middle, and at the right (west)."""
        opening = max(east, west)
        picture = cctv.draw_view(cctv.View(opening, 0, 10, 10, 1.0, shells=(east, west)))
        at = [(100 * cctv.WIDTH + x) * 3 for x in (70, cctv.WIDTH // 2, 250)]
        left, middle, right = (tuple(picture[i : i + 3]) == (126, 178, 235) for i in at)
        return left, middle, right

    assert sky(0, 0) == (False, False, False)
    assert sky(1, 0) == (True, False, False)
    assert sky(0, 1) == (False, True, True)
    assert sky(1, 1) == (True, True, True)


def test_closing_all_goes_on_to_the_dome_when_the_telescope_does_not_park() -> None:
    asked: list[tuple[str, str]] = []

    def call(device: str, what: str) -> Ticket:
        asked.append((device, what))
        return Ticket() if what == "park" else Ticket.done("")

    everything = GlobalServer(call)
    ticket = everything.triggers["close"]()
    for second in range(70):
        everything.step(1, float(second))
    assert asked == [("camera", "abort"), ("telescope", "park"), ("dome", "close")]
    assert (ticket.good, ticket.message) == (False, "telescope/park: no answer")
