"""Who is connected, set up and left alone, with a hand-moved time."""

from __future__ import annotations

import pytest

from talaia.clock import SECOND
from talaia.gateway.adapters.indi.driver_connections import DriverConnections, DriverProblem
from talaia.gateway.adapters.indi.protocol import (
    Element,
    PropertyPermission,
    PropertyState,
    SwitchRule,
    Vector,
    VectorKind,
)
from talaia.gateway.adapters.indi.state import IndiDeviceTree

NAME = "Weather Simulator"
SETUP = {NAME: {"WEATHER_UPDATE": {"PERIOD": 5.0}}}


class Driver:
    """A driver as its server tells of it, and the moments at which it is looked at."""

    def __init__(self, setup: dict = SETUP, *, connect: bool = True) -> None:  # noqa: D107
        self.book = IndiDeviceTree()
        self.connections = DriverConnections(setup, connect=connect)
        self.now_ns = 1000 * SECOND
        self.start()

    def start(self) -> None:
        self.book.forget_all()
        self.says("CONNECTION", VectorKind.SWITCH, new=True, CONNECT=False, DISCONNECT=True)
        self.connections.redefine(NAME)

    def says(
        self,
        name: str,
        kind: VectorKind,
        state: PropertyState = PropertyState.IDLE,
        *,
        new: bool = False,
        **values: object,
    ) -> None:
        elements = tuple(Element(key, value, "", "", 0, 0, 0) for key, value in values.items())
        vector = Vector(
            new,
            kind,
            NAME,
            name,
            elements,
            state,
            "",
            "",
            PropertyPermission.BOTH,
            SwitchRule.ANY,
            0,
            "",
        )
        self.book.apply_event(vector, self.now_ns)

    def connected(self, state: PropertyState = PropertyState.OK) -> None:
        self.says("CONNECTION", VectorKind.SWITCH, state, CONNECT=True, DISCONNECT=False)

    def disconnected(self, state: PropertyState = PropertyState.IDLE) -> None:
        self.says("CONNECTION", VectorKind.SWITCH, state, CONNECT=False, DISCONNECT=True)

    def look(self, after: float = 0.0) -> list[str]:
        """Name what is asked and said now."""
        self.now_ns += round(after * SECOND)
        found = []
        for each in self.connections.next_actions(self.book.devices[NAME], self.now_ns):
            words = each.kind if isinstance(each, DriverProblem) else each.decode()
            found.append("connect" if "CONNECTION" in words else words.strip())
        return found


def test_driver_that_crashed_is_connected_again_at_once_and_a_crash_loop_with_pauses() -> None:
    driver = Driver({})
    assert driver.look() == ["connect"]
    driver.connected()
    assert driver.look(after=120) == []
    assert driver.look(after=120) == []
    driver.start()
    assert driver.look(after=0.1) == ["driver_restarted", "connect"]
    pauses = []
    for _ in range(5):
        driver.connected()
        driver.look(after=0.1)
        driver.start()
        waited = 0.1
        while not driver.look(after=1.0):
            waited += 1.0
        pauses.append(round(waited))
    assert pauses == [4, 9, 29, 59, 59]


def test_setup_is_written_after_each_connect_as_soon_as_its_property_is_there() -> None:
    driver = Driver()
    for _ in range(2):
        driver.look(after=100)
        driver.connected()
        assert driver.look(after=0.25) == []
        driver.says("WEATHER_UPDATE", VectorKind.NUMBER, new=True, PERIOD=60.0)
        (asked,) = driver.look(after=0.25)
        assert 'name="PERIOD">5.0</oneNumber>' in asked
        driver.says("WEATHER_UPDATE", VectorKind.NUMBER, PropertyState.OK, PERIOD=5.0)
        assert driver.look(after=60) == []
        # Another client's wish is its own until the next connect.
        driver.says("WEATHER_UPDATE", VectorKind.NUMBER, PropertyState.OK, PERIOD=30.0)
        assert driver.look(after=60) == []
        driver.start()


def test_setup_of_what_a_driver_has_before_it_is_connected_goes_before_the_connect() -> None:
    driver = Driver(
        {NAME: {"WATCH_SOURCE": {"URL": "/run/weather"}, "WEATHER_UPDATE": {"PERIOD": 5.0}}}
    )
    driver.says("WATCH_SOURCE", VectorKind.TEXT, new=True, URL="")
    address, connect = driver.look()
    assert "/run/weather" in address
    assert connect == "connect"
    driver.says("WATCH_SOURCE", VectorKind.TEXT, PropertyState.OK, URL="/run/weather")
    driver.connected()
    assert driver.look() == []
    driver.says("WEATHER_UPDATE", VectorKind.NUMBER, new=True, PERIOD=60.0)
    assert ["PERIOD" in each for each in driver.look()] == [True]


def test_setup_that_the_driver_does_not_answer_or_refuses_is_written_again_and_told_once() -> None:
    driver = Driver()
    driver.look()
    driver.connected()
    driver.says("WEATHER_UPDATE", VectorKind.NUMBER, new=True, PERIOD=60.0)
    assert len(driver.look()) == 1
    assert driver.look(after=4) == []
    assert len(driver.look(after=2)) == 1
    driver.says("WEATHER_UPDATE", VectorKind.NUMBER, PropertyState.ALERT, PERIOD=60.0)
    assert [each.split()[0] for each in driver.look(after=11)] == [
        "driver_not_set_up",
        "<newNumberVector",
    ]
    assert len(driver.look(after=31)) == 1


@pytest.mark.parametrize(
    ("setup", "says"),
    [
        ({"NOTHING": {"A": 1.0}}, "it has no property NOTHING"),
        ({"WEATHER_UPDATE": {"TIME": 1.0}}, "it has no TIME; it has PERIOD"),
        ({"WEATHER_UPDATE": {"PERIOD": "often"}}, "PERIOD is a number, found 'often'"),
    ],
)
def test_setup_that_does_not_fit_the_driver_is_told_with_what_it_has(
    setup: dict, says: str
) -> None:
    driver = Driver({NAME: setup})
    driver.look()
    driver.connected()
    driver.says("WEATHER_UPDATE", VectorKind.NUMBER, new=True, PERIOD=60.0)
    driver.look()
    device, told = driver.book.devices[NAME], []
    driver.connections.restart()
    for seconds in (0, 1, 20, 60):
        driver.now_ns += seconds * SECOND
        told += [
            e
            for e in driver.connections.next_actions(device, driver.now_ns)
            if isinstance(e, DriverProblem)
        ]
    assert [each.kind for each in told] == ["driver_not_set_up"]
    assert says in told[0].message


def test_driver_that_somebody_disconnected_is_left_also_when_it_or_the_server_starts_anew() -> None:
    driver = Driver({})
    driver.look()
    driver.connected()
    driver.look()
    driver.disconnected()
    assert driver.look(after=300) == []
    assert driver.connections.is_left(NAME)
    driver.start()
    assert driver.look(after=300) == []
    driver.connections.restart()
    driver.start()
    assert driver.look(after=300) == []
    driver.connected()
    driver.look()
    driver.start()
    assert "connect" in driver.look(after=60)


def test_driver_that_gave_up_with_alert_or_was_defined_anew_is_connected_again() -> None:
    driver = Driver({})
    driver.look()
    driver.connected()
    driver.look(after=1)
    driver.disconnected(PropertyState.ALERT)
    assert driver.look(after=60) == ["connect"]
    driver.connected()
    driver.look(after=1)
    driver.says("CONNECTION", VectorKind.SWITCH, new=True, CONNECT=False, DISCONNECT=True)
    assert driver.look(after=60) == ["driver_restarted", "connect"]


def test_person_who_connects_in_vain_is_helped_and_who_wants_no_connecting_has_none() -> None:
    driver = Driver({})
    driver.connections.set_wanted(NAME, connect=False, now_ns=driver.now_ns)
    assert driver.look(after=60) == []
    driver.connections.set_wanted(NAME, connect=True, now_ns=driver.now_ns)
    assert driver.look(after=1) == []
    assert driver.look(after=5) == ["connect"]
    assert Driver({}, connect=False).look(after=300) == []
