"""Raw topics of a real ROS 2 robot in another process, through a gateway to a hub."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from fake_hub import FakeHub, fake_hub
from gateway.conftest import peer_in
from gateway_bench import Peer, addresses_of, running
from patience import PATIENCE_S
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from tapped_hub import newest_list, pieces, whole

from talaia.wire.frames import TapError, TapSchema, TapSubscription

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

SITE = """
talaia: 1
site: test
name: Test robot
ros2: {node: gateway_under_test}
devices:
  base: {name: Base}
"""
TEXT = "std_msgs/msg/String"


@pytest.fixture
async def robot(ros_domain: int) -> AsyncIterator[Peer]:
    async with peer_in(ros_domain, Path(__file__).with_name("topics_peer.py")) as one:
        yield one


@asynccontextmanager
async def bench(data: Path, takes: tuple[str, ...] = ("topic_list",)) -> AsyncIterator[FakeHub]:
    """A gateway of `SITE` that is linked to a hub which takes topics."""
    async with fake_hub(addresses_of) as hub:
        hub.takes = list(takes)
        async with running(hub.url, data, SITE):
            await hub.until(lambda: hub.links and hub.media, "both connections")
            yield hub


async def listeners(robot: Peer, topic: str) -> list[str]:
    count = len(robot.heard("listeners"))
    await robot.do("listeners", topic=topic)
    await robot.until(lambda: len(robot.heard("listeners")) > count)
    return robot.heard("listeners")[-1]


async def until_heard(robot: Peer, topic: str, *, by: list[str]) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while True:
            if await listeners(robot, topic) == by:
                return
            await asyncio.sleep(0.05)


async def test_a_topic_is_heard_only_while_it_is_wanted_and_its_bytes_are_read_by_its_schema(
    robot: Peer, tmp_path: Path
) -> None:
    await robot.do("open", topic="/words")
    async with bench(tmp_path) as hub:
        await hub.until(lambda: "/words" in newest_list(hub), "the topic in the list")
        assert newest_list(hub)["/words"][1:] == (TEXT, False)
        await robot.do("publish", topic="/words", texts=["nobody"])
        # It costs nothing so far: nobody at the robot is asked for anything.
        assert await listeners(robot, "/words") == []
        await hub.send(TapSubscription(types=[TEXT]))
        await hub.until(lambda: isinstance(hub.taps[-1], TapSchema), "the schema")
        schema = hub.taps[-1]
        assert (schema.type, schema.encoding, schema.message_encoding) == (TEXT, "ros2msg", "cdr")
        assert await listeners(robot, "/words") == []
        await hub.send(TapSubscription(topics={"/words": 0}))
        await until_heard(robot, "/words", by=["gateway_under_test"])
        await robot.do("publish", topic="/words", texts=["one", "zwei", "três"])
        await hub.until(lambda: len(whole(hub, "/words")) == 3, "three messages")
        # The judge: `rosbags` reads the bytes by nothing but the schema that came along.
        store = get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(schema.definition, TEXT))
        read = [store.deserialize_cdr(data, TEXT).data for data in whole(hub, "/words")]
        assert read == ["one", "zwei", "três"]
        first = pieces(hub, "/words")[0]
        assert 0 < first.publish_us <= first.log_us < first.publish_us + 60_000_000
        # Silence: the publisher goes away, and another one comes under the same name.
        await robot.do("shut", topic="/words")
        await hub.until(lambda: "/words" not in newest_list(hub), "the list without it")
        await robot.do("open", topic="/words")
        await until_heard(robot, "/words", by=["gateway_under_test"])
        await hub.until(lambda: "/words" in newest_list(hub), "the list with it")
        await robot.do("publish", topic="/words", texts=["again"])
        await hub.until(lambda: len(whole(hub, "/words")) == 4, "the message after silence")
        await hub.send(TapSubscription())
        await until_heard(robot, "/words", by=[])
    assert not [said for said in hub.taps if isinstance(said, TapError)]


async def test_a_latched_topic_is_told_whole_and_a_lost_link_lets_it_rest(
    robot: Peer, tmp_path: Path
) -> None:
    await robot.do("open", topic="/kept", latched=True)
    await robot.do("publish", topic="/kept", texts=[f"part {n}" for n in range(20)])
    async with bench(tmp_path) as hub:
        await hub.until(lambda: "/kept" in newest_list(hub), "the topic in the list")
        assert newest_list(hub)["/kept"][2]
        # The rate is for what comes often: of this one each message says something.
        await hub.send(TapSubscription(topics={"/kept": 1}))
        await hub.until(lambda: len(whole(hub, "/kept")) == 20, "all of them")
        assert all(piece.kept for piece in pieces(hub, "/kept"))
        hub.taps.clear()
        hub.cut()
        await until_heard(robot, "/kept", by=[])
        await hub.until(lambda: len(hub.links) == 2 and newest_list(hub), "another link")
        await hub.send(TapSubscription(topics={"/kept": 0}))
        await hub.until(lambda: len(whole(hub, "/kept")) == 20, "all of them again")


async def test_a_rate_is_kept_at_the_gateway(robot: Peer, tmp_path: Path) -> None:
    await robot.do("open", topic="/often")
    async with bench(tmp_path) as hub:
        await hub.until(lambda: "/often" in newest_list(hub), "the topic in the list")
        await hub.send(TapSubscription(topics={"/often": 10}))
        await until_heard(robot, "/often", by=["gateway_under_test"])
        texts = [str(number) for number in range(200)]
        await robot.do("publish", topic="/often", texts=texts, hz=100)
        await robot.until(lambda: robot.heard("published"))
        # Which is the last that passes is chance; what comes slowly after it all passes.
        await robot.do("publish", topic="/often", texts=["end"] * 20, hz=5)

        def ends() -> int:
            return sum(b"end" in each for each in whole(hub, "/often"))

        await hub.until(ends, "the end")
        # The first ten come whole, for a topic that has just begun comes seldom; then ten a second.
        assert 20 <= len(whole(hub, "/often")) - ends() <= 40


async def test_a_hundred_topics_and_large_messages_come_once_and_whole(
    robot: Peer, tmp_path: Path
) -> None:
    names = [f"/many/t{number}" for number in range(100)]
    for name in [*names, "/large"]:
        await robot.do("open", topic=name, bytes=int(name == "/large"))
    async with bench(tmp_path) as hub:
        await hub.until(lambda: {*names, "/large"} <= newest_list(hub).keys(), "all in the list")
        await hub.send(TapSubscription(topics=dict.fromkeys([*names, "/large"], 0.0)))
        for name in (names[-1], "/large"):
            await until_heard(robot, name, by=["gateway_under_test"])
        await hub.until(lambda: True, "a turn")
        before = hub.media_bytes
        await robot.do("publish", topic="/large", bytes=1_000_000, count=10, hz=4)
        await robot.do("publish", topics=names, texts=["a", "b", "c"], hz=2)
        await hub.until(lambda: sum(map(len, whole(hub, "/large"))) >= 10_000_000, "ten large ones")
        assert [data[-1] for data in whole(hub, "/large")] == list(range(10))
        await hub.until(
            lambda: all(len(whole(hub, name)) == 3 for name in names), "three of each topic"
        )
        # Once, and little beside: pieces, receipts, beats.
        assert 10_000_000 < hub.media_bytes - before < 10_400_000


async def test_a_hub_of_former_times_is_told_nothing(robot: Peer, tmp_path: Path) -> None:
    await robot.do("open", topic="/words")
    async with bench(tmp_path, takes=()) as hub:
        await robot.do("publish", topic="/words", texts=["x"] * 10, hz=5)
        await robot.until(lambda: robot.heard("published"))
        assert not hub.taps
