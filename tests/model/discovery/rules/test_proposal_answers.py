"""What a robot's owner says to a proposal, and the description that comes of it."""

import pytest
from described_robot import found_of, read_robot

from talaia.model.discovery.generate_description import DescriptionProposal, propose_description
from talaia.model.discovery.probe_report import Found
from talaia.model.discovery.rules.proposal_answers import (
    ProposalAnswers,
    answered_proposal,
    answers_problems,
)
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.write import write_description

pytestmark = pytest.mark.pure
NAMED = ("robot", "Robot", "UTC")


def robot(name: str) -> Found:
    return found_of(read_robot("chosen", name))


def said(which: str, **answers: object) -> DescriptionProposal:
    return answered_proposal(robot(which), NAMED, ProposalAnswers(**answers))


@pytest.mark.parametrize("name", ["mecanum", "ur5e", "turtlebot4"])
def test_no_answers_change_nothing(name: str) -> None:
    assert said(name) == propose_description(robot(name), *NAMED)


def test_what_is_not_wanted_is_gone_and_named_with_that_reason() -> None:
    made = said("mecanum", unwanted=frozenset({"power", "base/signals/speed", "base/drive"}))
    assert "power" not in made.site.devices
    assert "speed" not in made.site.devices["base"].signals
    assert made.site.devices["base"].drive is None
    assert {"power: not wanted", "base/signals/speed: not wanted", "base/drive: not wanted"} <= set(
        made.left_out
    )
    assert answers_problems(made) == []


def test_names_and_units_are_those_that_were_written() -> None:
    made = said(
        "mecanum",
        name="Forklift 3",
        names={"base": "Chassis", "base/signals/speed": "Ground speed"},
        units={"base/signals/speed": "km/h"},
    )
    speed = made.site.devices["base"].signals["speed"]
    assert (made.site.name, made.site.devices["base"].name) == ("Forklift 3", "Chassis")
    assert (speed.name, speed.unit) == ("Ground speed", "km/h")
    assert load_site(write_description(made.site, [])) == made.site


def test_a_name_that_cannot_be_is_told_and_so_nothing_has_to_be_written() -> None:
    (problem,) = answers_problems(said("mecanum", names={"base": " "}))
    assert "devices.base.name" in problem


def test_stop_goes_by_what_was_said_and_never_by_a_signal_that_is_not_wanted() -> None:
    answers = {"stop_topic": "/e_stop", "confirmed_by": ("base/speed", "base/turn_rate")}
    drive = said("mecanum", **answers).site.devices["base"].drive
    assert drive is not None
    assert (drive.stop.topic, drive.stop.confirmed_by) == ("/e_stop", answers["confirmed_by"])
    without = frozenset({"base/signals/speed"})
    drive = said("mecanum", unwanted=without, **answers).site.devices["base"].drive
    assert drive is not None
    assert drive.stop.confirmed_by == ("base/turn_rate",)


def test_a_joint_whose_position_is_not_wanted_has_no_ends_to_go_by() -> None:
    made = said("ur5e", unwanted=frozenset({"joints/signals/elbow_position"}))
    drive = made.site.devices["joints"].drive
    assert drive is not None
    elbow, wrist = drive.joints["elbow_joint"], drive.joints["wrist_1_joint"]
    assert (elbow.position, elbow.minimum, elbow.maximum) == ("", None, None)
    assert wrist.position == "joints/wrist_1_position"
    assert answers_problems(made) == []


def test_an_answer_to_what_is_not_there_has_no_effect() -> None:
    answers = {
        "names": {"nobody/signals/x": "X"},
        "stop_topic": "/nobody",
        "confirmed_by": ("a/b",),
    }
    assert said("mecanum", **answers) == said("mecanum")
