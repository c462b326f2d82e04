"""A ROS 1 master and robot of Debian's packages, as the tests see them."""

from __future__ import annotations

import asyncio
import os
import subprocess
import time
import xmlrpc.client
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from gateway_bench import Peer
from patience import PATIENCE_S

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

PYTHON = "/usr/bin/python3"
ROSMASTER = "/usr/bin/rosmaster"
NEEDED = ("rospy", "rosmaster", "actionlib", "nav_msgs", "std_srvs")
HERE = Path(__file__).parent


def need_ros1() -> None:
    """Skip, and say so, where Debian's ROS 1 is not; fail where all must be there."""
    found = [f"/usr/lib/python3/dist-packages/{name}" for name in NEEDED]
    missing = [each for each in (*found, ROSMASTER) if not Path(each).exists()]
    if not missing:
        return
    if os.environ.get("TALAIA_REQUIRE_ALL") == "1":
        pytest.fail(f"ROS 1 is missing ({', '.join(missing)}), and TALAIA_REQUIRE_ALL=1")
    pytest.skip("needs ROS 1: apt install python3-rospy python3-rosmaster")


def environment(port: int, home: Path) -> dict[str, str]:
    """The environment of a ROS 1 process: nothing of our Python, nothing outside ``home``."""
    return {
        "PATH": "/usr/bin:/bin",
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(home),
        "HOME": str(home),
    }


@contextmanager
def master(port: int, home: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A ``rosmaster`` that answers; killed at the end."""
    process = subprocess.Popen(
        [PYTHON, ROSMASTER, "--core", "-p", str(port)],
        env=environment(port, home),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        until = time.monotonic() + PATIENCE_S
        while True:
            try:
                with xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}") as proxy:
                    proxy.getPid("/test")
                break
            except OSError:
                assert process.poll() is None, "rosmaster ended"
                assert time.monotonic() < until, "rosmaster does not answer"
                time.sleep(0.05)
        yield process
    finally:
        process.kill()
        process.wait()


@asynccontextmanager
async def robot(
    port: int, home: Path, name: str = "robot_peer", script: str = "ros1_peer.py"
) -> AsyncIterator[Peer]:
    """The robot; killed at the end, for its master may be gone."""
    process = await asyncio.create_subprocess_exec(
        PYTHON,
        str(HERE / script),
        name,
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        env=environment(port, home),
    )
    one = Peer(process)
    reading = asyncio.ensure_future(one.read())
    try:
        await one.until(lambda: one.heard("ready"))
        yield one
    finally:
        process.kill()
        await process.wait()
        await reading
