"""Wandering meets nothing and gets about."""

from __future__ import annotations

import numpy as np
import pytest

from talaia.sim.vehicle.base import Ramp
from talaia.sim.vehicle.house import ROOMS
from talaia.sim.vehicle.wander import Wander
from talaia.sim.vehicle.world import World

MINUTES = 5


@pytest.mark.parametrize("seed", range(4))
def test_it_drives_for_minutes_and_touches_nothing(seed: int) -> None:
    world, wander, ramp = World(seed), Wander(seed), Ramp()
    metres = 0.0
    places = set()
    for _ in range(MINUTES * 600):
        speed, turn = wander.choose_velocity(0.1, world.scan_lidar())
        for _ in range(5):
            ramp.follow_velocity(0.02, speed, turn)
            motion = world.step(0.02, ramp.speed, ramp.turn)
            assert not world.touching, motion
            metres += abs(motion.speed) * 0.02
        places.add((motion.x, motion.y))
    visited = {
        room.name
        for room in ROOMS
        for x, y in places
        if room.low[0] < x < room.high[0] and room.low[1] < y < room.high[1]
    }
    assert metres > MINUTES * 4
    assert len(visited) >= 2


def test_before_a_wall_it_turns_away_on_the_spot() -> None:
    ranges = np.full(360, 3.0, dtype=np.float32)
    ranges[:60] = ranges[-60:] = 0.25
    speed, turn = Wander(0).choose_velocity(0.1, ranges)
    assert speed == 0.0
    assert turn != 0.0


def test_it_keeps_turning_the_same_way_until_it_is_free() -> None:
    wander = Wander(0)
    ranges = np.full(360, 3.0, dtype=np.float32)
    ranges[:60] = ranges[-60:] = 0.25
    first = wander.choose_velocity(0.1, ranges)[1]
    ranges[:20] = ranges[-90:] = 0.25
    assert wander.choose_velocity(0.1, ranges)[1] == first


def test_where_the_lidar_sees_nothing_it_goes_ahead() -> None:
    speed, _ = Wander(0).choose_velocity(0.1, np.full(360, np.inf, dtype=np.float32))
    assert speed > 0.1
