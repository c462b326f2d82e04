"""Raw topics from a real robot to Foxglove's own client, by real processes of gateway and hub."""

from __future__ import annotations

import asyncio
import json
import socket
import struct
import time
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

import httpx
import pytest
import websockets
from patience import PATIENCE_S, until_answered
from ports import free_port
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from shared_trust import usual_trust

from ..hub.clients.foxglove.foxglove_peer import SDK, NodeClient, RawClient, address_of
from .conftest import need_ros2
from .faults.proxy import Proxy
from .faults.weather import Way
from .stack import PASSWORD, SITE, Process, Stack, finish, until

pytestmark = [pytest.mark.robot, pytest.mark.asyncio(loop_scope="module")]

DESCRIPTION = """
talaia: 1
site: faults
name: Taps
ros2: {}
devices:
  base: {name: Base}
topics:
  - {pattern: /tap/secret, right: tap}
  - {pattern: /tap/kept, right: view, max_rate: 1}
  - {pattern: /tap/*, right: view}
"""
TEXT = "std_msgs/msg/String"
LARGE = 1_000_000


class Robot:
    """The peer of the gateway's tests as a process of the stack."""

    def __init__(self, process: Process) -> None:  # noqa: D107
        self._process = process
        self._read = 0

    async def ask(self, key: str, **order: object):
        """Give an order and what the robot answers under a key."""
        self._process.tell(json.dumps(order))
        found = []

        def answered() -> bool:
            lines = self._process.said()[self._read :].splitlines(keepends=True)
            for line in lines:
                if not line.endswith("\n"):
                    return False
                self._read += len(line)
                if line.startswith("{") and key in (row := json.loads(line)):
                    found.append(row[key])
                    return True
            return False

        await until(answered, what=f"an answer to {order}")
        return found[0]

    def open(self, topic: str, **more: object) -> None:
        self._process.tell(json.dumps({"do": "open", "topic": topic, **more}))

    async def publish(self, topic: str, *texts: str, **more: object) -> list[str]:
        """Publish; gives the hashes of what ROS writes of each message."""
        order = {"do": "publish", "topic": topic, "texts": list(texts), **more}
        return await self.ask("written", **order)

    async def until_count(self, topic: str, count: int) -> None:
        """Wait until so many subscriptions are known at the publisher itself."""

        async def is_so() -> bool:
            return await self.ask("count", do="count", topic=topic) == count

        await until_answered(is_so)


class TapStack(Stack):
    """A robot with topics, whose gateway dials through a proxy that counts."""

    description = DESCRIPTION
    chosen = 0

    def _free_port(self) -> int:
        return type(self).chosen

    def start_robot(self) -> Process:
        script = Path(__file__).parents[1] / "gateway" / "taps" / "topics_peer.py"
        return Process([str(script)], self.folder / "robot.log", self._ros)


class Taps:
    """The stack with what the tests do with it."""

    def __init__(self, stack: TapStack, line: Proxy) -> None:  # noqa: D107
        self.robot = Robot(stack.robot)
        self.line = line
        self.port = stack.port
        self._stack = stack

    def token(self, *rights: str) -> str:
        """Make a token of the admin's that has no more than these rights."""
        asked = {
            "name": " and ".join(rights),
            "ends_us": int((time.time() + 3600) * 1e6),
            "permissions": [{"right": one, "site": SITE, "device": "*"} for one in rights],
        }
        headers = {"Origin": self._stack.address}
        with httpx.Client(
            base_url=self._stack.address, headers=headers, verify=usual_trust()
        ) as client:
            who = {"name": "boss", "password": PASSWORD}
            assert client.post("/api/login", json=who).status_code == 200
            opened = client.put("/api/client-protocols/foxglove", json={"open": True})
            assert opened.status_code == 204, opened.text
            return str(client.post("/api/me/tokens", json=asked).json()["token"])

    def address(self, *rights: str) -> str:
        return address_of(self, SITE, self.token(*rights))


@pytest.fixture(scope="module")
def taps(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Taps]:
    need_ros2()
    TapStack.chosen = free_port()
    line = Proxy(TapStack.chosen)
    stack = TapStack(tmp_path_factory.mktemp("taps"), people={"boss": "admin"}, link_port=line.port)
    try:
        finish(stack.ready())
        yield Taps(stack, line)
    finally:
        stack.close()
        line.close()


async def channels_of(client, *topics: str) -> dict[str, dict]:
    """Wait until these are advertised."""
    found: dict[str, dict] = {}
    while not found.keys() >= set(topics):
        said = await client.hear("advertise")
        channels = said["channels"] if isinstance(said, dict) else said
        found |= {channel["topic"]: channel for channel in channels}
    return found


async def messages(client: NodeClient, subscription: int, count: int) -> list[bytes]:
    heard = []
    while len(heard) < count:
        message = await client.hear("message", lambda said: said["subscriptionId"] == subscription)
        heard.append(bytes.fromhex(message["data"]))
    return heard


def hashes(data: list[bytes]) -> list[str]:
    return [sha256(one).hexdigest() for one in data]


async def test_a_robots_bytes_reach_two_clients_unchanged_by_one_copy_and_only_while_taken(
    taps: Taps,
) -> None:
    robot = taps.robot
    robot.open("/tap/words")
    robot.open("/tap/large", bytes=1)
    address = taps.address("view")
    async with NodeClient() as one, NodeClient() as other:
        for client in (one, other):
            await client.connect(address, coding="hex")
        offered = [await channels_of(client, "/tap/words", "/tap/large") for client in (one, other)]
        words, large = [
            [channels[topic] for channels in offered] for topic in ("/tap/words", "/tap/large")
        ]
        assert (words[0]["schemaName"], words[0]["encoding"]) == (TEXT, "cdr")
        # The channel is there with its schema, and nobody at the robot is asked for anything.
        assert await robot.ask("count", do="count", topic="/tap/words") == 0
        first = await one.call("subscribe", words[0]["id"])
        await robot.until_count("/tap/words", 1)
        written = await robot.publish("/tap/words", "one", "zwei", "três")
        heard = await messages(one, first, 3)
        assert hashes(heard) == written
        # `rosbags` reads them by nothing but the schema that Foxglove's client was told.
        store = get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(words[0]["schema"], TEXT))
        read = [store.deserialize_cdr(data, TEXT).data for data in heard]
        assert read == ["one", "zwei", "três"]
        second = await other.call("subscribe", words[1]["id"])
        written = await robot.publish("/tap/words", "four")
        for client, subscription in ((one, first), (other, second)):
            assert hashes(await messages(client, subscription, 1)) == written
        clouds = [
            await client.call("subscribe", channel["id"])
            for client, channel in zip((one, other), large, strict=True)
        ]
        await robot.until_count("/tap/large", 1)
        before = taps.line.passed[Way.UP]
        for _ in range(5):
            written = await robot.publish("/tap/large", "", bytes=LARGE)
            for client, subscription in zip((one, other), clouds, strict=True):
                assert hashes(await messages(client, subscription, 1)) == written
        # Two take it, and it passes the gateway's line once: beside it beats and receipts.
        assert 5 * LARGE < taps.line.passed[Way.UP] - before < 5.5 * LARGE
        assert await robot.ask("count", do="count", topic="/tap/words") == 1
        await one.call("unsubscribe", first)
        await one.call("unsubscribe", clouds[0])
        await other.call("unsubscribe", second)
        await robot.until_count("/tap/words", 0)
        assert await robot.ask("count", do="count", topic="/tap/large") == 1
    # Whoever goes away without a word takes no more either.
    await robot.until_count("/tap/large", 0)


async def test_without_the_right_to_tap_a_topic_is_as_if_it_were_not_there(taps: Taps) -> None:
    robot = taps.robot
    robot.open("/tap/secret")
    robot.open("/tap/free")
    async with NodeClient() as may:
        await may.connect(taps.address("view", "tap"), coding="hex")
        channel = (await channels_of(may, "/tap/secret"))["/tap/secret"]
        may_not = await RawClient().connect(taps.address("view"))
        await channels_of(may_not, "/tap/free")
        asked = [{"id": number, "channelId": number} for number in range(100)]
        await may_not.say({"op": "subscribe", "subscriptions": asked})
        # It asked for each number that there could be, and was refused those that it may not have.
        await may_not.hear("status", lambda said: " 99" in said["message"])
        await robot.until_count("/tap/free", 1)
        assert await robot.ask("count", do="count", topic="/tap/secret") == 0
        subscription = await may.call("subscribe", channel["id"])
        await robot.until_count("/tap/secret", 1)
        written = await robot.publish("/tap/secret", "hush")
        assert hashes(await messages(may, subscription, 1)) == written
        await robot.publish("/tap/free", "loud")
        await may_not.hear("data", lambda frame: b"loud" in frame)
        said = b"".join(one.encode() if isinstance(one, str) else one for one in may_not.frames)
        assert b"secret" not in said
        assert b"hush" not in said
        await may_not.close()
    await robot.until_count("/tap/secret", 0)


async def test_one_who_reads_nothing_delays_nobody_and_later_gets_all_that_is_latched(
    taps: Taps,
) -> None:
    robot, count = taps.robot, 24
    robot.open("/tap/kept", latched=True)
    robot.open("/tap/cloud", bytes=1)
    kept = await robot.publish("/tap/kept", *[f"part {number}" for number in range(20)])
    address = taps.address("view")
    narrow = socket.socket()
    # Little waits in the machine itself: what a client does not read stays in the hub.
    narrow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65_536)
    narrow.setblocking(False)  # noqa: FBT003
    await asyncio.get_running_loop().sock_connect(narrow, ("127.0.0.1", taps.port))
    async with (
        NodeClient() as quick,
        websockets.connect(
            address, sock=narrow, subprotocols=[SDK], max_queue=1, max_size=None, proxy=None
        ) as slow,
    ):
        await quick.connect(address, coding="hex")
        channels = await channels_of(quick, "/tap/kept", "/tap/cloud")
        advertised: dict[str, int] = {}
        while not {"/tap/kept", "/tap/cloud"} <= advertised.keys():
            frame = await slow.recv()
            said = {"op": ""} if isinstance(frame, bytes) else json.loads(frame)
            if said["op"] == "advertise":
                advertised |= {one["topic"]: one["id"] for one in said["channels"]}
        # From here on it reads nothing.
        cloud = [{"id": 1, "channelId": advertised["/tap/cloud"]}]
        await slow.send(json.dumps({"op": "subscribe", "subscriptions": cloud}))
        subscription = await quick.call("subscribe", channels["/tap/cloud"]["id"])
        await robot.until_count("/tap/cloud", 1)
        written = []
        for _ in range(count):
            # The next one comes when the other has this one: a client that delays would hold it up.
            written += await robot.publish("/tap/cloud", "", bytes=LARGE)
            assert hashes(await messages(quick, subscription, 1)) == written[-1:]
        # Its rule allows one a second; of what is latched each message says something.
        latched = [{"id": 2, "channelId": advertised["/tap/kept"]}]
        await slow.send(json.dumps({"op": "subscribe", "subscriptions": latched}))
        subscription = await quick.call("subscribe", channels["/tap/kept"]["id"])
        assert hashes(await messages(quick, subscription, len(kept))) == kept
        clouds, heard = 0, []
        async with asyncio.timeout(PATIENCE_S):
            while len(heard) < len(kept):
                frame = await slow.recv()
                # Not the hub's time.
                if isinstance(frame, bytes) and frame[0] == 1:
                    subscription = struct.unpack_from("<I", frame, 1)[0]
                    clouds += subscription == 1
                    if subscription == 2:
                        heard.append(frame[13:])
        assert hashes(heard) == kept
        # What was too much for it was left out.
        assert 0 < clouds < count
