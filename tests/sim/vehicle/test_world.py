"""The physics of the vehicle and what its sensors measure."""

from __future__ import annotations

import math

import numpy as np
import pytest

from talaia.sim.vehicle.vehicle import RADIUS
from talaia.sim.vehicle.world import World


def drive(world: World, seconds: float, speed: float, turn: float) -> None:
    for _ in range(round(seconds / 0.02)):
        world.step(0.02, speed, turn)


@pytest.mark.parametrize("speed", [0.2, -0.2, 0.05, 0.22])
def test_it_drives_as_fast_as_asked(speed: float) -> None:
    world = World(0)
    drive(world, 0.5, speed, 0.0)
    start = world.current_motion()
    drive(world, 2.0, speed, 0.0)
    end = world.current_motion()
    assert (end.x - start.x) / 2.0 == pytest.approx(speed, rel=0.02)
    assert end.speed == pytest.approx(speed, rel=0.02)
    assert abs(end.y) < 1e-3


@pytest.mark.parametrize("turn", [1.0, -1.0, 2.84])
def test_it_turns_as_fast_as_asked(turn: float) -> None:
    world = World(0)
    drive(world, 0.5, 0.0, turn)
    start = world.current_motion().yaw
    drive(world, 1.0, 0.0, turn)
    turned = math.remainder(world.current_motion().yaw - start, 2 * math.pi)
    assert turned == pytest.approx(math.remainder(turn, 2 * math.pi), rel=0.02)
    assert world.current_motion().turn == pytest.approx(turn, rel=0.02)


def test_it_drives_along_an_arc_without_slipping_aside() -> None:
    world = World(0)
    drive(world, 4.0, 0.2, 0.5)
    motion = world.current_motion()
    assert abs(motion.slip) < 0.002
    assert motion.yaw == pytest.approx(2.0, rel=0.03)


@pytest.mark.parametrize("yaw", [math.pi, 2.6, -2.5])
def test_a_wall_stops_it(yaw: float) -> None:
    world = World(0)
    world.place_vehicle(-1.0, -0.4, yaw)
    drive(world, 12.0, 0.22, 0.0)
    assert world.touching
    assert world.current_motion().speed == pytest.approx(0.0, abs=0.01)
    before = world.current_motion()
    drive(world, 5.0, 0.22, 0.0)
    after = world.current_motion()
    assert math.hypot(after.x - before.x, after.y - before.y) < 0.03
    assert after.x > -2.0 + RADIUS


def test_furniture_stops_it_and_it_can_back_off() -> None:
    world = World(0)
    world.place_vehicle(0.9, -0.9, -math.pi / 2)
    drive(world, 10.0, 0.22, 0.0)
    stuck = world.current_motion()
    assert world.touching
    assert stuck.y > -2.1
    drive(world, 2.0, -0.2, 0.0)
    assert world.current_motion().y - stuck.y == pytest.approx(0.4, rel=0.1)
    assert not world.touching


def test_every_door_lets_it_through() -> None:
    for x, y, yaw, metres in (
        (3.4, 0.1, 0.0, 1.2),
        (3.2, -2.25, 0.0, 1.2),
        (7.6, 0.2, -math.pi / 2, 1.2),
        (5.1, 0.3, math.pi / 2, 1.2),
        (7.3, 0.3, math.pi / 2, 1.2),
        (0.9, 0.3, math.pi / 2, 1.2),
    ):
        world = World(0)
        world.place_vehicle(x, y, yaw)
        drive(world, metres / 0.2, 0.2, 0.0)
        motion = world.current_motion()
        assert math.hypot(motion.x - x, motion.y - y) == pytest.approx(metres, rel=0.03), (x, y)


def test_the_lidar_measures_the_walls() -> None:
    world = World(0)
    world.place_vehicle(5.2, 0.25, 0.0)
    scan = world.scan_lidar()
    assert scan.shape == (360,)
    assert scan[270] == pytest.approx(0.25 + 0.5 - 0.06, abs=0.03)
    world.place_vehicle(5.2, 0.25, math.pi / 2)
    assert world.scan_lidar()[180] == pytest.approx(0.69, abs=0.03)


def test_the_lidar_says_infinite_where_it_meets_nothing_in_range() -> None:
    world = World(0)
    world.place_vehicle(-1.6, -0.3, 0.0)
    scan = world.scan_lidar()
    assert np.isfinite(scan).sum() > 300
    assert (scan[np.isfinite(scan)] >= 0.12).all()
    assert (scan[np.isfinite(scan)] <= 8.0).all()


def test_the_ultrasonic_sensors_look_left_ahead_and_right() -> None:
    world = World(0)
    world.place_vehicle(6.0, 0.4, 0.0)
    left, front, right = world.measure_sonars()
    assert left == pytest.approx(0.54 * math.sqrt(2) - RADIUS, abs=0.12)
    assert right == pytest.approx(0.84 * math.sqrt(2) - RADIUS, abs=0.15)
    assert front == pytest.approx(2.6, abs=0.3)


def test_the_same_seed_and_steps_give_the_same_world() -> None:
    worlds = [World(7), World(7), World(8)]
    for world in worlds:
        drive(world, 3.0, 0.2, 0.3)
    same, twin, other = worlds
    assert same.current_motion() == twin.current_motion()
    assert (same.scan_lidar() == twin.scan_lidar()).all()
    assert same.measure_sonars() == twin.measure_sonars()
    assert not np.array_equal(same.scan_lidar(), other.scan_lidar())


def test_looks_change_nothing_of_the_physics() -> None:
    plain, furnished = World(3), World(3, looks=True)
    for world in (plain, furnished):
        drive(world, 4.0, 0.22, -0.25)
    assert plain.current_motion() == furnished.current_motion()
    assert np.array_equal(plain.scan_lidar(), furnished.scan_lidar())


def test_wheels_turn_as_far_as_it_drives() -> None:
    world = World(0)
    drive(world, 2.0, 0.2, 0.0)
    motion = world.current_motion()
    assert motion.left == pytest.approx(motion.x / World.WHEEL_RADIUS, rel=0.01)
    drive(world, 1.0, 0.0, 1.0)
    turned = world.current_motion()
    assert turned.right > motion.right
    assert turned.left < motion.left


def test_odd_time_steps_add_up() -> None:
    world = World(0)
    drive(world, 1.0, 0.2, 0.0)
    start = world.current_motion().x
    for _ in range(1000):
        world.step(0.0013, 0.2, 0.0)
    assert world.current_motion().x - start == pytest.approx(0.26, abs=0.002)


def test_friction_costs_speed_as_its_share_of_the_motors_grip() -> None:
    world = World(0, friction=40.0, furnished=False)
    drive(world, 2.0, 0.2, 0.0)
    assert world.current_motion().speed == pytest.approx(0.2 * 400 / 440, rel=0.01)


def test_a_vehicle_that_is_moved_goes_on_as_fast_as_it_was() -> None:
    world = World(0, furnished=False)
    drive(world, 1.0, 0.2, 0.5)
    before = world.current_motion()
    world.move_vehicle(1.0, -2.0, 0.7)
    after = world.current_motion()
    assert (after.x, after.y) == pytest.approx((before.x + 1.0, before.y - 2.0))
    assert after.speed == pytest.approx(before.speed)
    assert after.slip == pytest.approx(before.slip)
    assert after.turn == pytest.approx(before.turn)
