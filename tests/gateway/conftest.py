"""What the gateway's tests share: a robot peer in a ROS domain of its own."""

from __future__ import annotations

import asyncio
import importlib
import importlib.util
import os
import sys
import warnings
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from async_program import start_program
from patience import PATIENCE_S

from talaia.sim.ros_domain import reserve_domain

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # test modules are imported by path; their shared parts by name

from gateway_bench import Peer  # noqa: E402

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator


@pytest.fixture(scope="session")
def own_domain() -> Iterator[int]:
    """A domain that nobody else on this machine reserves while the tests run."""
    if given := os.environ.get("TALAIA_TEST_DOMAIN"):
        # That of a rosbridge which runs already.
        yield int(given)
        return
    with reserve_domain() as reservation:
        yield reservation.domain


@pytest.fixture(scope="session")
def other_domain() -> Iterator[int]:
    """Another domain; see `own_domain`."""
    with reserve_domain() as reservation:
        yield reservation.domain


@pytest.fixture
def ros_domain(own_domain: int, monkeypatch: pytest.MonkeyPatch) -> int:
    """The tests' domain; skips, and says so, where there is no ROS 2."""
    if importlib.util.find_spec("rclpy") is None:
        if os.environ.get("TALAIA_REQUIRE_ALL") == "1":
            pytest.fail("ROS 2 (rclpy) is missing, and TALAIA_REQUIRE_ALL=1")
        pytest.skip("needs ROS 2: install talaia[ros2] or source a ROS installation")
    # A parser that ROS brings along is older than the Python it runs on; not ours to fail for.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        for name in ("rclpy.node", "lark"):
            importlib.import_module(name)
    monkeypatch.setenv("ROS_DOMAIN_ID", str(own_domain))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    return own_domain


@pytest.fixture
async def other_peer(ros_domain: int, other_domain: int) -> AsyncIterator[Peer]:
    """Another robot, in another domain."""
    async with peer_in(other_domain) as one:
        yield one


@pytest.fixture
async def peer(ros_domain: int) -> AsyncIterator[Peer]:
    async with peer_in(ros_domain) as one:
        yield one


@asynccontextmanager
async def peer_in(domain: int, script: Path = HERE / "robot_peer.py") -> AsyncIterator[Peer]:
    process = await start_program(str(script), ROS_DOMAIN_ID=str(domain))
    one = Peer(process)
    reading = asyncio.ensure_future(one.read())
    try:
        await one.until(lambda: one.heard("ready"))
        yield one
    finally:
        # Also when the test failed: what is left open is found in the middle of a later one.
        assert process.stdin is not None
        process.stdin.close()
        await asyncio.wait_for(process.wait(), PATIENCE_S)
        await reading
