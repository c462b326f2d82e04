"""Missions as files, and what does not fit in one."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st
from msgspec.structs import replace

from talaia.model.errors import DescriptionError
from talaia.model.missions.mission import (
    DAYS,
    Mission,
    MissionSchedule,
    MissionStep,
    StepKind,
)
from talaia.model.missions.mission_checks import site_findings, with_units
from talaia.model.missions.mission_file import (
    dump_mission,
    load_mission,
    read_mission_json,
    write_mission_json,
)
from talaia.model.site import Argument, ArgumentType, Command, Device, Site

PAUSE = MissionStep(kind=StepKind.PAUSE, seconds=1)
GOTO = MissionStep(kind=StepKind.COMMAND, device="base", command="turn", args={"angle": 90})
TEXT = """
mission: 1
name: Patrol
steps:
  - {kind: command, device: base, command: turn, args: {angle: 90}}
  - {kind: until, condition: '{base/charge} > 50', seconds: 60}
  - {kind: pause, seconds: 5}
schedule: {at: "06:00", days: [mon, fri]}
"""


def site(unit: str = "deg") -> Site:
    angle = Argument(type=ArgumentType.NUMBER, field="a", unit=unit, maximum=180)
    turn = Command(name="Turn", target="/turn", arguments={"angle": angle})
    device = Device(name="Base", kind="vehicle", commands={"turn": turn})
    return Site(talaia=1, site="agv", name="AGV", devices={"base": device})


def test_file_of_a_mission_is_read_and_written_back_the_same() -> None:
    mission = load_mission(TEXT)
    assert [step.kind for step in mission.steps] == ["command", "until", "pause"]
    assert load_mission(dump_mission(mission)) == mission


@given(
    name=st.text("abc Ñ:#'\"", min_size=1, max_size=20).filter(lambda text: text.strip() == text),
    seconds=st.floats(0.1, 86_400),
    args=st.dictionaries(
        st.text("abc", min_size=1, max_size=5),
        st.one_of(st.booleans(), st.integers(-9, 9), st.floats(-5, 5), st.text("x: #", max_size=5)),
        max_size=3,
    ),
    days=st.lists(st.sampled_from(DAYS), unique=True),
)
def test_every_mission_survives_its_file_and_its_row(name, seconds, args, days) -> None:
    mission = Mission(
        name=name,
        steps=(replace(GOTO, args=args), replace(PAUSE, seconds=seconds)),
        schedule=MissionSchedule(at="00:00", days=tuple(days)),
    )
    assert load_mission(dump_mission(mission)) == mission
    assert read_mission_json(write_mission_json(mission)) == mission


@pytest.mark.parametrize(
    ("written", "where"),
    [
        ("board: 1\nname: x\n", "$.mission"),
        ("mission: 1\nname: x\n", "$.steps"),
        ("mission: 1\nname: x\nsteps: [{kind: jump}]\n", "$.steps[0].kind"),
        ("mission: 1\nname: x\nsteps: [{kind: pause}]\n", "$.steps[0].seconds"),
        ("mission: 1\nname: x\nsteps: [{kind: pause, seconds: .nan}]\n", "$.steps[0].seconds"),
        ("mission: 1\nname: x\nsteps: [{kind: until}]\n", "$.steps[0].condition"),
        ("mission: 1\nname: x\nsteps: [{kind: command, device: a}]\n", "$.steps[0]"),
        (
            "mission: 1\nname: x\nsteps: [{kind: pause, seconds: 1, device: a}]\n",
            "$.steps[0].device",
        ),
        (
            "mission: 1\nname: x\nsteps: [{kind: pause, seconds: 1}]\nschedule: {at: '25:00'}\n",
            "$.schedule.at",
        ),
        (
            "mission: 1\nname: x\nsteps: [{kind: pause, seconds: 1}]\n"
            "schedule: {at: '06:00', days: [someday]}\n",
            "$.schedule.days",
        ),
    ],
)
def test_mistake_is_told_with_its_place(written, where) -> None:
    with pytest.raises(DescriptionError) as caught:
        load_mission(written)
    assert caught.value.where == where


def places(mission: Mission, at: Site) -> list[str]:
    return [finding.where for finding in site_findings(mission, at)]


def test_what_the_site_does_not_have_or_would_refuse_is_found() -> None:
    steps = (
        replace(GOTO, device="arm"),
        replace(GOTO, command="jump"),
        replace(GOTO, args={"angle": 999}),
        MissionStep(kind=StepKind.UNTIL, condition="{base/none} > 1"),
        GOTO,
    )
    assert places(Mission(name="m", steps=steps), site()) == [
        "$.steps[0].device",
        "$.steps[1].command",
        "$.steps[2].args",
        "$.steps[3].condition",
    ]


def test_command_written_in_degrees_is_not_sent_as_radians() -> None:
    noted = with_units(Mission(name="m", steps=(GOTO,)), site("deg"))
    assert noted.steps[0].units == {"angle": "deg"}
    assert places(noted, site("deg")) == []
    assert places(noted, site("rad")) == ["$.steps[0].units"]
    # What was meant stays meant: to save it anew by another description does not change that.
    assert with_units(noted, site("rad")).steps[0].units == {"angle": "deg"}
