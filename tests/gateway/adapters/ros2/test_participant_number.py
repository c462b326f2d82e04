"""The participant number of a gateway: never one whose port a killed process used just before."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.adapters.ros2.participant_number import (
    NUMBERS,
    ParticipantNumber,
    choose_number,
    data_port,
    discovery_port,
    domain_of,
)
from talaia.sim.ros_domain import domain_environment, reserve_domain

numbers = st.sampled_from(list(NUMBERS))


@given(st.sets(numbers), st.dictionaries(numbers, st.floats(0, 1e10)))
def test_a_number_is_free_and_no_other_free_one_was_left_alone_for_longer(
    free: set[int], used_s: dict[int, float]
) -> None:
    chosen = choose_number(free, used_s)
    if not free:
        assert chosen is None
        return
    assert chosen in free
    unused = free - used_s.keys()
    if unused:
        assert chosen == min(unused)
    else:
        assert used_s[chosen] == min(used_s[number] for number in free)


def test_ports_are_those_of_the_specification() -> None:
    # RTPS 2.5, 9.6.2.4, with the default parameters of 9.6.2.4.3; as ROS 2's own table of domains.
    assert (discovery_port(0, 0), data_port(0, 0)) == (7410, 7411)
    assert (discovery_port(42, 3), data_port(42, 3)) == (17916, 17917)


@pytest.mark.parametrize(
    ("value", "domain"), [(None, 0), ("", 0), ("7", 7), ("-1", None), ("240", None), ("x", None)]
)
def test_a_domain_without_ports_is_left_to_ros(value: str | None, domain: int | None) -> None:
    assert domain_of(value) == domain


def test_a_number_is_not_taken_again_while_older_ones_are_there(tmp_path: Path) -> None:
    with reserve_domain() as reservation:
        domain = reservation.domain
        taken = []
        for _ in range(len(NUMBERS) + 3):
            number = ParticipantNumber(domain, tmp_path)
            with number.held():
                pass
            assert number.chosen is not None
            port = tmp_path / f"fastdds_port{data_port(domain, number.chosen)}"
            port.touch()
            os.utime(port, (len(taken) + 1, len(taken) + 1))
            taken.append(number.chosen)
    assert taken == [*NUMBERS, 0, 1, 2]


def test_a_number_of_somebody_who_lives_is_left_to_him_and_lower_ones_are_held(
    tmp_path: Path,
) -> None:
    with reserve_domain() as reservation, contextlib.ExitStack() as others:
        domain = reservation.domain
        neighbour = others.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        neighbour.bind(("127.0.0.1", discovery_port(domain, 1)))
        (tmp_path / f"fastdds_port{data_port(domain, 0)}").touch()
        number = ParticipantNumber(domain, tmp_path)
        with number.held():
            assert number.chosen == 2
            assert not _is_free(discovery_port(domain, 0))
            assert _is_free(discovery_port(domain, 2))
        assert _is_free(discovery_port(domain, 0))


def test_another_dds_is_left_alone(tmp_path: Path) -> None:
    number = ParticipantNumber(None, tmp_path)
    with number.held():
        assert number.chosen is None
    number.mark_used()


JOIN = """
import asyncio, os, sys
import ros_wheels_bootstrapper
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from talaia.gateway.adapters.ros2.participant_number import ParticipantNumber
number = ParticipantNumber(int(os.environ["ROS_DOMAIN_ID"]))
context = Context()
with number.held():
    rclpy.init(context=context)
    node = Node("gateway", context=context)
print(number.chosen, flush=True)
sys.stdin.read()
"""


@pytest.mark.robot
def test_a_gateway_after_a_killed_one_is_another_participant(ros_domain: int) -> None:
    seen = []
    for _ in range(2):
        process = subprocess.Popen(
            [sys.executable, "-c", JOIN],
            env={**os.environ, **domain_environment(ros_domain)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert process.stdout is not None
        chosen = int(process.stdout.readline())
        # It is ROS that has the port, not only our own opinion of it.
        assert not _is_free(discovery_port(ros_domain, chosen))
        assert not _is_free(data_port(ros_domain, chosen))
        process.kill()
        process.communicate()
        seen.append(chosen)
    assert seen[0] != seen[1]


def _is_free(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", port))
        except OSError:
            return False
        return True
