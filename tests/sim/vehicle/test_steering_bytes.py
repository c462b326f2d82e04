"""Ackermann's message as a vehicle reads it whose machine has no package of it."""

from __future__ import annotations

import struct

import pytest

from talaia.gateway.adapters.ros2.type_definitions.driving_definitions import DrivingDefinitions
from talaia.gateway.adapters.ros2.type_definitions.message_definition import type_hash
from talaia.gateway.adapters.ros2.type_definitions.message_encoder import MessageEncoder
from talaia.sim.vehicle.drives.steering_bytes import HASH, TYPE, read_steering

pytestmark = pytest.mark.pure


@pytest.mark.parametrize("frame", ["", "a", "base_link", "four"])
def test_speed_and_angle_are_read_behind_a_frame_of_any_length(frame: str) -> None:
    (definition,) = DrivingDefinitions().find(TYPE)
    encoder = MessageEncoder(definition)
    message = encoder.new_message()
    message.header.frame_id = frame
    message.drive.speed, message.drive.steering_angle = -0.5, 0.25
    message.drive.jerk = 9.0
    assert read_steering(encoder.encode_message(message)) == (-0.5, 0.25)


def test_a_machine_that_writes_the_greatest_byte_first_is_read_as_well() -> None:
    raw = b"\x00\x00\x00\x00" + struct.pack(">iII4s5f", 0, 0, 1, b"", 0.25, 0, -0.5, 0, 0)
    assert read_steering(raw) == (-0.5, 0.25)


def test_what_is_cut_off_is_no_command() -> None:
    with pytest.raises(struct.error):
        read_steering(b"\x00\x01\x00\x00" + bytes(20))


def test_the_version_that_it_tells_is_the_one_that_it_reads() -> None:
    (definition,) = DrivingDefinitions().find(TYPE)
    assert type_hash(definition) == HASH
