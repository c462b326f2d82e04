"""What the pages change: sensors by number, services, and taking away with what referred to it."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from talaia.configurator import edits
from talaia.configurator.errors import ConfiguratorError, WordTaken
from talaia.configurator.presets import OTHERS, SENSORS
from talaia.model.ai_services import AiServices
from talaia.model.checks.site_checks import check_site
from talaia.model.site import DriveMessage, Site
from talaia.model.yaml_text.load import load_site, read_site
from talaia.model.yaml_text.write import write_description

EXAMPLES = Path(__file__).parents[2] / "examples"
EMPTY = edits.new_site("robot", "Robot", "UTC")


def kind(word: str) -> edits.SensorKind:
    return next(each for each in SENSORS if each.word == word)


@pytest.mark.parametrize("preset", SENSORS, ids=lambda each: each.word)
def test_each_kind_in_the_list_makes_a_sensor_that_runs(preset: edits.SensorKind) -> None:
    site = edits.with_sensor(EMPTY, edits.NewSensor(preset, 1))
    assert check_site(site) == []
    signal = site.devices["sensors"].signals[f"{preset.word}1"]
    assert (signal.source.topic, signal.source.name) == ("/metric", f"{preset.word}1")
    assert signal.unit == preset.unit


def test_a_second_sensor_of_a_kind_has_the_next_number() -> None:
    site = edits.with_sensor(EMPTY, edits.NewSensor(kind("speed"), 1))
    assert edits.free_number(site, kind("speed")) == 2
    with pytest.raises(WordTaken, match="number 2 is free"):
        edits.with_sensor(site, edits.NewSensor(kind("speed"), 1))


@given(st.text(min_size=1, max_size=90), st.integers(1, 999))
def test_a_sensor_of_ones_own_has_an_address_whatever_it_is_called(name: str, number: int) -> None:
    new = edits.NewSensor(OTHERS, number, name, "ppm")
    if not name.strip():
        with pytest.raises(ConfiguratorError, match="needs a name"):
            edits.with_sensor(EMPTY, new)
        return
    site = edits.with_sensor(EMPTY, new)
    # A name of things unseen is the person's to mend, and told; the address always fits.
    assert all(each.where.endswith(".name") for each in check_site(site))


def test_a_sensor_of_ones_own_is_heard_under_the_name_as_it_was_typed() -> None:
    new = edits.NewSensor(OTHERS, 1, " Accelerometer ", "m/s²")
    site = edits.with_sensor(EMPTY, new)
    (signal,) = site.devices["sensors"].signals.items()
    assert signal[0] == "accelerometer1"
    assert signal[1].source.name == "Accelerometer1"
    # Its letters are the node's own: another spelling is another sensor, at a free address.
    assert edits.free_number(site, OTHERS, "ACCELEROMETER") == 2


def test_the_three_services_stand_together_and_see_each_other() -> None:
    site = edits.with_gps(edits.with_camera(edits.with_drive(EMPTY)))
    assert check_site(site) == []
    drive = site.devices["base"].drive
    assert drive is not None
    assert drive.message is DriveMessage.KEYS
    assert (drive.topic, drive.picture, drive.position) == (
        "/control", "camera/front", "gps/position",
    )  # fmt: skip
    assert load_site(write_description(site)) == site


def test_what_is_taken_out_leaves_no_reference_and_no_empty_device() -> None:
    site = edits.with_gps(edits.with_camera(edits.with_drive(EMPTY)))
    site = edits.without_things(site, [*edits.camera_paths(site), *edits.position_paths(site)])
    assert set(site.devices) == {"base"}
    assert check_site(site) == []
    site = edits.without_things(site, [("devices", "base", "drive")])
    assert site.devices == {}


def test_a_device_that_goes_takes_the_references_to_it_along() -> None:
    site = load_site((EXAMPLES / "agv/site.yaml").read_text())
    site = edits.without_things(
        site, [("devices", "camera"), ("devices", "base", "signals", "speed")]
    )
    # What guards and what tells people never goes by itself: a person is told, and decides.
    assert [each.where for each in check_site(site)] == [
        "$.interlocks.person_ahead.when[0].signal",
        "$.alarms.person_in_the_way.signal",
    ]
    drive = site.devices["base"].drive
    assert drive is not None
    assert drive.stop.confirmed_by == ("base/turn_rate",)
    assert (drive.picture, drive.position) == ("", "base/pose")


def test_ai_services_are_a_key_only_where_one_is_wanted() -> None:
    wanted = edits.with_services(EMPTY, AiServices(anomaly_detection=True))
    assert "anomaly_detection: true" in write_description(wanted)
    assert edits.ai_services(load_site(write_description(wanted))).anomaly_detection
    assert "services" not in write_description(edits.with_services(wanted, AiServices()))


def test_a_site_without_ros_says_why_a_sensor_cannot_be_heard() -> None:
    site = read_site(EXAMPLES / "indi/site.yaml")
    with pytest.raises(ConfiguratorError, match="speaks ROS"):
        edits.with_sensor(site, edits.NewSensor(kind("speed"), 1))


def test_in_a_site_of_two_protocols_a_sensor_comes_over_ros() -> None:
    text = (
        "talaia: 1\nsite: a\nname: A\nconnections: {mount: {kind: indi}, robot: {kind: ros1}}\n"
        "devices: {sensors: {name: Weather, connection: mount, indi: Weather}}\n"
    )
    site: Site = edits.with_sensor(load_site(text), edits.NewSensor(kind("speed"), 1))
    assert site.devices["sensors_2"].connection == "robot"
    assert check_site(site) == []
