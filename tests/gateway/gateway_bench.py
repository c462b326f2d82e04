"""A robot process and a gateway with a fake hub, as the tests see them."""

from __future__ import annotations

import asyncio
import json
import re
import time
from contextlib import asynccontextmanager
from itertools import count
from typing import TYPE_CHECKING

from patience import PATIENCE_S

from talaia.clock import SystemClock
from talaia.gateway.accepted_changes import AcceptedChanges
from talaia.gateway.app import Gateway
from talaia.gateway.reload.description_file import DescriptionFile
from talaia.gateway.settings import GatewaySettings, HubAddress
from talaia.model.checks.site_checks import raise_first
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import (
    CommandPhase,
    CommandRequest,
    CommandState,
    DriveFrame,
    LeaseOp,
    LeaseRequest,
    LeaseState,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from pathlib import Path

    from fake_hub import FakeHub

    from talaia.wire.frames import Hello

SEQ = count()

SITE = """
talaia: 1
site: test
name: Test robot
ros2: {node: gateway_under_test}
devices:
  base:
    name: Base
    signals:
      number: {name: N, source: {topic: /number, type: std_msgs/msg/Float64, field: data}}
      speed:
        name: Speed
        unit: m/s
        max_age: 1
        source: {topic: /odom, type: nav_msgs/msg/Odometry, field: twist.twist.linear.x}
      pose:
        name: Pose
        type: position
        yaw_from: pose.pose.orientation
        source: {topic: /odom, type: nav_msgs/msg/Odometry, field: pose.pose.position}
      speed1: {name: M, source: {topic: /metric, type: std_msgs/msg/String, name: speed1}}
      mode: {name: Mode, type: text, source: {topic: /mode, type: std_msgs/msg/String, field: data}}
      gain: {name: Gain, source: {parameter: /robot_peer/gain}}
      odd: {name: Odd, source: {topic: /odd, type: nowhere_msgs/msg/Odd, field: data}}
    streams:
      front: {name: Front, source: {topic: /images, type: sensor_msgs/msg/Image}}
    commands:
      wander:
        name: Wander
        target: /wander
        type: std_srvs/srv/SetBool
        arguments: {active: {type: boolean, field: data}}
      fail: {name: Fail, target: /fail, type: std_srvs/srv/Trigger}
      absent: {name: Absent, target: /absent, type: std_srvs/srv/Trigger}
      count:
        name: Count
        kind: action
        target: /count
        type: test_msgs/action/Fibonacci
        progress: sequence[0]
        progress_end: 100
        arguments: {order: {type: integer, field: order, unit: s, minimum: 0, maximum: 100}}
      missing: {name: Missing, kind: action, target: /nowhere, type: test_msgs/action/Fibonacci}
      tune:
        name: Tune
        kind: parameter
        target: /robot_peer
        arguments: {gain: {type: number, field: gain}}
      horn:
        name: Horn
        kind: topic
        target: /horn
        type: std_msgs/msg/String
        arguments: {tune: {type: text, field: data, max_length: 10}}
    drive:
      topic: /cmd_vel
      max_speed: 0.2
      max_turn: 2
      stop: {topic: /stop, confirmed_by: [base/speed]}
"""
_SAID = {
    each[1]: each[0] for each in re.finditer(r"^ {6}(\w+):.*\n(?: {7,}.*\n)*", SITE, re.MULTILINE)
}


def filled(text: str) -> str:
    """Put lines of `SITE` where ``text`` names them: ``<number, speed>``."""
    return re.sub(
        r"^ {6}<(.+)>\n",
        lambda found: "".join(_SAID[name] for name in found[1].split(", ")),
        text,
        flags=re.MULTILINE,
    )


def addresses_of(hello: Hello) -> list[str]:
    return [channel.address for channel in load_site(hello.description).channels()]


class Peer:
    """The robot process as the test sees it."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:  # noqa: D107
        self._process = process
        self.rows: list[dict] = []
        self._changed = asyncio.Event()

    async def read(self) -> None:
        assert self._process.stdout is not None
        async for line in self._process.stdout:
            self.rows.append(json.loads(line))
            self._changed.set()

    async def do(self, what: str, **more: object) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps({"do": what, **more}).encode() + b"\n")
        await self._process.stdin.drain()

    def heard(self, key: str) -> list:
        return [row[key] for row in self.rows if key in row]

    async def until(self, holds: Callable[[], object]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not holds():
                self._changed.clear()
                await self._changed.wait()

    async def until_heard_by(self, listeners: int, **more: object) -> None:
        """Wait until so many subscribe to /number: then discovery is over.

        ``more`` is asked of the peer with it.
        """
        async with asyncio.timeout(PATIENCE_S):
            while True:
                count = len(self.heard("listeners"))
                await self.do("listeners", **more)
                await self.until(lambda count=count: len(self.heard("listeners")) > count)
                if self.heard("listeners")[-1] == listeners:
                    return
                await asyncio.sleep(0.05)


@asynccontextmanager
async def running(
    url: str,
    data: Path,
    text: str = SITE,
    key: str = "test-key",
    fingerprint: str = "",
    file: Path | None = None,
    accepts: AcceptedChanges = AcceptedChanges.NO,
) -> AsyncIterator[Gateway]:
    """A gateway in this process, ended cleanly whatever happens; with ``file`` it follows that."""
    copy = None
    if file is not None:
        file.write_text(text)  # noqa: ASYNC240 - before anything runs
        copy = DescriptionFile(file)
    site = raise_first(load_site(text))
    hub = HubAddress.from_text(url, fingerprint=fingerprint, allow_plain=True)
    settings = GatewaySettings(hub=hub, key=key, data=data, accepts=accepts)
    gateway = Gateway(site=site, settings=settings, clock=SystemClock(), file=copy)
    ended = asyncio.Event()
    task = asyncio.ensure_future(gateway.run(ended))
    try:
        yield gateway
    finally:
        ended.set()
        await asyncio.wait_for(task, PATIENCE_S)


async def command(hub: FakeHub, name: str, command_id: str, **args: object) -> CommandState:
    """Ask the device ``base`` for something, and wait for how it ends."""
    ask = CommandRequest(
        id=command_id, device="base", command=name, args=args, ttl_ms=5000, who="Ada"
    )
    await hub.send(ask)
    final = set(CommandPhase) - {CommandPhase.ACCEPTED, CommandPhase.RUNNING}
    return await hub.next(CommandState, lambda each: each.id == command_id and each.phase in final)


async def take_lease(hub: FakeHub, device: str = "base") -> int:
    """Take a device to drive it, and give the lease's epoch."""
    await hub.send(LeaseRequest(device=device, session="tab", who="Ada", op=LeaseOp.TAKE))
    state = await hub.next(LeaseState, lambda each: each.asked == "tab" and each.device == device)
    await hub.until(lambda: hub.tick >= 0, "a tick")
    return state.epoch


async def drive(hub: FakeHub, epoch: int, linear: float = 0.2, device: str = "base") -> int:
    """Send one frame, and give when (monotonic, ns)."""
    sent = time.monotonic_ns()
    await hub.send(
        DriveFrame(
            device=device, session="tab", epoch=epoch, seq=next(SEQ), tick=hub.tick,
            linear=linear, angular=0.0,
        )
    )  # fmt: skip
    return sent
