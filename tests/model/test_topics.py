"""Rules for raw topics: which names a pattern fits, and what is wrong with a rule."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from talaia.model.checks.site_checks import check_site
from talaia.model.topics import (
    TopicRight,
    TopicRule,
    calibrated_cameras,
    matches_topic,
    rule_of,
)
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.write import write_description

_SITE = """
talaia: 1
site: farm
name: Farm
ros2: {{}}
devices:
  barn: {{name: Barn}}
topics: [{rules}]
"""


@pytest.mark.parametrize(
    ("pattern", "fitting", "other"),
    [
        ("/scan", ["/scan"], ["/scan/front", "/r/scan", "/scans"]),
        ("/scan/*", ["/scan/front"], ["/scan", "/scan/front/raw"]),
        ("/scan/**", ["/scan", "/scan/front", "/scan/front/raw"], ["/scans", "/r/scan"]),
        ("/**/tf", ["/tf", "/r/tf", "/a/b/tf"], ["/tf_static", "/tf/x"]),
        ("/r?/*_scan", ["/r1/front_scan"], ["/r12/front_scan", "/r1/a/front_scan"]),
        ("/cam[12]/**", ["/cam1/image", "/cam2"], ["/cam3/image"]),
        ("/**", ["/a", "/a/b/c"], []),
        ("/**/a/**/b", ["/a/b", "/x/a/y/a/z/b"], ["/b/a", "/a"]),
    ],
)
def test_a_pattern_fits_these_names_and_no_others(pattern, fitting, other) -> None:
    assert all(matches_topic(pattern, topic) for topic in fitting)
    assert not any(matches_topic(pattern, topic) for topic in other)


_PARTS = st.lists(st.sampled_from(["a", "b", "scan", "tf"]), min_size=1, max_size=6)


@given(_PARTS, st.data())
def test_a_name_fits_whatever_of_its_parts_are_written_as_any(parts, data) -> None:
    pattern = [data.draw(st.sampled_from([part, "*", "**", part[0] + "*"])) for part in parts]
    assert matches_topic("/" + "/".join(pattern), "/" + "/".join(parts))


def test_a_pattern_made_to_be_slow_is_not() -> None:
    # With backtracking this takes longer than anybody waits.
    assert not matches_topic("/**/a*a*a*" * 30 + "b", "/" + "/".join(["a" * 60] * 60))


def test_the_first_rule_that_fits_counts() -> None:
    rules = (
        TopicRule(pattern="/camera/depth/**", right=TopicRight.ADMIN),
        TopicRule(pattern="/camera/**", right=TopicRight.VIEW, max_rate=5),
    )
    assert rule_of(rules, "/camera/depth/points") is rules[0]
    assert rule_of(rules, "/camera/info") is rules[1]
    assert rule_of(rules, "/odom") is None


@pytest.mark.parametrize(
    ("rule", "said"),
    [
        ("{pattern: scan, right: view}", "is not the pattern of absolute names"),
        ("{pattern: /a**, right: view}", "only a piece of a part"),
        ("{pattern: '/a b', right: view}", "a part that no name has"),
        ("{pattern: /a/, right: view}", "a part that no name has"),
        ("{pattern: /a, right: view, device: cellar}", "device"),
        ("{pattern: /a, right: view, max_rate: -1}", "expected 0 or more"),
        ("{pattern: /a, right: view}, {pattern: /a, right: use}", "a rule before this one"),
    ],
)
def test_a_rule_that_does_not_fit_is_told(rule, said) -> None:
    findings = check_site(load_site(_SITE.format(rules=rule)))
    assert [str(finding) for finding in findings if said in str(finding)]
    assert all(finding.where.startswith("$.topics[") for finding in findings)


def test_rules_are_written_and_read_back() -> None:
    site = load_site(
        _SITE.format(rules="{pattern: /**/tf, right: view}, {pattern: /a, right: tap, max_rate: 5}")
    )
    assert not check_site(site)
    assert load_site(write_description(site)) == site


def test_a_calibration_speaks_of_the_described_pictures_in_its_namespace() -> None:
    site = load_site(
        """
talaia: 1
site: a
name: A
ros2: {}
devices:
  base:
    name: Base
    streams:
      front:
        name: Front
        source: {topic: /front/image_raw/compressed, type: sensor_msgs/msg/CompressedImage}
      rear: {name: Rear, source: {topic: /rear/image_raw, type: sensor_msgs/msg/Image}}
      house: {name: House, source: {topic: /images, type: sensor_msgs/msg/Image}}
"""
    )
    info = "sensor_msgs/msg/CameraInfo"
    assert calibrated_cameras(site, "/front/camera_info", info) == ("base/front",)
    assert calibrated_cameras(site, "/rear/camera_info", info) == ("base/rear",)
    assert calibrated_cameras(site, "/camera_info", info) == ("base/house",)
    assert calibrated_cameras(site, "/rear/sub/camera_info", info) == ()
    assert calibrated_cameras(site, "/rear/odom", "nav_msgs/msg/Odometry") == ()
