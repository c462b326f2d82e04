"""Focus and centring as the night asks for them, on the simulated telescope and camera."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest

from talaia.clock import SECOND, HandClock
from talaia.gateway.night.imaging.star_parts import DeviceFailed, FieldCentre
from talaia.gateway.night.imaging.star_work import (
    CentringSolver,
    FocusRules,
    FocusRunner,
)
from talaia.imaging.frame_tasks import measure_focus, solve_frame
from talaia.imaging.tangent_plane import angular_distance
from talaia.model.units.astronomy import J2000, julian_day, precess_coordinates
from talaia.sim.observatory.models.camera import CcdCamera, Scene
from talaia.sim.observatory.models.focuser import Focuser
from talaia.sim.observatory.models.optics import best_focus
from talaia.sim.observatory.models.telescope import Telescope
from talaia.sim.observatory.servers.devices import MONTSEC

NIGHT = 1_795_302_000  # 2026-11-21 23:00 UTC
TARGET = (40.0, 60.0)


class Observatory:
    """The simulator's models in time of their own: `StarDevices`."""

    def __init__(self) -> None:  # noqa: D107
        self.clock = HandClock(NIGHT * SECOND)
        self.telescope = Telescope(MONTSEC, NIGHT)
        self.focuser = Focuser()
        self.camera = CcdCamera(Scene(MONTSEC, dome_open=True, tube=10.0))
        self.broken = ""
        self.telescope.unpark()

    def pass_time(self, seconds: float) -> None:
        for _ in range(round(seconds * 2)):
            self.clock.advance(SECOND // 2)
            now = self.clock.wall_ns() / 1e9
            self.telescope.step(0.5, now)
            self.focuser.step(0.5)
            scene = self.camera.scene
            scene.ra, scene.dec = self.telescope.radec
            scene.axis, scene.mirror = self.telescope.axis, self.focuser.mirror
            self.camera.step(0.5, now)

    async def slew_to(self, ra: float, dec: float) -> None:
        ticket = self.telescope.goto(ra, dec)
        while not ticket.ended:
            self.pass_time(0.5)

    async def take_frame(self, seconds: float) -> bytes:
        if self.broken:
            raise DeviceFailed(self.broken)
        ticket = self.camera.start_exposure(seconds)
        while not ticket.ended:
            self.pass_time(0.5)
        assert self.camera.newest is not None
        return self.camera.newest.fits

    async def move_focuser(self, position: float) -> None:
        self.focuser.goto(position)
        while self.focuser.moving:
            self.pass_time(0.5)

    def focuser_position(self) -> float | None:
        return self.focuser.position

    def tube_temperature(self) -> float | None:
        return 10.0

    async def track_target(self) -> None:
        jd = julian_day(self.clock.wall_ns() / 1e9)
        await self.slew_to(*precess_coordinates(TARGET[0] / 15, TARGET[1], J2000, jd))

    @property
    def off(self) -> float:
        jd = julian_day(self.clock.wall_ns() / 1e9)
        ra, dec = precess_coordinates(*self.telescope.axis, jd, J2000)
        return angular_distance(ra * 15, dec, *TARGET) * 3600


@pytest.fixture
def work():
    with ThreadPoolExecutor(1) as pool:
        yield pool


async def test_a_field_is_centred_from_files_alone(work) -> None:
    devices = Observatory()
    await devices.track_target()
    assert devices.off > 100
    solver = CentringSolver(devices, work, devices.clock)
    ended = await solver.centre_field(FieldCentre(*TARGET))
    assert ended.good, ended.message
    assert devices.off < 6
    # As the simulator's air spreads the stars: a little more than 2.2″ near the zenith.
    assert ended.seeing == pytest.approx(2.8, abs=0.8)


async def test_a_focus_run_ends_in_focus_and_is_due_again_by_its_rules(work) -> None:
    devices = Observatory()
    await devices.track_target()
    devices.focuser.goto(25_090)
    devices.pass_time(1)
    runner = FocusRunner(devices, work, devices.clock, FocusRules(every=3600.0, degrees=2.0))
    assert runner.is_due("", 10.0, 0.0)
    ended = await runner.run_focus("")
    assert ended.good, ended.message
    assert devices.focuser.mirror == pytest.approx(best_focus(10.0), abs=12)
    now = devices.clock.monotonic_ns() / 1e9
    assert not runner.is_due("", 10.5, now)
    assert runner.is_due("R", 10.0, now)
    assert runner.is_due("", 7.5, now)
    assert runner.is_due("", 10.0, now + 3600)


async def test_what_devices_do_not_do_is_said_in_their_words(work) -> None:
    devices = Observatory()
    await devices.track_target()
    devices.broken = "the camera has no power"
    solved = await CentringSolver(devices, work, devices.clock).centre_field(FieldCentre(*TARGET))
    assert solved.message == "no picture to solve: the camera has no power"
    focused = await FocusRunner(devices, work, devices.clock).run_focus("")
    assert focused.message == "no focus: the camera has no power"
    devices.broken = ""
    devices.camera.scene.dome_open = False
    solved = await CentringSolver(devices, work, devices.clock).centre_field(FieldCentre(*TARGET))
    assert "at least 5 are needed" in solved.message


def test_a_file_that_is_none_is_a_problem_and_no_crash() -> None:
    assert "not FITS" in solve_frame(b"nothing").problem
    assert "not FITS" in measure_focus(b"nothing").problem
