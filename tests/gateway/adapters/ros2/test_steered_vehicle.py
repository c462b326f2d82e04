"""The simulated vehicle with steered wheels, driven by a gateway where no package is installed."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from contextlib import asynccontextmanager
from itertools import count
from typing import TYPE_CHECKING

import pytest
from fake_hub import fake_hub
from gateway_bench import addresses_of, running, take_lease
from patience import PATIENCE_S

from talaia.sim.ros_domain import domain_environment
from talaia.wire.frames import DriveFrame, LeaseOp, LeaseRequest

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

pytestmark = pytest.mark.robot
# Without the key `definitions`: what a message that drives holds a gateway knows itself.
SITE = """
talaia: 1
site: test
name: Steered wheels
ros2: {node: gateway_under_test}
devices:
  car:
    name: Car
    signals:
      speed:
        name: Speed
        unit: m/s
        source: {topic: /odom, type: nav_msgs/msg/Odometry, field: twist.twist.linear.x}
    drive:
      topic: /ackermann_cmd
      message: ackermann_msgs/msg/AckermannDriveStamped
      max_speed: 0.2
      max_steering: 0.3
      max_steering_speed: 5
      stop: {topic: /stop, confirmed_by: [car/speed]}
"""
SEQ = count()


@asynccontextmanager
async def vehicle(domain: int, log: Path) -> AsyncIterator[None]:
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "talaia", "sim", "vehicle", "--drive", "ackermann"),
        *("--no-camera", "--domain", str(domain), "--log", str(log)),
        stdout=asyncio.subprocess.PIPE,
        env={
            **os.environ, **domain_environment(domain), "PYTHONPATH": os.pathsep.join(sys.path)
        },
    )  # fmt: skip
    try:
        async with asyncio.timeout(PATIENCE_S):
            assert json.loads(await process.stdout.readline())["ready"]
        yield
    finally:
        process.terminate()
        await process.wait()


async def actuation(log: Path, fits: object) -> dict:
    """Wait for a line of what the vehicle took as its wanted velocity."""
    try:
        async with asyncio.timeout(PATIENCE_S):
            while True:
                rows = [json.loads(line) for line in log.read_text().splitlines()]
                for row in rows:
                    if fits(row):
                        return row
                # A file tells nobody that it grew.
                await asyncio.sleep(0.05)  # noqa: ASYNC110
    except TimeoutError:
        raise AssertionError(f"no such line: {rows[-5:]}") from None


async def test_a_gateway_steers_the_simulated_vehicle_and_stop_lets_it_stand(
    ros_domain: int, tmp_path: Path
) -> None:
    log = tmp_path / "actuations.jsonl"
    async with (
        vehicle(ros_domain, log),
        fake_hub(addresses_of) as hub,
        running(hub.url, tmp_path, SITE),
    ):
        await hub.until(lambda: hub.hellos, "a hello")
        epoch = await take_lease(hub, "car")

        async def hold() -> None:
            while True:
                await hub.send(
                    LeaseRequest(device="car", session="tab", who="Ada", op=LeaseOp.RENEW)
                )
                await hub.send(
                    DriveFrame(
                        device="car", session="tab", epoch=epoch, seq=next(SEQ), tick=hub.tick,
                        linear=0.15, angular=0.0, steering=0.2,
                    )
                )  # fmt: skip
                await asyncio.sleep(0.05)

        holding = asyncio.ensure_future(hold())
        steered = await actuation(log, lambda row: row["v"] > 0.14)
        holding.cancel()
        await asyncio.gather(holding, return_exceptions=True)
        # It turns as wheels at that angle do, and the speed is the one that was asked for.
        assert steered["source"] == "ackermann_cmd"
        assert steered["v"] == pytest.approx(0.15, abs=0.005)
        assert steered["w"] > 0.1
        after = steered["monotonic_ns"]
        await actuation(log, lambda row: row["monotonic_ns"] > after and row["v"] == 0)
