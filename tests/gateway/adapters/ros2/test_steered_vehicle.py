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


async def test_a_gateway_steers_the_simulated_vehicle_which_stands_when_nobody_holds_on(
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
        await hub.until(lambda: max(hub.values("car/speed"), default=0) > 0.1, "that it drives")
        holding.cancel()
        await asyncio.gather(holding, return_exceptions=True)
        driven = len(hub.values("car/speed"))
        await hub.until(
            lambda: any(abs(speed) < 0.01 for speed in hub.values("car/speed")[driven:]),
            "that it stands",
        )
        rows = [json.loads(line) for line in (await asyncio.to_thread(log.read_text)).splitlines()]
    # It turns as wheels at that angle do, and the speed is the one that was asked for.
    steered = max(rows, key=lambda row: row["v"])
    assert steered["source"] == "ackermann_cmd"
    assert steered["v"] == pytest.approx(0.15, abs=0.005)
    assert steered["steering"] == pytest.approx(0.2, abs=0.01)
    assert steered["w"] > 0.1
    assert rows[-1]["v"] == 0
