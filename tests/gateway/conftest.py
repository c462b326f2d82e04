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
from patience import PATIENCE_S

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # test modules are imported by path; their shared parts by name

from gateway_bench import Peer  # noqa: E402

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


@pytest.fixture
def ros_domain(monkeypatch: pytest.MonkeyPatch) -> int:
    """A domain for one test alone; skips, and says so, where there is no ROS 2."""
    if importlib.util.find_spec("rclpy") is None:
        if os.environ.get("TALAIA_REQUIRE_ALL") == "1":
            pytest.fail("ROS 2 (rclpy) is missing, and TALAIA_REQUIRE_ALL=1")
        pytest.skip("needs ROS 2: install talaia[ros2] or source a ROS installation")
    # A parser that ROS brings along is older than the Python it runs on; not ours to fail for.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        for name in ("rclpy.node", "lark"):
            importlib.import_module(name)
    # Beyond 101 the ports of a domain may lie in the range that Linux gives to clients.
    domain = int(os.environ.get("TALAIA_TEST_DOMAIN") or 1 + os.getpid() % 100)
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    return domain


@pytest.fixture
async def other_peer(ros_domain: int) -> AsyncIterator[Peer]:
    """Another robot, in another domain."""
    async with peer_in(other_domain(ros_domain)) as one:
        yield one


def other_domain(domain: int) -> int:
    return domain % 100 + 1


@pytest.fixture
async def peer(ros_domain: int) -> AsyncIterator[Peer]:
    async with peer_in(ros_domain) as one:
        yield one


@asynccontextmanager
async def peer_in(domain: int) -> AsyncIterator[Peer]:
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        str(HERE / "robot_peer.py"),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        env={**os.environ, "ROS_DOMAIN_ID": str(domain)},
    )
    one = Peer(process)
    reading = asyncio.ensure_future(one.read())
    await one.until(lambda: one.heard("ready"))
    yield one
    assert process.stdin is not None
    process.stdin.close()
    await asyncio.wait_for(process.wait(), PATIENCE_S)
    await reading
