"""Raw topics over a hub that really serves: who is told which, and who gets what."""

from __future__ import annotations

import asyncio

from patience import PATIENCE_S

from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.live.taps.tapped import TapBegun, TapDelivery
from talaia.wire.browser import SiteUpdate
from talaia.wire.frames import (
    TapMessage,
    TapSchema,
    TapSubscription,
    TopicEntry,
    TopicList,
)

from ...conftest import DESCRIPTION

RULES = """
topics:
  - {pattern: /odom, right: view}
  - {pattern: /secret, right: admin}
"""
ENTRIES = [
    TopicEntry(number=1, topic="/odom", type="nav_msgs/msg/Odometry"),
    TopicEntry(number=2, topic="/secret", type="std_msgs/msg/String", why="its type is not known"),
    TopicEntry(number=3, topic="/other", type="std_msgs/msg/String", latched=True),
]
VIEWER = Grants(frozenset({Permission(Right.VIEW)}))


async def listed(hub, name: str) -> dict:
    return (await (await hub.client(name)).get("/api/sites/agv/topics")).json()


async def until_listed(hub) -> None:
    async with asyncio.timeout(PATIENCE_S):
        taker = hub.hub.core.taps.taker(None)
        hub.hub.core.taps.follow_topics("agv", taker)
        while not hub.hub.core.taps.topics("agv", None):
            await taker.next_event()


async def test_everyone_is_told_of_the_topics_that_they_may_tap(hub) -> None:
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + RULES)
    media = await hub.camera()
    await media.say(TopicList(topics=ENTRIES))
    await until_listed(hub)
    assert await listed(hub, "guest") == {"online": True, "topics": []}
    operator = (await listed(hub, "operator"))["topics"]
    assert operator == [
        {
            "topic": "/odom",
            "type": "nav_msgs/msg/Odometry",
            "latched": False,
            "max_rate": 0.0,
            "problem": "",
            "described": True,
            "right": "view",
            "device": "",
            "rate": 0.0,
            "camera": "",
        }
    ]
    admin = {found["topic"]: found for found in (await listed(hub, "admin"))["topics"]}
    assert set(admin) == {"/odom", "/secret", "/other"}
    assert (admin["/secret"]["problem"], admin["/other"]["latched"]) == (
        "its type is not known",
        True,
    )
    # A topic that no rule names is for who has the right `tap`.
    assert (admin["/other"]["described"], admin["/other"]["right"]) == (False, "tap")
    await gateway.close()
    page = await hub.page("operator")
    await page.hear(SiteUpdate, lambda site: not site.online)
    assert await listed(hub, "operator") == {"online": False, "topics": operator}


async def test_messages_come_over_the_connection_for_pictures(hub) -> None:
    gateway = await hub.gateway()
    welcome = await gateway.hello(DESCRIPTION + RULES)
    assert "topic_list" in welcome.takes
    media = await hub.camera()
    await media.say(TopicList(topics=ENTRIES))
    await until_listed(hub)
    fanout = hub.hub.core.taps
    taker = fanout.taker(VIEWER)
    fanout.subscribe("agv", "/odom", taker)
    asked = await gateway.hear(TapSubscription)
    assert (asked.topics, asked.types) == ({}, ["nav_msgs/msg/Odometry"])
    await media.say(TapSchema(type="nav_msgs/msg/Odometry", message_encoding="cdr"))
    assert (await gateway.hear(TapSubscription)).topics == {"/odom": 0.0}
    await media.say(TapMessage(number=1, seq=1, size=4, data=b"left"))
    await media.say(TapMessage(number=1, seq=2, size=4, at=2, data=b"!!"))
    await media.say(TapMessage(number=1, seq=3, size=4, data=b"ri"))
    await media.say(TapMessage(number=1, seq=3, size=4, at=2, data=b"ng"))
    async with asyncio.timeout(PATIENCE_S):
        got = [await taker.next_event() for _ in range(3)]
    assert [type(event) for event in got] == [TapBegun, TapDelivery, TapDelivery]
    assert [event.message.data for event in got[1:]] == [b"left", b"ring"]
    fanout.remove_taker(taker)
    assert (await gateway.hear(TapSubscription)).topics == {}


async def test_a_gateway_of_former_times_is_asked_for_nothing(hub) -> None:
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + RULES)
    await hub.page("operator")
    assert not [said for said in gateway.heard if isinstance(said, TapSubscription)]
