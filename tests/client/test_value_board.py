"""What is known of watched channels, and when it is told to be stale."""

from __future__ import annotations

import math

import numpy as np
import pytest

from talaia.client.addresses import WatchedChannel
from talaia.client.value_board import ValueBoard
from talaia.client.values import SignalInfo
from talaia.wire.browser import DeviceUpdate, SiteUpdate, Values
from talaia.wire.columns import Columns, pack_columns

pytestmark = pytest.mark.pure

SPEED = SignalInfo(address="base/speed", name="Speed", type="number", unit="m/s", max_age=2.0)
DOOR = SignalInfo(
    address="dome/door", name="Door", type="state", states=["open", "closed"], max_age=1e9
)


def board() -> ValueBoard:
    made = ValueBoard("agv")
    made.change_channels([WatchedChannel("base/speed", SPEED), WatchedChannel("dome/door", DOOR)])
    return made


def values(*rows, ages=()) -> Values:
    packed = pack_columns(
        Columns(
            np.array([row[0] for row in rows], np.uint16),
            np.array([row[1] for row in rows], np.int64),
            np.array([row[2] for row in rows], np.float64),
            {},
        )
    )
    return Values(sub=0, **packed._asdict(), age_ms=list(ages))


def test_value_is_told_with_unit_and_a_state_by_its_word() -> None:
    speed, door = board().observe_message(values((0, 10, 0.5), (1, 10, 1.0)), 100.0)
    assert (speed.address, speed.value, speed.unit) == ("agv/base/speed", 0.5, "m/s")
    assert (door.value, door.stale) == ("closed", "")
    (strange,) = board().observe_message(values((1, 10, 7.0)), 100.0)
    assert strange.value == 7.0
    (none,) = board().observe_message(values((1, 10, math.nan)), 100.0)
    assert math.isnan(none.value)


def test_stale_is_told_once_and_ends_with_the_next_value() -> None:
    watched = board()
    watched.observe_message(values((0, 10, 0.5), (1, 10, 1.0)), 100.0)
    assert watched.due_s() == 102.0
    assert watched.find_overdue(101.9) == []
    (old,) = watched.find_overdue(102.1)
    assert (old.address, old.stale) == ("agv/base/speed", "older than 2 s")
    assert old.age_s == pytest.approx(2.1)
    assert watched.find_overdue(103.0) == []
    (new,) = watched.observe_message(values((0, 20, 0.75)), 104.0)
    assert new.stale == ""


def test_value_that_comes_old_is_stale_at_once_and_a_repeat_is_not_told_again() -> None:
    watched = board()
    (old,) = watched.observe_message(values((0, 10, 0.5), ages=[3000.0]), 100.0)
    assert (old.stale, old.age_s) == ("older than 2 s", 3.0)
    assert watched.observe_message(values((0, 10, 0.5), ages=[3500.0]), 100.5) == []


def test_hub_gateway_and_device_that_are_away_make_stale_what_they_tell_of() -> None:
    watched = board()
    watched.observe_message(values((0, 10, 0.5), (1, 10, 1.0)), 100.0)
    away = DeviceUpdate(site="agv", device="dome", reached=False, why="unplugged")
    (door,) = watched.observe_message(away, 100.1)
    assert (door.address, door.stale) == ("agv/dome/door", "dome is not reached: unplugged")
    gone = SiteUpdate(site="agv", online=False, since_us=0)
    (speed,) = watched.observe_message(gone, 100.2)
    assert speed.stale == "its gateway is not connected"
    other = SiteUpdate(site="moon", online=False, since_us=0)
    assert watched.observe_message(other, 100.2) == []
    watched.observe_message(values((0, 20, 0.5), (1, 20, 1.0)), 100.3)
    lost = watched.lose_hub("lost", 100.4)
    assert [reading.stale for reading in lost] == ["lost", "lost"]
    # The newest known, told again by a hub that is back, ends it.
    back = watched.observe_message(values((1, 20, 1.0), ages=[100.0]), 100.5)
    assert [reading.stale for reading in back] == [""]


def test_channel_that_the_description_has_no_more_is_passed_over() -> None:
    watched = board()
    watched.change_channels([WatchedChannel("dome/door", DOOR)])
    assert watched.observe_message(values((1, 10, 1.0)), 100.0) == []
