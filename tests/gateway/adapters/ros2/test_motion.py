"""Driving sideways, by steered wheels and by joints, as an rclpy of its own hears it."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from contextlib import asynccontextmanager
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from fake_hub import fake_hub
from gateway_bench import addresses_of, running, take_lease
from patience import PATIENCE_S

from talaia.sim.ros_domain import domain_environment
from talaia.wire.frames import DriveFrame, LeaseOp, LeaseRequest

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

pytestmark = pytest.mark.robot
TYPE = "ackermann_msgs/msg/AckermannDriveStamped"
SITE = """
talaia: 1
site: test
name: Three ways to drive
ros2: {{node: gateway_under_test, definitions: {definitions}}}
devices:
  base:
    name: Base
    drive: {{topic: /cmd_vel, max_speed: 0.5, max_sideways: 0.2, max_turn: 1}}
  car:
    name: Car
    drive:
      topic: /steer
      message: ackermann_msgs/msg/AckermannDriveStamped
      max_speed: 1
      max_steering: 0.3
      max_steering_speed: 5
  arm:
    name: Arm
    drive:
      topic: /jog
      message: std_msgs/msg/Float64MultiArray
      joints: {{shoulder: {{max_speed: 0.2}}, elbow: {{max_speed: 0.1}}}}
"""
SEQ = count()


def definitions_in(folder: Path) -> Path:
    """Write the messages as their package has them."""
    messages = folder / "ackermann_msgs" / "msg"
    messages.mkdir(parents=True)
    parts = ("steering_angle", "steering_angle_velocity", "speed", "acceleration", "jerk")
    (messages / "AckermannDrive.msg").write_text("".join(f"float32 {name}\n" for name in parts))
    (messages / "AckermannDriveStamped.msg").write_text(
        "std_msgs/Header header\nAckermannDrive drive\n"
    )
    return folder


class Heard:
    """What the robot said that it heard."""

    def __init__(self) -> None:  # noqa: D107
        self.rows: list[dict] = []
        self.changed = asyncio.Event()

    async def until(self, wanted: str, fits: object = lambda _: True) -> list:
        """Wait for a row of a kind that fits."""
        try:
            async with asyncio.timeout(PATIENCE_S):
                while True:
                    for row in self.rows:
                        if wanted in row and fits(row[wanted]):
                            return row[wanted]
                    self.changed.clear()
                    await self.changed.wait()
        except TimeoutError:
            raise AssertionError(f"{wanted} was heard as {self.rows[-5:]}") from None


@asynccontextmanager
async def robot(domain: int, type_hash: str) -> AsyncIterator[Heard]:
    environment = {
        **os.environ, **domain_environment(domain), "PYTHONPATH": os.pathsep.join(sys.path)
    }  # fmt: skip
    peer = await asyncio.create_subprocess_exec(
        sys.executable, str(Path(__file__).with_name("drive_peer.py")), type_hash,
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, env=environment,
    )  # fmt: skip
    heard = Heard()

    async def read() -> None:
        while line := await peer.stdout.readline():
            heard.rows.append(json.loads(line))
            heard.changed.set()

    reading = asyncio.ensure_future(read())
    try:
        await heard.until("ready")
        yield heard
    finally:
        peer.kill()
        await peer.wait()
        await reading


async def test_a_robot_hears_sideways_steered_wheels_and_joints_and_then_zeros(
    ros_domain: int, tmp_path: Path
) -> None:
    from talaia.gateway.adapters.ros2.type_definitions.definition_finder import DefinitionFinder
    from talaia.gateway.adapters.ros2.type_definitions.message_definition import type_hash

    definitions = definitions_in(tmp_path / "ws")
    # The workspace has no std_msgs: its header is that of the installed package.
    found = DefinitionFinder(definitions).find(TYPE, "", "/steer")
    text = SITE.format(definitions=definitions)
    async with (
        robot(ros_domain, type_hash(found)) as heard,
        fake_hub(addresses_of) as hub,
        running(hub.url, tmp_path, text),
    ):
        await hub.until(lambda: hub.hellos, "a hello")
        ways = {
            "base": ("twist", {"linear": 0.5, "lateral": 0.2}),
            "car": ("steered", {"linear": 0.4, "steering": 9.0}),
            "arm": ("joints", {"joints": [0.2, -9.0]}),
        }
        for device, (kind, wanted) in ways.items():
            epoch = await take_lease(hub, device)

            async def hold(device: str = device, epoch: int = epoch, wanted: dict = wanted) -> None:
                while True:
                    renewal = LeaseRequest(
                        device=device, session="tab", who="Ada", op=LeaseOp.RENEW
                    )
                    await hub.send(renewal)
                    values = {"linear": 0.0, "angular": 0.0, **wanted}
                    await hub.send(
                        DriveFrame(
                            device=device, session="tab", epoch=epoch, seq=next(SEQ),
                            tick=hub.tick, **values,
                        )
                    )  # fmt: skip
                    await asyncio.sleep(0.05)

            holding = asyncio.ensure_future(hold())
            full = {
                # Aslant at both limits: each is 1/√2 of its own.
                "twist": lambda row: row[0] > 0.35 and row[1] > 0.14,
                "steered": lambda row: row[2] > 0.39 and row[0] > 0.29,
                "joints": lambda row: row[0] > 0.19 and row[1] < -0.09,
            }[kind]
            top = await heard.until(kind, full)
            holding.cancel()
            await asyncio.gather(holding, return_exceptions=True)
            still = {
                "twist": lambda row: row == [0.0] * 6,
                # No speed, and the wheels as they stood; the stamp is 0.
                "steered": lambda row: row[2] == 0.0 and row[0] > 0.29 and row[5:] == [0, 0],
                "joints": lambda row: row == [0.0, 0.0],
            }[kind]
            await heard.until(kind, still)
            assert max(map(abs, top[:5])) <= 0.41
            rows = [row[kind] for row in heard.rows if kind in row]
            if kind == "twist":
                assert all((row[0] / 0.5) ** 2 + (row[1] / 0.2) ** 2 <= 1 + 1e-9 for row in rows)
            elif kind == "steered":
                assert max(row[0] for row in rows) <= 0.3 + 1e-6
            else:
                assert min(row[1] for row in rows) >= -0.1 - 1e-9
