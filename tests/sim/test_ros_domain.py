"""ROS domains of one's own."""

from __future__ import annotations

import socket
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

import talaia
from talaia.sim.errors import BadDomain, NoFreeDomain
from talaia.sim.ros_domain import FIRST, LAST, domain_environment, fastdds_profile, reserve_domain


def test_two_reservations_differ(tmp_path: Path) -> None:
    with reserve_domain(folder=tmp_path) as one, reserve_domain(folder=tmp_path) as other:
        assert one.domain != other.domain
        assert FIRST <= one.domain <= LAST


def test_a_domain_in_use_is_refused_until_it_is_released(tmp_path: Path) -> None:
    first = reserve_domain(folder=tmp_path)
    with pytest.raises(NoFreeDomain, match="in use"):
        reserve_domain(first.domain, folder=tmp_path)
    first.release()
    reserve_domain(first.domain, folder=tmp_path).release()


def test_another_process_holds_its_domain_until_it_ends(tmp_path: Path) -> None:
    code = (
        "import sys; from pathlib import Path; from talaia.sim.ros_domain import reserve_domain\n"
        f"held = reserve_domain(folder=Path({str(tmp_path)!r}))\n"
        "print(held.domain, flush=True); sys.stdin.read()"
    )
    other = subprocess.Popen(
        [sys.executable, "-c", code],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env={"PYTHONPATH": str(Path(talaia.__file__).parents[1])},
    )
    with other:
        assert other.stdout is not None
        domain = int(other.stdout.readline())
        with pytest.raises(NoFreeDomain):
            reserve_domain(domain, folder=tmp_path)
        other.kill()
    reserve_domain(domain, folder=tmp_path).release()


def test_a_domain_somebody_else_speaks_in_is_not_free(tmp_path: Path) -> None:
    with reserve_domain(folder=tmp_path) as free:
        domain = free.domain
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.bind(("127.0.0.1", 7400 + 250 * domain + 10))
        with pytest.raises(NoFreeDomain):
            reserve_domain(domain, folder=tmp_path)


@pytest.mark.parametrize("domain", [-1, 0, 102, 232])
def test_a_domain_that_is_not_safe_is_refused(domain: int, tmp_path: Path) -> None:
    with pytest.raises(BadDomain, match="from 1 to 101"):
        reserve_domain(domain, folder=tmp_path)
    with pytest.raises(BadDomain):
        domain_environment(domain)


def test_the_environment_keeps_ros_on_this_machine() -> None:
    variables = domain_environment(42)
    assert variables["ROS_DOMAIN_ID"] == "42"
    assert variables["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert variables["FASTDDS_DEFAULT_PROFILES_FILE"] == str(fastdds_profile())


def test_the_profile_has_loopback_only_and_room_for_pictures() -> None:
    tree = ElementTree.parse(fastdds_profile())  # noqa: S314 - our own file
    space = {"dds": "http://www.eprosima.com"}
    addresses = [element.text for element in tree.iterfind(".//dds:address", space)]
    assert addresses == ["127.0.0.1"]
    sizes = [int(e.text or 0) for e in tree.iterfind(".//dds:segment_size", space)]
    assert sizes == [64 * 1024 * 1024]
