"""Requests to ROS services: fields by path, and what an answer means."""

from __future__ import annotations

from types import SimpleNamespace as Message

import pytest

from talaia.gateway.adapters.ros2.requests import fill, outcome_of
from talaia.gateway.errors import FieldError
from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase


def test_request_fields_are_set_by_path_in_the_types_they_have() -> None:
    request = Message(to=Message(alt=0.0), steps=0, quick=False, note="", list=[0, 0])
    fill(request, {"to.alt": 4, "steps": 3.0, "quick": True, "note": "x", "list[1]": 7})
    assert request == Message(to=Message(alt=4.0), steps=3, quick=True, note="x", list=[0, 7])
    assert isinstance(request.to.alt, float)


@pytest.mark.parametrize(
    "fields",
    [{"nowhere": 1}, {"steps": 1.5}, {"steps": "x"}, {"quick": 1}, {"list[9]": 1}, {"to..alt": 1}],
)
def test_field_that_does_not_fit_is_refused(fields: dict) -> None:
    request = Message(to=Message(alt=0.0), steps=0, quick=False, list=[0])
    with pytest.raises(FieldError):
        fill(request, fields)


def test_robots_own_no_is_a_failure_with_its_words() -> None:
    assert outcome_of(Message(success=False, message="stuck")) == CommandOutcome(
        CommandPhase.FAILED, "stuck"
    )
    assert outcome_of(Message(success=True, message="ok")) == CommandOutcome(
        CommandPhase.SUCCEEDED, "ok"
    )
    assert outcome_of(Message(result=3)) == CommandOutcome(CommandPhase.SUCCEEDED, "")


@pytest.mark.robot
def test_lists_in_a_request_grow_to_what_is_filled_in_and_its_answer_is_read() -> None:
    srv = pytest.importorskip("rcl_interfaces.srv")
    request = srv.SetParametersAtomically.Request()
    fields = {
        "parameters[0].name": "ra",
        "parameters[0].value.type": 3,
        "parameters[0].value.double_value": 5.5,
        "parameters[2].name": "dec",
    }
    fill(request, fields)
    assert [each.name for each in request.parameters] == ["ra", "", "dec"]
    assert request.parameters[0].value.double_value == 5.5
    with pytest.raises(FieldError):
        fill(request, {"parameters[64].name": "too far"})
    with pytest.raises(FieldError):
        fill(request, {"nothing[0].name": "x"})
    response = srv.SetParametersAtomically.Response()
    response.result.successful, response.result.reason = False, "below the horizon"
    assert outcome_of(response) == CommandOutcome(CommandPhase.FAILED, "below the horizon")
    response.result.successful = True
    assert outcome_of(response).phase is CommandPhase.SUCCEEDED


@pytest.mark.robot
def test_a_trajectory_grows_its_names_and_places_to_what_is_filled_in() -> None:
    kind = pytest.importorskip("trajectory_msgs.msg").JointTrajectory
    message = kind()
    fields = {
        "joint_names[0]": "elbow",
        "joint_names[1]": "wrist",
        "points[0].positions[0]": 0.5,
        "points[0].positions[1]": -1,
        "points[0].time_from_start.sec": 8,
    }
    fill(message, fields)
    assert message.joint_names == ["elbow", "wrist"]
    assert list(message.points[0].positions) == [0.5, -1.0]
    assert message.points[0].time_from_start.sec == 8
    with pytest.raises(FieldError):
        fill(message, {"points[0].positions[64]": 1.0})
    # The bytes that would be sent hold all of it.
    serialization = pytest.importorskip("rclpy.serialization")
    sent = serialization.deserialize_message(serialization.serialize_message(message), kind)
    assert list(sent.points[0].positions) == [0.5, -1.0]
