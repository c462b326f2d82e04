"""A digital twin through the real chain: two simulated vehicles, gateway, hub and ROS 2.

The real one has wheels with friction that the model knows nothing of. What it did is read from its
own log, and what the twin says as a page reads it.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from patience import until_answered

from talaia.wire import browser
from talaia.wire.columns import unpack_columns
from talaia.wire.frames import CommandPhase, TwinOp

from .conftest import missing
from .people import PERIOD_S, Page, page
from .stack import SITE, Process, Stack, finish, until

pytestmark = pytest.mark.robot

DESCRIPTION = (
    (Path(__file__).parents[2] / "examples" / "agv" / "with_twin.yaml")
    .read_text()
    .replace("site: twin", f"site: {SITE}")
)
RENEW_S = 0.5
CHANNELS = ("twin/mode", "twin/pose_error", "twin/resets", "base/pose.x", "twin/pose.x")
WAITING, FOLLOWING, REHEARSING = range(3)
# Puts the vehicle somewhere, as a person who carries it.
KIDNAP = """
import sys, time
import ros_wheels_bootstrapper
import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped
rclpy.init()
node = rclpy.create_node("kidnapper")
publisher = node.create_publisher(PoseWithCovarianceStamped, "/set_pose", 10)
while not publisher.get_subscription_count():
    time.sleep(0.02)
message = PoseWithCovarianceStamped()
message.pose.pose.position.x = float(sys.argv[1])
message.pose.pose.position.y = -0.4
message.pose.pose.orientation.z = 1.0
message.pose.pose.orientation.w = 0.0
publisher.publish(message)
publisher.wait_for_all_acked()
"""


class TwinStack(Stack):
    """A hub, a gateway, a vehicle and its twin."""

    def start_robot(self) -> Process:
        self.log = self.folder / "vehicle.jsonl"
        words = ["-m", "talaia", "sim", "vehicle", "--no-camera", "--log", str(self.log)]
        words += ["--domain", str(self._world.domain), "--friction", "40", "--seed", "3"]
        return Process(words, self.folder / "vehicle.log", self._ros)

    def start_twin(self) -> Process:
        words = ["-m", "talaia", "twin", str(self.folder / "site.yaml")]
        words += ["--domain", str(self._world.domain)]
        return Process(words, self.folder / "twin.log", self._ros)

    async def kidnap(self, x: float) -> None:
        """Carry the vehicle away, and turn it round."""
        carrier = Process(["-c", KIDNAP, str(x)], self.folder / "kidnap.log", self._ros)
        await until(lambda: carrier.popen.poll() is not None, what="the vehicle carried away")
        carrier.end()

    def actuations(self, since: int) -> list[dict[str, object]]:
        """What moved the vehicle, or stopped it, after a line of its log."""
        return [json.loads(line) for line in self.log.read_text().splitlines()[since:]]

    def told(self) -> int:
        return len(self.log.read_text().splitlines())

    def moved_by(self, source: str, since: int) -> bool:
        return any(one["source"] == source and one["v"] for one in self.actuations(since))


@pytest.fixture(scope="module")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TwinStack]:
    for module in ("rclpy", "mujoco"):
        if not __import__("importlib.util").util.find_spec(module):
            missing(module)
    running = TwinStack(tmp_path_factory.mktemp("twin"), DESCRIPTION)
    try:
        yield running
    finally:
        running.close()


class TwinPage(Page):
    """A page that drives a twin."""

    async def watch(self) -> None:
        await self.subscribe(*CHANNELS)

    def newest(self, channel: str) -> float:
        """Give what came last of a channel; NaN before anything did."""
        number, found = CHANNELS.index(channel), float("nan")
        for news in self.all(browser.Values):
            columns = unpack_columns(news)
            for at, value in zip(columns.channel, columns.value, strict=True):
                if at == number:
                    found = float(value)
        return found

    async def mode(self, wanted: int) -> None:
        await until(lambda: self.newest("twin/mode") == wanted, what=f"the twin in mode {wanted}")

    def twin(self) -> browser.TwinUpdate:
        return self.all(browser.TwinUpdate)[-1]

    async def twin_frame(self, linear: float, *, live: bool) -> None:
        self.seq += 1
        await self.say(
            browser.PageTwinDrive(
                site=SITE,
                device="base",
                epoch=self.epoch,
                seq=self.seq,
                tick=self.tick,
                linear=linear,
                angular=0.0,
                live=live,
            )
        )

    async def drive_twin(self, seconds: float, *, live: bool, linear: float = 0.2) -> None:
        """Hold the stick for a while, as the page does, and let go."""
        from asyncio import sleep

        end, renewed = time.monotonic() + seconds, 0.0
        while time.monotonic() < end:
            # By the clock: on a busy machine twenty frames take longer than a lease lasts.
            if time.monotonic() - renewed > RENEW_S:
                renewed = time.monotonic()
                await self.renew()
            await self.twin_frame(linear, live=live)
            await sleep(PERIOD_S)
        for _ in range(3):
            await self.twin_frame(0.0, live=live)

    async def renew(self) -> None:
        from talaia.wire.frames import LeaseOp

        await self.say(browser.PageLease(site=SITE, device="base", op=LeaseOp.RENEW))

    async def take_anew(self) -> None:
        """Take the lease whether or not it ran out while something was waited for."""
        await self.free()
        await self.take()

    async def switch(self, op: TwinOp) -> browser.TwinUpdate:
        since = len(self.got)
        await self.say(browser.PageTwin(site=SITE, device="base", epoch=self.epoch, op=op))
        return await self.sees(browser.TwinUpdate, since=since)

    async def ask(self, device: str, command: str, **args: float | str) -> None:
        """Ask for a command once, and wait until it was done."""
        name = f"{command}-{len(self.got)}"
        await self.say(
            browser.PageCommand(site=SITE, device=device, command=command, id=name, args=args)
        )
        await self.sees(
            browser.CommandUpdate,
            lambda news: news.id == name and news.phase is CommandPhase.SUCCEEDED,
        )


async def walk(stack: TwinStack) -> None:
    await stack.ready()
    twin = stack.start_twin()
    try:
        await twin.says("ready")
        async with page(stack, "driver") as opened:
            # The same page, with what a twin needs besides.
            opened.__class__ = TwinPage
            assert isinstance(opened, TwinPage)
            await opened.watch()
            await opened.mode(FOLLOWING)
            await kidnapped(stack, opened)
            await rehearsed(stack, opened)
            await sent_as_a_goal(stack, opened)
            await driven_live(stack, opened)
            await stopped(stack, opened)
            await killed(stack, opened, twin)
    finally:
        twin.end()


async def kidnapped(stack: TwinStack, person: TwinPage) -> None:
    """Whoever carries the robot away finds the twin beside it, which has counted that."""
    await until(lambda: person.newest("twin/resets") == 0, what="no reset yet")
    await stack.kidnap(-1.0)
    await until(lambda: person.newest("base/pose.x") == pytest.approx(-1.0, abs=0.05))
    # It looks the other way: farther off than a second of following makes good.
    await until(lambda: person.newest("twin/resets") == 1, what="a reset")
    await until(lambda: person.newest("twin/pose_error") < 0.05, what="a small error")


async def rehearsed(stack: TwinStack, person: TwinPage) -> None:
    """What is driven in the twin alone moves nothing else, and leaves a path."""
    # A gateway that has begun is locked until the charge was enough for some seconds.
    await until(lambda: not person.all(browser.InterlockUpdate)[-1].locked, what="it may drive")
    told = stack.told()
    await person.take()
    await person.drive_twin(1.5, live=False)
    await person.mode(REHEARSING)
    await until(lambda: person.twin().path, what="a path")
    assert person.twin().metres > 0.1
    assert not person.twin().verdicts
    assert stack.told() == told
    # A frame that says live has no say either: the switch at the gateway is off.
    await person.drive_twin(0.3, live=True)
    assert stack.told() == told
    # Nor is it switched on while the twin is away from the robot.
    assert not (await person.switch(TwinOp.LIVE)).live


async def sent_as_a_goal(stack: TwinStack, person: TwinPage) -> None:
    """The end of the path, as a command of the robot: it drives there and the twin is there."""
    told = stack.told()
    x, y, _yaw = person.twin().path[-3:]
    await person.ask("base", "goal", frame="odom", x=x, y=y, qz=1.0, qw=0.0)
    await until(lambda: person.newest("base/pose.x") == pytest.approx(x, abs=0.1), what="there")
    assert stack.moved_by("goal_pose", told)
    await person.ask("twin", "follow")
    await person.mode(FOLLOWING)


async def driven_live(stack: TwinStack, person: TwinPage) -> None:
    """With live on the robot moves, and the twin by its side."""
    await person.take_anew()
    told = stack.told()

    async def is_live() -> bool:
        return (await person.switch(TwinOp.LIVE)).live

    # On a busy machine the twin's word of how far it is from the robot may be late.
    await until_answered(is_live)
    await person.drive_twin(0.2, live=True, linear=0.0)
    await person.drive_twin(1.5, live=True)
    assert stack.moved_by("cmd_vel", told)
    assert person.newest("twin/mode") == FOLLOWING
    # Friction that the model knows nothing of: an error, and a bounded one.
    assert person.newest("twin/pose_error") < 0.5


async def stopped(stack: TwinStack, person: TwinPage) -> None:
    """STOP is the robot's and ends live; a reset does not bring it back."""
    since = len(person.got)
    await person.say(browser.PageStop(site=SITE, device="base", id="stop-1"))
    await person.sees(browser.StopUpdate, lambda news: news.latched, since=since)
    await person.sees(browser.TwinUpdate, lambda news: not news.live, since=since)
    told = stack.told()
    await person.drive_twin(0.4, live=True)
    await person.drive_twin(0.4, live=False)
    assert not stack.moved_by("cmd_vel", told)
    assert person.newest("twin/mode") == FOLLOWING
    await person.take_anew()
    reset = browser.PageReset(site=SITE, device="base", epoch=person.epoch)
    await person.say(reset)
    token = (await person.sees(browser.ResetTokenUpdate, since=since)).token
    await person.say(browser.PageReset(site=SITE, device="base", epoch=person.epoch, token=token))
    await person.sees(browser.StopUpdate, lambda news: not news.latched, since=since)
    assert not person.twin().live


async def killed(stack: TwinStack, person: TwinPage, twin: Process) -> None:
    """A twin that dies while the robot is driven through it stops that, and nothing else."""
    await person.take_anew()

    async def is_live() -> bool:
        return (await person.switch(TwinOp.LIVE)).live

    # On a busy machine the twin's word of how far it is from the robot may be late.
    await until_answered(is_live)
    await person.drive_twin(0.2, live=True, linear=0.0)
    since = len(person.got)
    await person.drive_twin(0.5, live=True)
    twin.kill()
    await person.drive_twin(3.0, live=True)
    ended = await person.sees(browser.TwinUpdate, lambda news: not news.live, since=since)
    assert "twin" in ended.why
    told = stack.told()
    await person.drive_twin(0.4, live=True)
    assert not stack.moved_by("cmd_vel", told)
    # The robot itself needs no twin.
    await person.take_anew()
    told = stack.told()
    person.press(0.1)
    await until(lambda: stack.moved_by("cmd_vel", told), what="the robot driven as ever")
    await person.let_go()


def test_a_twin_follows_is_lost_and_found_rehearses_drives_and_dies(stack: TwinStack) -> None:
    finish(walk(stack))
