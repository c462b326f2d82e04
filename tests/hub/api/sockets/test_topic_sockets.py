"""A page follows a raw topic: who may, what comes, and that nothing is heard without it."""

from __future__ import annotations

import asyncio

import msgspec
import pytest
import websockets
from patience import PATIENCE_S
from rosbags.typesys import Stores, get_typestore

from talaia.model.yaml_text.load import load_site
from talaia.wire import browser
from talaia.wire.frames import (
    DescriptionUpdate,
    TapMessage,
    TapSchema,
    TapSubscription,
    TopicEntry,
    TopicList,
)
from talaia.wire.sealing import compress_text

from ...conftest import DESCRIPTION

RULES = """
topics:
  - {pattern: /said, right: view}
  - {pattern: /secret, right: admin}
"""
KIND = "std_msgs/msg/String"
STORE = get_typestore(Stores.LATEST)
ENTRIES = [
    TopicEntry(number=1, topic="/said", type=KIND),
    TopicEntry(number=2, topic="/secret", type=KIND),
    TopicEntry(number=3, topic="/other", type=KIND),
]
PIECE = 64 * 1024
SCHEMA = TapSchema(type=KIND, encoding="ros2msg", definition="string data", message_encoding="cdr")


def serialized(text: str) -> bytes:
    return bytes(STORE.serialize_cdr(STORE.types[KIND](data=text), KIND))


class Robot:
    """A gateway with three topics."""

    def __init__(self, hub, gateway, media) -> None:  # noqa: D107
        self.hub, self.gateway, self.media = hub, gateway, media
        self.seq = 0

    async def publish(self, text: str, number: int = 1, *, kept: bool = False, data=None) -> None:
        raw = serialized(text) if data is None else data
        self.seq += 1
        await self.media.say(
            TapMessage(
                number=number, seq=self.seq, log_us=self.seq * 1_000_000, kept=kept,
                size=len(raw), data=raw,
            )
        )  # fmt: skip

    async def publish_large(self, letter: str) -> None:
        """Publish more than half of what may be under way, in pieces."""
        raw = serialized(letter * 700_000)
        self.seq += 1
        for at in range(0, len(raw), PIECE):
            await self.media.say(
                TapMessage(
                    number=1, seq=self.seq, log_us=self.seq * 1_000_000, kept=False,
                    at=at, size=len(raw), data=raw[at : at + PIECE],
                )
            )  # fmt: skip

    async def until_asked(self, *topics: str) -> None:
        await self.gateway.hear(TapSubscription, lambda asked: set(asked.topics) == set(topics))


@pytest.fixture
async def robot(hub):
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + RULES)
    media = await hub.camera()
    await media.say(TopicList(topics=ENTRIES))
    async with asyncio.timeout(PATIENCE_S):
        taker = hub.hub.core.taps.taker(None)
        hub.hub.core.taps.follow_topics("agv", taker)
        while not hub.hub.core.taps.topics("agv", None):
            await taker.next_event()
    hub.hub.core.taps.remove_taker(taker)
    return Robot(hub, gateway, media)


async def followed(robot, topic: str = "/said", name: str = "operator", more: str = ""):
    """Follow a topic until the robot is heard for it."""
    page = await robot.hub.follower(name, topic, more)
    asked = await robot.gateway.hear(TapSubscription)
    if not asked.topics:
        assert asked.types == [KIND]
        await robot.media.say(SCHEMA)
        await robot.until_asked(topic)
    await page.hear(browser.TopicUpdate, lambda told: told.definition != "")
    return page


async def heard(page, text: str) -> browser.TopicMessage:
    """Wait for a message and confirm it."""
    message = await page.hear(
        browser.TopicMessage, lambda said: msgspec.json.decode(said.tree) == {"data": text}
    )
    await page.say(browser.TopicShown(number=message.number))
    return message


async def tree_of(page) -> object:
    return msgspec.json.decode((await page.hear(browser.TopicMessage)).tree)


async def test_page_gets_what_the_robot_publishes_read_by_its_definition(robot) -> None:
    page = await followed(robot)
    await robot.publish("hello")
    message = await heard(page, "hello")
    assert (message.seq, message.time_us, message.size) == (1, 1_000_000, len(serialized("hello")))
    told = (await (await robot.hub.client("operator")).get("/api/sites/agv/topics")).json()
    assert told["topics"][0]["rate"] == 0
    await robot.publish("again")
    await heard(page, "again")
    # One a second, by what the gateway counts.
    told = (await (await robot.hub.client("operator")).get("/api/sites/agv/topics")).json()
    assert (told["topics"][0]["rate"], told["topics"][0]["right"]) == (1, "view")


async def test_json_form_says_the_same(robot) -> None:
    page = await robot.hub.follower("operator", "/said", "&form=json")
    update = await page.hear(browser.TopicUpdate)
    assert (update.listed, update.type, update.latched) == (True, KIND, False)
    await robot.media.say(SCHEMA)
    await robot.until_asked("/said")
    await robot.publish("text")
    await heard(page, "text")


async def test_robot_is_heard_only_while_a_page_follows(robot) -> None:
    assert not [said for said in robot.gateway.heard if isinstance(said, TapSubscription)]
    page = await followed(robot)
    second = await robot.hub.follower("admin", "/said")
    await second.hear(browser.TopicUpdate, lambda told: told.definition != "")
    await robot.publish("both")
    await asyncio.gather(heard(page, "both"), heard(second, "both"))
    await page.close()
    await robot.publish("one")
    await heard(second, "one")
    await second.close()
    # Asked once for both of them, and told once that nobody wants it any more.
    await robot.until_asked()
    assert not [said for said in robot.gateway.heard if isinstance(said, TapSubscription)]


@pytest.mark.parametrize(
    ("name", "topic"),
    [
        ("guest", "/said"),
        ("operator", "/secret"),
        ("operator", "/other"),
        ("operator", "said"),
        ("operator", ""),
        ("admin", "/" + "x" * 200),
    ],
)
async def test_topic_that_a_person_may_not_tap_is_as_if_it_were_not_there(
    robot, name, topic
) -> None:
    with pytest.raises(websockets.InvalidStatus) as refused:
        await robot.hub.follower(name, topic)
    assert refused.value.response.status_code == 404
    assert b"there is no such topic" in refused.value.response.body


async def test_topic_ends_when_the_description_takes_it_away(robot) -> None:
    page = await followed(robot)
    addresses = [channel.address for channel in load_site(DESCRIPTION).channels()]
    await robot.gateway.say(
        DescriptionUpdate(
            description=compress_text(DESCRIPTION), catalogue="c1", addresses=addresses
        )
    )
    problem = await page.hear(browser.RequestError)
    assert problem.code == "forbidden"
    assert await page.closed() == 1000
    await robot.until_asked()


async def test_topic_ends_with_the_rights_of_the_person(robot) -> None:
    page = await followed(robot)
    await robot.hub.people.set_role("operator", "guest")
    assert (await page.hear(browser.SessionEnded)).reason
    assert await page.closed() == 4401
    await robot.until_asked()


async def test_page_that_confirms_nothing_gets_a_few_and_then_the_newest(robot) -> None:
    page = await followed(robot)
    second = await robot.hub.follower("admin", "/said")
    await second.hear(browser.TopicUpdate, lambda told: told.definition != "")
    for at in range(7):
        await robot.publish(f"said {at}")
        if at < 4:
            sent = await page.hear(browser.TopicMessage)
        # Who reads is not held up by who does not.
        await heard(second, f"said {at}")
    assert not [said for said in page.heard if isinstance(said, browser.TopicMessage)]
    await page.say(browser.TopicShown(number=sent.number))
    # One was in hand; of those that waited behind it the newest comes.
    assert [await tree_of(page) for _ in range(2)] == [{"data": "said 4"}, {"data": "said 6"}]


async def test_of_large_messages_one_is_under_way_and_then_the_newest_goes(robot) -> None:
    page = await followed(robot, more="&as=bytes")
    second = await robot.hub.follower("admin", "/said", "&as=bytes")
    await second.hear(browser.TopicUpdate, lambda told: told.definition != "")
    for letter in "abcd":
        await robot.publish_large(letter)
        # Who reads is not held up by who does not.
        got = await second.hear(browser.TopicBytes)
        await second.say(browser.TopicShown(number=got.number))
        assert got.data[8:9] == letter.encode()
    first = await page.hear(browser.TopicBytes)
    assert not [said for said in page.heard if isinstance(said, browser.TopicBytes)]
    await page.say(browser.TopicShown(number=first.number))
    newest = await page.hear(browser.TopicBytes)
    assert (first.data[8:9], newest.data[8:9], newest.number) == (b"a", b"d", 2)


async def test_topic_that_comes_seldom_loses_nothing(robot) -> None:
    page = await followed(robot)
    for at in range(12):
        await robot.publish(f"seldom {at}", kept=True)
    for at in range(12):
        await heard(page, f"seldom {at}")


async def test_message_that_cannot_be_read_is_told_once_and_the_next_one_is_read(robot) -> None:
    page = await followed(robot)
    for _ in range(3):
        await robot.publish("", kept=True, data=b"\0\1\0\0\xff")
    await robot.publish("good", kept=True)
    await heard(page, "good")
    problems = [said for said in page.heard if isinstance(said, browser.RequestError)]
    assert [problem.code for problem in problems] == ["unreadable"]


async def test_type_without_a_definition_is_told(robot) -> None:
    page = await robot.hub.follower("operator", "/said")
    await robot.gateway.hear(TapSubscription)
    await robot.media.say(TapSchema(type=KIND, problem="nobody describes it"))
    problem = await page.hear(browser.RequestError)
    assert (problem.code, problem.message) == ("unreadable", "nobody describes it")


async def test_who_followed_what_is_in_the_audit_log(robot) -> None:
    page = await followed(robot)
    await page.close()
    await robot.until_asked()
    admin = await robot.hub.client("admin")

    log = robot.hub.hub.audit.log
    await log.wait_written()
    found = (await admin.get("/api/audit", params={"kind": "topic"})).json()["rows"]
    rows = [(row["kind"], row["who"], row["site"], row["message"]) for row in found]
    assert sorted(rows) == [
        ("topic closed", "operator", "agv", "/said"),
        ("topic opened", "operator", "agv", "/said"),
    ]


async def test_hostile_frames_of_a_page_end_its_socket_and_nothing_else(robot) -> None:
    page = await robot.hub.follower("operator", "/said")
    await page.connection.send(b"\xc1 no message")
    assert await page.closed() == 1002
    assert await followed(robot, name="admin")
