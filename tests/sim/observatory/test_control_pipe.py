"""Orders to the simulator by a named pipe, and what its weather and its dome then say."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING

import pytest

from talaia.sim.observatory.control_pipe import ControlPipe, act_on
from talaia.sim.observatory.models.enclosure import SimulatedEnclosure
from talaia.sim.observatory.models.power import Power
from talaia.sim.observatory.models.weather import Weather
from talaia.sim.observatory.servers.base import Stamped
from talaia.sim.observatory.servers.dome import DomeServer
from talaia.sim.observatory.servers.power import PowerServer
from talaia.sim.observatory.servers.weather import WeatherServer

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.pure


def test_lines_come_whole_however_they_were_cut(tmp_path: Path) -> None:
    pipe = tmp_path / "orders"
    orders = ControlPipe(pipe)
    writer = os.open(pipe, os.O_WRONLY)
    try:
        os.write(writer, b"dome do open\nweather ra")
        assert orders.read_orders() == [("dome", "do open")]
        assert orders.read_orders() == []
        os.write(writer, b"in\n\n")
        assert orders.read_orders() == [("weather", "rain")]
    finally:
        os.close(writer)
        orders.close()
    assert ControlPipe(None).read_orders() == []


def test_an_order_acts_on_the_server_and_a_fault_is_none() -> None:
    dome, power = DomeServer(SimulatedEnclosure()), PowerServer(Power())
    opening = act_on(dome, "do open")
    assert opening is not None
    assert not opening.ended
    switched = act_on(power, "do outlet1 off")
    assert switched is not None
    assert not power.model.on[0]
    unknown = act_on(dome, "do fly")
    assert unknown is not None
    assert not unknown.good
    assert act_on(dome, "stuck") is None


def test_truth_is_the_position_whatever_the_switches_say() -> None:
    dome = SimulatedEnclosure()
    assert dome.truth == "closed"
    dome.open()
    dome.step(6.0)
    assert dome.truth == "opening"
    dome.stop()
    assert dome.truth == "partly"
    dome.lying = "closed"
    assert dome.closed
    assert dome.truth == "partly"
    dome.lying = ""
    dome.close()
    assert dome.truth == "closing"
    dome.stuck = True
    assert dome.truth == "partly"


def test_a_station_says_other_numbers_frozen_ones_and_old_stamps() -> None:
    station = WeatherServer(Weather(1, 0.0))
    station.step(1.0, 100.0)
    assert station.topic_values()["stamped"] == Stamped(station.model.temperature, 100.0)
    assert station.inject_fault("set wind -999") == ""
    assert station.topic_values()["wind"] == -999.0
    assert station.inject_fault("set wind nan") == ""
    wind = station.topic_values()["wind"]
    assert isinstance(wind, float)
    assert math.isnan(wind)
    assert "expected one of" in station.inject_fault("set color 1")
    assert "not a number" in station.inject_fault("set wind strong")
    station.inject_fault("ok")
    station.inject_fault("freeze")
    station.inject_fault("old stamps")
    before = dict(station.topic_values())
    station.step(60.0, 160.0)
    after = station.topic_values()
    assert after["temperature"] == before["temperature"] != station.model.temperature
    stamped = after["stamped"]
    assert isinstance(stamped, Stamped)
    assert stamped.unix_s == 100.0
    station.inject_fault("ok")
    assert station.topic_values()["temperature"] == station.model.temperature
