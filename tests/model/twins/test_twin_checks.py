"""What keeps a twin from being run is told with where it stands and what to write."""

from __future__ import annotations

from pathlib import Path

import pytest

from talaia.hub.anomaly.runner import detector_of
from talaia.hub.anomaly.selection import wanted_detectors
from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.role_proposal import roles_of
from talaia.model.twins.twin_topics import device_text, twin_drive
from talaia.model.yaml_text.load import load_site, read_site

EXAMPLES = Path(__file__).parents[3] / "examples"
TEXT = (EXAMPLES / "agv" / "with_twin.yaml").read_text()
TWIN = "{of: base, friction: 0, track_width: 0.16, reset_beyond: 0.5}"


def problems(before: str, after: str) -> list[str]:
    assert before in TEXT
    return [one.problem for one in check_site(load_site(TEXT.replace(before, after)))]


def test_a_twin_is_no_second_robot_for_pages_that_look_for_roles() -> None:
    roles = roles_of(load_site(TEXT).devices["twin"])
    assert not roles.signals
    assert not roles.commands


def test_the_example_can_be_run() -> None:
    assert check_site(load_site(TEXT)) == []


def test_what_is_printed_to_be_added_is_all_that_is_needed() -> None:
    agv = (EXAMPLES / "agv" / "site.yaml").read_text()
    text = agv.replace("\n  power:\n", f"\n{device_text('twin', 'base')}\n  power:\n", 1)
    assert text != agv
    assert check_site(load_site(text)) == []


@pytest.mark.parametrize(
    ("twin", "problem"),
    [
        ("{of: power}", "there is no driven device 'power'"),
        ("{of: twin}", "there is no driven device 'twin'"),
        ("{of: base, friction: -1}", "expected 0 to 1000 N per m/s, found -1"),
        ("{of: base, reset_beyond: .nan}", "expected 0.01 to 100 m, found nan"),
        ("{of: base, follow_rate: 0}", "expected 0.05 to 20 1/s, found 0"),
    ],
)
def test_a_twin_of_nothing_or_without_bounds_is_refused(twin: str, problem: str) -> None:
    assert problem in problems(TWIN, twin)


def test_a_twin_has_no_lease_of_its_own() -> None:
    driven = f"{TWIN}\n    drive: {{topic: /twin/cmd_vel, max_speed: 1, max_turn: 1}}"
    assert "a twin is driven under the lease of base" in problems(TWIN, driven)


def test_a_robot_without_odometry_has_no_twin() -> None:
    found = problems("      position: base/pose\n", "")
    assert "where base is, is not read from a nav_msgs/msg/Odometry" in found


def test_a_robot_that_is_driven_by_characters_has_no_twin() -> None:
    found = problems("message: geometry_msgs/msg/Twist", "message: std_msgs/msg/String")
    assert "base is driven by std_msgs/msg/String: a twin follows a Twist" in found


def test_what_the_gateway_decides_by_is_read_from_the_twins_own_topics() -> None:
    found = problems("topic: /twin/mode", "topic: /mode")
    assert "the gateway has to read mode of a twin on /twin/mode" in found
    # In another order a rehearsal would be taken for following.
    found = problems("[waiting, following, rehearsing]", "[following, waiting, rehearsing]")
    assert "a twin's modes are waiting, following, rehearsing" in found


def test_a_twin_is_driven_within_the_robots_limits_and_has_no_stop() -> None:
    real = read_site(EXAMPLES / "agv" / "with_twin.yaml").devices["base"].drive
    assert real is not None
    driven = twin_drive(real, "twin")
    assert driven.topic == "/twin/cmd_vel"
    assert (driven.max_speed, driven.max_turn) == (real.max_speed, real.max_turn)
    assert not driven.stop.topic


def test_what_the_robot_differs_from_its_twin_by_is_watched_by_a_detector() -> None:
    wishes = {wish.address: wish for wish in wanted_detectors(load_site(TEXT))[0]}
    (watch,) = wishes["twin/pose_error"].watches
    detector = detector_of(watch, wishes["twin/pose_error"].unit)
    assert [detector.see(at, error) for at, error in enumerate((0.02, 0.29, 0.5))] == [0, 0, 1]
    assert "0.3 m" in detector.why()
