"""Definitions that a publisher tells: read as data, whatever they hold."""

from __future__ import annotations

import sys

import pytest

from talaia.gateway.adapters.ros1.decode import decoder_of
from talaia.gateway.errors import FieldError

pytestmark = pytest.mark.pure

# rosbags writes a class of this name and runs what it wrote.
SOURCE = "a/msg/B:\n    x: int\nimport sys\nsys.forged_type = True\nclass C"


def test_name_of_a_publishers_type_that_is_source_code_is_run_nowhere() -> None:
    with pytest.raises(FieldError, match="no name of a type"):
        decoder_of(SOURCE, "float64 x")
    assert not hasattr(sys, "forged_type")


def test_list_of_things_that_take_no_bytes_is_not_read_for_hours() -> None:
    hostile = f"robot_msgs/Nothing[] many\n{'=' * 80}\nMSG: robot_msgs/Nothing\n"
    with pytest.raises(FieldError, match="takes no bytes"):
        decoder_of("robot_msgs/msg/Thing", hostile)


def test_type_of_a_robots_own_is_read_as_before() -> None:
    read = decoder_of("robot_msgs/msg/Thing", "int8 x\n")
    assert read(b"\xfb").x == -5
    with pytest.raises(FieldError):
        read(b"")
