"""Topics that are one thing, topics that hold until the next message, and diagnostics."""

from __future__ import annotations

import pytest

from talaia.model.checks.site_checks import check_site
from talaia.model.connection import RosSource, source_as
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.probe_report import FieldFound, Found, TopicFound
from talaia.model.roles import StateMeaning
from talaia.model.site import NEVER_STALE_S, Signal, Site
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure
LEVEL = (FieldFound("data", "number"),)


def proposed(*topics: TopicFound) -> tuple[Site, tuple[str, ...]]:
    found = Found(1, "ros2", "a test", 5.0, topics=topics)
    made = propose_description(found, "robot", "Robot", "UTC")
    return made.site, made.left_out


def signals_of(site: Site) -> dict[str, Signal]:
    return {
        source_as(signal.source, RosSource).topic: signal
        for device in site.devices.values()
        for signal in device.signals.values()
    }


@pytest.mark.parametrize(
    ("type_name", "said"),
    [
        ("nav_msgs/msg/Path", "a path"),
        ("nav_msgs/msg/OccupancyGrid", "a map"),
        ("sensor_msgs/msg/LaserScan", "a laser scan"),
        ("sensor_msgs/msg/PointCloud2", "a point cloud"),
        ("visualization_msgs/msg/MarkerArray", "markers"),
    ],
)
def test_a_path_a_map_and_a_scan_are_one_thing_and_no_signals(type_name: str, said: str) -> None:
    points = tuple(FieldFound(f"poses[{at}].x", "number") for at in range(70))
    site, left_out = proposed(TopicFound("/plan", type_name, 1, rate=1.0, fields=points))
    assert site.devices == {}
    assert left_out == (f"/plan: {said}, which is one thing and no signals",)


def test_a_latched_topic_never_goes_stale_and_a_rare_one_late() -> None:
    site, _ = proposed(
        TopicFound("/mode", "std_msgs/msg/Float64", 1, fields=LEVEL, latched=True),
        TopicFound("/once", "std_msgs/msg/Float64", 1, fields=LEVEL),
        TopicFound("/often", "std_msgs/msg/Float64", 1, rate=10.0, fields=LEVEL),
    )
    ages = {topic: signal.max_age for topic, signal in signals_of(site).items()}
    assert ages == {"/mode": 0.0, "/once": 3600.0, "/often": 2.0}
    assert signals_of(site)["/mode"].stale_after == NEVER_STALE_S
    assert check_site(site) == []


def test_diagnostics_are_a_state_for_each_of_their_names() -> None:
    kind = "diagnostic_msgs/msg/DiagnosticArray"
    topic = TopicFound("/diagnostics", kind, 1, rate=1.0, names=("arm: motor", "lidar"))
    site, left_out = proposed(topic)
    device = site.devices["diagnostics"]
    assert left_out == ()
    assert list(device.signals) == ["arm_motor", "lidar"]
    motor = device.signals["arm_motor"]
    assert motor.states == ("OK", "Warning", "Error", "Stale")
    assert motor.meanings[2] is StateMeaning.ERROR
    assert motor.source == RosSource(topic="/diagnostics", type=kind, name="arm: motor")
    assert check_site(site) == []


def test_an_interlock_on_a_signal_that_never_goes_stale_says_how_old_it_may_be() -> None:
    text = """
talaia: 1
site: s
name: S
ros2: {}
devices:
  d:
    name: D
    signals:
      mode: {name: M, max_age: 0, source: {topic: /m, type: std_msgs/msg/Float64, field: data}}
    commands: {go: {name: Go, target: /go, type: std_srvs/srv/Trigger}}
interlocks:
  high: {name: High, when: [{signal: d/mode, above: 1%s}], refuse: [d/go]}
"""
    (finding,) = check_site(load_site(text % ""))
    assert finding.where == "$.interlocks.high.when[0].max_age"
    assert "d/mode never goes stale" in finding.problem
    assert check_site(load_site(text % ", max_age: 30")) == []
