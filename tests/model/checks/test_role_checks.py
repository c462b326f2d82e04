"""A role that does not fit is named, with its place and what was expected."""

from __future__ import annotations

import pytest

from talaia.model.checks.site_checks import check_site
from talaia.model.errors import DescriptionError
from talaia.model.yaml_text.load import load_site

SITE = """\
talaia: 1
site: a
name: A
ros2: {{}}
devices:
  dome:
    name: Dome
    kind: dome
    signals:
      first: {{name: First, {signal}, source: {{topic: /t, type: a/msg/B, field: c}}}}
      second: {{name: Second, {other}, source: {{topic: /t, type: a/msg/B, field: c}}}}
    commands:
      act: {{name: Act, target: /t, type: std_srvs/srv/Trigger, {command}}}
"""


def findings(signal: str = "unit: m", other: str = "unit: m", command: str = "ttl: 1") -> list[str]:
    return [
        str(found)
        for found in check_site(load_site(SITE.format(signal=signal, other=other, command=command)))
    ]


SHUTTER = "type: state, states: [a, b], role: dome.shutter"


def test_roles_that_fit_are_silent() -> None:
    assert findings(SHUTTER, "unit: °, role: dome.azimuth", "role: dome.open") == []
    outlet = 'type: state, states: ["off", "on"], role: power.outlet'
    assert findings(outlet, outlet, "role: none") == []
    assert findings("role: auto", "role: none", "role: auto") == []


def test_a_word_that_is_no_role_is_told_with_the_nearest() -> None:
    with pytest.raises(DescriptionError) as told:
        findings("unit: °, role: dome.azimut")
    assert str(told.value) == (
        "$.devices.dome.signals.first.role: unknown role 'dome.azimut'; "
        "did you mean 'dome.azimuth'?"
    )


@pytest.mark.parametrize(
    ("signal", "said"),
    [
        (
            "unit: °, role: dome.shutter",
            "$.devices.dome.signals.first.role: dome.shutter stands on a signal of type state, "
            "found number; write: type: state",
        ),
        (
            "unit: m, role: dome.azimuth",
            "$.devices.dome.signals.first.role: dome.azimuth is in °, found m; write: unit: °",
        ),
        (
            "role: weather.wind",
            "$.devices.dome.signals.first.role: weather.wind is in km/h or m/s, found no unit; "
            "write: unit: km/h",
        ),
        (
            "type: state, states: [a, b, c], role: power.outlet",
            "$.devices.dome.signals.first.role: power.outlet has 2 states, off and on, found 3; "
            "leave the role out",
        ),
        (
            SHUTTER + ", meanings: [open]",
            "$.devices.dome.signals.first.meanings: expected one for each of the 2 states, found 1",
        ),
        (
            SHUTTER + ", meanings: [open, exposing]",
            "$.devices.dome.signals.first.meanings[1]: no state of dome.shutter means 'exposing'; "
            "one of: closed, open, opening, closing, partial, error, unknown",
        ),
        (
            "type: state, states: [a], meanings: [open]",
            "$.devices.dome.signals.first.meanings[0]: no state of a signal without a role means "
            "'open'; one of: normal, warning, error, unknown; or write the role: dome.shutter",
        ),
        (
            "unit: V, meanings: [normal]",
            "$.devices.dome.signals.first.meanings: states have meanings, found type number; "
            "leave them out",
        ),
    ],
)
def test_a_role_stands_on_what_it_can_be(signal: str, said: str) -> None:
    assert findings(signal) == [said]


def test_a_device_has_one_signal_of_a_role() -> None:
    assert findings(SHUTTER, SHUTTER) == [
        "$.devices.dome.signals.second.role: 'first' of this device is its dome.shutter already; "
        "a device has one of each role: leave one out"
    ]


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (
            "role: dome.open, arguments: {much: {type: number, field: a}}",
            "dome.open asks for no argument without a default; its arguments: much",
        ),
        (
            "role: dome.goto",
            "dome.goto asks for one argument, a number in °; its arguments: none",
        ),
        (
            "role: power.switch, arguments: {active: {type: number, field: a}}",
            "power.switch asks for one argument, a boolean; its arguments: active",
        ),
        (
            "role: camera.expose",
            "camera.expose asks for an argument with the unit s; its arguments: none",
        ),
        (
            "role: telescope.goto, arguments: {ra: {type: number, field: a}}",
            "telescope.goto asks for two numbers: right ascension, then declination; "
            "its arguments: ra",
        ),
    ],
)
def test_a_commands_role_stands_on_what_asks_for_it(command: str, said: str) -> None:
    at = "$.devices.dome.commands.act.role: "
    remedy = "; change the arguments, or write: role: none"
    assert findings(command=command) == [at + said + remedy]


def test_a_command_whose_arguments_have_defaults_is_a_button() -> None:
    assert (
        findings(command='role: dome.open, arguments: {p: {type: text, field: p, default: ""}}')
        == []
    )


POSE = "x: {type: number, field: x}, y: {type: number, field: y}, "
FRAME = "frame: {type: text, field: f}, "


@pytest.mark.parametrize(
    ("arguments", "fits"),
    [
        (POSE + FRAME + "yaw: {type: number, unit: rad, field: a}", True),
        (POSE + FRAME + "qz: {type: number, field: a}, qw: {type: number, field: b}", True),
        # Which way, and in which frame, is not left open; a scene knows nothing else.
        (POSE + FRAME + "qz: {type: number, field: a}", False),
        (POSE + FRAME + "yaw: {type: number, field: a}", False),
        (POSE + "yaw: {type: number, unit: °, field: a}", False),
        (POSE + "frame: {type: number, field: f}, yaw: {type: number, unit: °, field: a}", False),
        (POSE + FRAME + "yaw: {type: number, unit: °, field: a}, p: {type: text, field: p}", False),
    ],
)
def test_a_goal_asks_for_a_place_a_frame_and_a_heading(arguments: str, *, fits: bool) -> None:
    found = findings(command=f"role: vehicle.goal, arguments: {{{arguments}}}")
    assert [" asks for numbers x and y (m), a text frame" in said for said in found] == (
        [] if fits else [True]
    )
