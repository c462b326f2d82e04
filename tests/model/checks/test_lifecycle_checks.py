"""What a description may say of life-cycle nodes, and what each mistake is told as."""

from __future__ import annotations

import pytest

from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site

SITE = """
talaia: 1
site: test
name: Test
<connection>
devices:
  lidar:
    name: Lidar
    signals:
      state: {name: State, <signal>, source: {lifecycle: /lidar}}
    commands:
      change: {name: Change, kind: lifecycle, target: /lidar, <command>}
"""
RIGHT = {
    "connection": "ros2: {}",
    "signal": "type: state, states: [unconfigured, inactive, active, finalized]",
    "command": "fixed: {transition: activate}",
}


def findings(**changes: str) -> list[str]:
    text = SITE
    for key, value in {**RIGHT, **changes}.items():
        text = text.replace(f"<{key}>", value)
    return [str(finding) for finding in check_site(load_site(text))]


def test_a_life_cycle_with_its_transition_is_right_and_may_be_a_text_and_an_argument() -> None:
    assert findings() == []
    asked = "arguments: {to: {type: text, field: transition}}"
    assert findings(signal="type: text", command=asked) == []


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"signal": "unit: m"}, "the state of a node is no number"),
        ({"command": "fixed: {transition: start}"}, "'start' is no transition; one of configure,"),
        ({"command": "confirm: true"}, "which transition is meant?; write: fixed: {transition"),
        ({"command": "fixed: {transition: activate, id: 3}"}, "a life cycle has no field 'id'"),
        ({"command": "type: a/srv/B, fixed: {transition: activate}"}, "lifecycle has no type"),
        (
            {"connection": "connections: {one: {kind: ros1}}"},
            "a connection of kind ros1 has no life-cycle nodes",
        ),
    ],
)
def test_a_mistake_says_what_is_expected(changes: dict[str, str], said: str) -> None:
    assert any(said in finding for finding in findings(**changes)), findings(**changes)
