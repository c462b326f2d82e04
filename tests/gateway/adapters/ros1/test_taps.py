"""Raw topics of a real ROS 1 robot (Debian's rosmaster and rospy), through a gateway to a hub."""

from __future__ import annotations

import asyncio
import functools
import itertools
import xmlrpc.client
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, NamedTuple

import pytest
from fake_hub import FakeHub, fake_hub
from gateway_bench import Peer, addresses_of, command, running
from patience import until_answered
from ports import free_port
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from tapped_hub import newest_list, pieces, whole

from talaia.wire.frames import CommandPhase, TapError, TapSchema, TapSubscription

from . import ros1_bench

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator
    from pathlib import Path

pytestmark = pytest.mark.robot

SITE = """
talaia: 1
site: old
name: ROS 1 robot
connections:
  old: {kind: ros1, master: "http://127.0.0.1:%d"}
devices:
  base: {name: Base}
"""
COUNT = """
    name: Base
    commands:
      count:
        name: Count
        kind: action
        target: /count
        type: actionlib/action/Test
        arguments: {to: {type: integer, field: goal, minimum: 0, maximum: 100}}
"""
TEXT, ODOMETRY = "std_msgs/msg/String", "nav_msgs/msg/Odometry"


class TappedRobot(NamedTuple):
    """One robot with topics, and where it is."""

    peer: Peer
    port: int

    async def ask(self, key: str, what: str, **more: object):
        """Tell the robot to do something; give its answer."""
        count = len(self.peer.heard(key))
        await self.peer.do(what, **more)
        await self.peer.until(lambda: len(self.peer.heard(key)) > count)
        return self.peer.heard(key)[-1]

    async def publish(self, topic: str, *values: object, **more: object) -> list:
        """Publish; give what ROS writes of each message."""
        return await self.ask("written", "publish", topic=topic, values=values, **more)

    async def until_count(self, topic: str, count: int) -> None:
        """Wait until so many are connected, by the publisher itself."""

        async def is_so() -> bool:
            return await self.ask("count", "count", topic=topic) == count

        await until_answered(is_so)

    def subscribers(self, topic: str) -> list[str]:
        """Ask the master who subscribes."""
        with xmlrpc.client.ServerProxy(f"http://127.0.0.1:{self.port}") as master:
            return dict(master.getSystemState("/test")[2][1]).get(topic, [])


@pytest.fixture
def ros1_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    ros1_bench.need_ros1()
    home = tmp_path / "ros"
    home.mkdir()
    monkeypatch.setenv("ROS_HOME", str(home))
    monkeypatch.setenv("ROS_IP", "127.0.0.1")
    return home


@pytest.fixture
def port(ros1_home: Path) -> Iterator[int]:
    number = free_port()
    with ros1_bench.master(number, ros1_home):
        yield number


@pytest.fixture
async def robot(port: int, ros1_home: Path) -> AsyncIterator[TappedRobot]:
    async with ros1_bench.robot(port, ros1_home, script="ros1_topics_peer.py") as peer:
        yield TappedRobot(peer, port)


@asynccontextmanager
async def bench(robot: TappedRobot, data: Path) -> AsyncIterator[FakeHub]:
    """A gateway of `SITE` that is linked to a hub which takes topics."""
    async with fake_hub(addresses_of) as hub:
        hub.takes = ["topic_list"]
        async with running(hub.url, data, SITE % robot.port):
            await hub.until(lambda: hub.links and hub.media, "both connections")
            yield hub


def schemas(hub: FakeHub) -> list[TapSchema]:
    return [said for said in hub.taps if isinstance(said, TapSchema)]


def read_by(schema: TapSchema, data: bytes) -> object:
    """The judge: `rosbags` reads a message by nothing but the schema that came along."""
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(schema.definition, schema.type))
    return store.deserialize_ros1(data, schema.type)


async def test_a_topic_is_heard_only_while_it_is_wanted_and_its_bytes_are_those_of_ros(
    robot: TappedRobot, tmp_path: Path
) -> None:
    await robot.ask("opened", "open", topic="/pose", kind="odometry")
    async with bench(robot, tmp_path) as hub:
        await hub.until(lambda: "/pose" in newest_list(hub), "the topic in the list")
        assert newest_list(hub)["/pose"][1:] == (ODOMETRY, False)
        await robot.publish("/pose", 0.5)
        # It costs nothing so far: nobody at the robot is asked for anything.
        assert await robot.ask("count", "count", topic="/pose") == 0
        await hub.send(TapSubscription(types=[ODOMETRY]))
        await hub.until(lambda: schemas(hub), "the schema")
        (schema,) = schemas(hub)
        assert (schema.type, schema.encoding, schema.message_encoding) == (
            ODOMETRY,
            "ros1msg",
            "ros1",
        )
        # Who asks for a definition subscribes nothing.
        assert robot.subscribers("/pose") == []
        await hub.send(TapSubscription(topics={"/pose": 0}))
        await robot.until_count("/pose", 1)
        written = await robot.publish("/pose", 1.0, 2.5)
        await hub.until(lambda: len(whole(hub, "/pose")) == 2, "two messages")
        assert [data.hex() for data in whole(hub, "/pose")] == written
        read = read_by(schema, whole(hub, "/pose")[1])
        assert (read.pose.pose.position.x, read.header.stamp.nanosec) == (2.5, 34)
        # Silence: the publisher goes away, and another one comes under the same name.
        await robot.ask("shut", "shut", topic="/pose")
        await hub.until(lambda: "/pose" not in newest_list(hub), "the list without it")
        await robot.ask("opened", "open", topic="/pose", kind="odometry")
        await hub.until(lambda: "/pose" in newest_list(hub), "the list with it")
        await robot.until_count("/pose", 1)
        written = await robot.publish("/pose", 3.0)
        await hub.until(lambda: len(whole(hub, "/pose")) == 3, "the message after silence")
        assert whole(hub, "/pose")[2].hex() == written[0]
        await hub.send(TapSubscription())
        await robot.until_count("/pose", 0)
    assert not [said for said in hub.taps if isinstance(said, TapError)]


async def test_a_latched_topic_is_known_as_such_is_never_thinned_and_rests_without_a_link(
    robot: TappedRobot, tmp_path: Path
) -> None:
    await robot.ask("opened", "open", topic="/kept", latched=True)
    await robot.publish("/kept", "before")
    async with bench(robot, tmp_path) as hub:
        await hub.until(lambda: "/kept" in newest_list(hub), "the topic in the list")
        # The rate is for what comes often: of this one each message says something.
        await hub.send(TapSubscription(topics={"/kept": 1}))
        await hub.until(lambda: len(whole(hub, "/kept")) == 1, "what was published before")
        assert newest_list(hub)["/kept"][1:] == (TEXT, True)
        await robot.publish("/kept", *(f"part {number}" for number in range(40)), hz=100)
        await hub.until(lambda: len(whole(hub, "/kept")) == 41, "all of them")
        assert all(piece.kept for piece in pieces(hub, "/kept"))
        hub.taps.clear()
        hub.cut()
        await robot.until_count("/kept", 0)
        await hub.until(lambda: len(hub.links) == 2 and newest_list(hub), "another link")
        await hub.send(TapSubscription(topics={"/kept": 1}))
        await hub.until(lambda: whole(hub, "/kept"), "its last message again")
        assert b"part 39" in whole(hub, "/kept")[0]


async def publish_until(
    robot: TappedRobot, hub: FakeHub, size: int, came: Callable[[int], bool]
) -> list:
    """Publish so many bytes until ``came``, given how many were there; give what was written.

    Where the link was lost meanwhile (a busy machine), nobody takes it until asked again.
    """
    written: list = []
    before = len(whole(hub, "/large"))
    while not came(before):
        before = len(whole(hub, "/large"))
        await hub.send(TapSubscription(topics={"/large": 0}))
        await robot.until_count("/large", 1)
        written = await robot.publish("/large", size)
        with suppress(TimeoutError):
            async with asyncio.timeout(10):
                await hub.until(functools.partial(came, before), "the message")
    return written


async def test_messages_that_are_larger_than_a_frame_come_whole(
    robot: TappedRobot, tmp_path: Path
) -> None:
    await robot.ask("opened", "open", topic="/large", kind="bytes")
    async with bench(robot, tmp_path) as hub:
        await hub.until(lambda: "/large" in newest_list(hub), "the topic in the list")
        for size in (20_000_000, 1_000_000, 65_536, 0):
            # One after the other: of those that wait on a slow line the newest alone is sent.
            (written,) = await publish_until(
                robot, hub, size, lambda before: len(whole(hub, "/large")) > before
            )
            got = whole(hub, "/large")[-1]
            assert (len(got) if len(got) >= 10_000 else got.hex()) == written
            assert not any(got[-size:] if size else b"")
        # Too large for anybody: whoever takes the topic is told why nothing comes.
        await publish_until(
            robot,
            hub,
            33 * 1024 * 1024,
            lambda _: any(isinstance(one, TapError) for one in hub.taps),
        )
        error = next(one for one in hub.taps if isinstance(one, TapError))
        assert (error.topic, "too large" in error.why) == ("/large", True)


async def test_a_publisher_that_comes_back_with_another_definition_is_read_by_that(
    robot: TappedRobot, tmp_path: Path
) -> None:
    """Of a type, moreover, whose package is nowhere on this machine."""
    odd = {"topic": "/odd", "type": "nowhere_msgs/Odd"}
    await robot.ask("opened", "open", **odd, definition="string data\n")
    async with bench(robot, tmp_path) as hub:
        await hub.until(lambda: "/odd" in newest_list(hub), "the topic in the list")
        await hub.send(TapSubscription(types=["nowhere_msgs/msg/Odd"]))
        await hub.until(lambda: schemas(hub), "the schema")
        await hub.send(TapSubscription(topics={"/odd": 0}))
        await robot.until_count("/odd", 1)
        await robot.publish("/odd", "one")
        await hub.until(lambda: len(whole(hub, "/odd")) == 1, "a message")
        assert read_by(schemas(hub)[0], whole(hub, "/odd")[0]).data == "one"
        await robot.ask("shut", "shut", topic="/odd")
        await robot.ask("opened", "open", **odd, definition="int64 count\nstring data\n")
        await robot.until_count("/odd", 1)
        await robot.publish("/odd", "two")
        await hub.until(lambda: len(whole(hub, "/odd")) == 2, "another message")
        # The new definition comes before what is of it.
        assert len(schemas(hub)) == 2
        read = read_by(schemas(hub)[1], whole(hub, "/odd")[1])
        assert (read.count, read.data) == (0, "two")
        assert hub.taps.index(schemas(hub)[1]) < hub.taps.index(pieces(hub, "/odd")[1])


async def test_topics_of_an_action_are_tapped_beside_its_command(
    port: int, ros1_home: Path, tmp_path: Path
) -> None:
    """The node hears them already, as what they are: rospy has one way for all of a node."""
    feedback, status = "/count/feedback", "/count/status"
    site = SITE.replace(" {name: Base}\n", COUNT) % port
    async with ros1_bench.robot(port, ros1_home), fake_hub(addresses_of) as hub:
        hub.takes = ["topic_list"]
        async with running(hub.url, tmp_path, site):
            await hub.until(lambda: feedback in newest_list(hub), "the topics in the list")
            await hub.send(TapSubscription(types=["actionlib/msg/TestActionFeedback"]))
            await hub.until(lambda: schemas(hub), "the schema")
            await hub.send(TapSubscription(topics={feedback: 0, status: 0}))
            # It comes all the time.
            await hub.until(lambda: whole(hub, status), "the status")
            # Of the other one comes while a goal runs, and the robot may take its new listener
            # later than the first goal.
            for turn in itertools.count():
                await command(hub, "count", f"before {turn}", to=1)
                if whole(hub, feedback):
                    break
            done = await command(hub, "count", "one", to=3)
            assert (done.phase, done.message) == (CommandPhase.SUCCEEDED, "counted")

            def counted() -> list[int]:
                read = (read_by(schemas(hub)[0], data) for data in whole(hub, feedback)[-3:])
                return [message.feedback.feedback for message in read]

            await hub.until(lambda: counted() == [0, 1, 2], "what the command hears, too")
