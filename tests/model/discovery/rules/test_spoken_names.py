"""Names of a robot's own, as its owner would say them."""

from __future__ import annotations

import pytest
from described_robot import found_of, read_robot

from talaia.model.connection import RosSource
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.plain_names import with_plain_names
from talaia.model.discovery.probe_report import DeviceFound, Found
from talaia.model.discovery.rules.spoken_names import spoken_name
from talaia.model.site import Device, Signal

pytestmark = pytest.mark.pure


@pytest.mark.parametrize(
    ("written", "unit", "said"),
    [
        ("Mcu pcb temperature", "°C", "MCU PCB temperature"),
        ("System status cpu temperature", "°C", "System status CPU temperature"),
        ("Fl wheel position", "rad", "Front left wheel position"),
        ("Rr motor current", "A", "Rear right motor current"),
        # What only two letters say may be anything.
        ("Fl", "", "Fl"),
        ("Frontleft", "", "Front left"),
        ("E stop", "", "Emergency stop"),
        ("Estop", "", "Emergency stop"),
        ("Fr 3 joint 1 position", "rad", "FR3 joint 1 position"),
        ("In 1 value", "", "In 1 value"),
        ("Timeout s", "s", "Timeout"),
        ("Cmd vel timeout sec", "s", "Velocity command timeout"),
        # What is said in no other place stays.
        ("Timeout s", "", "Timeout s"),
        ("Flow rate lpm", "L/min", "Flow rate"),
        ("Two d mode", "", "2D mode"),
        ("Current state state", "", "Current state"),
        ("Io state aux power", "", "I/O state aux power"),
        ("Wifi signal", "dBm", "Wi-Fi signal"),
        ("/safety/water", "", "/safety/water"),
        ("lifecycle_manager: Nav2 Health", "", "lifecycle_manager: Nav2 Health"),
        ("Temperature of motor", "°C", "Temperature of motor"),
        ("", "", ""),
    ],
)
def test_a_name_is_said_as_people_do(written: str, unit: str, said: str) -> None:
    assert spoken_name(written, unit) == said
    assert spoken_name(said, unit) == said


def test_a_description_has_such_names_and_its_addresses_stay() -> None:
    site = propose_description(found_of(read_robot("judges", "spot")), "robot", "Robot", "UTC").site
    (stop,) = [one for one in site.devices.values() if "hard" in one.commands]
    assert (stop.name, stop.commands["hard"].name) == ("Emergency stop", "Hard")
    cameras = [(word, s.name) for one in site.devices.values() for word, s in one.streams.items()]
    assert ("frontleft", "Front left") in cameras


def test_what_a_driver_calls_itself_stays_as_its_maker_wrote_it() -> None:
    signal = Signal(name="Estop temp", source=RosSource(topic="/a"))
    device = Device(name="Fl wheel", signals={"a": signal})
    found = Found(
        talaia_probe=1,
        protocol="indi",
        where="here",
        seconds=1,
        devices=(DeviceFound(device="Fl wheel", word="wheel", described=device),),
    )
    said = with_plain_names(found, {"wheel": device, "other": device})
    assert said["wheel"].name == "Fl wheel"
    assert said["wheel"].signals["a"].name == "Estop temp"
    assert said["other"].signals["a"].name == "Emergency stop temperature"
