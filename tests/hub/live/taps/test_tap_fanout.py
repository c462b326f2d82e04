"""Raw topics at the hub: one copy for all, rights at every turn, nobody waits for anybody."""

from __future__ import annotations

import asyncio

import pytest

from talaia.clock import SECOND, HandClock
from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.errors import TapRefused
from talaia.hub.live.site_state import LinkedGateway
from talaia.hub.live.sites import Sites
from talaia.hub.live.taps.tap_fanout import TapFanout
from talaia.hub.live.taps.tapped import (
    TapBegun,
    TapDelivery,
    TapEnded,
    TapTrouble,
    TopicsChanged,
)
from talaia.model.yaml_text.load import load_site
from talaia.wire.errors import PeerError
from talaia.wire.frames import (
    PIECE,
    TapError,
    TapMessage,
    TapSchema,
    TapSubscription,
    TopicEntry,
    TopicList,
)

DESCRIPTION = """
talaia: 1
site: farm
name: Farm
ros2: {}
devices:
  barn: {name: Barn}
  gate: {name: Gate}
topics:
  - {pattern: /scan, right: view, device: barn}
  - {pattern: /secret, right: admin}
  - {pattern: /slow, right: view, max_rate: 5}
  - {pattern: /**, right: use}
"""
# As above, but nothing is open any more.
SHUT = DESCRIPTION.partition("topics:")[0]
GUEST = Grants()
VIEWER = Grants(frozenset({Permission(Right.VIEW)}))
BARN_VIEWER = Grants(frozenset({Permission(Right.VIEW, "farm", "barn")}))
OPERATOR = Grants(frozenset({Permission(Right.USE)}))
TAPPER = Grants(frozenset({Permission(Right.TAP)}))
ADMIN = Grants(frozenset({Permission(Right.ADMIN)}))
ENTRIES = [
    TopicEntry(number=1, topic="/scan", type="sensor_msgs/msg/LaserScan"),
    TopicEntry(number=2, topic="/secret", type="std_msgs/msg/String"),
    TopicEntry(number=3, topic="/slow", type="std_msgs/msg/String"),
    TopicEntry(number=4, topic="/map", type="nav_msgs/msg/OccupancyGrid", latched=True),
]


class Gateway:
    """What a gateway would be asked, and what it would say."""

    def __init__(self, fanout: TapFanout) -> None:  # noqa: D107
        self.asked: list[TapSubscription] = []
        self._fanout = fanout
        self._seq = 0

    def send(self, message) -> None:
        self.asked.append(message)

    def dismiss(self, reason: str) -> None: ...

    async def now(self) -> TapSubscription:
        """Tell the schemas that are asked for; give what is wanted then."""
        while True:
            await asyncio.sleep(0)
            await asyncio.sleep(0)
            if not self.asked or not self.asked[-1].types:
                return self.asked[-1] if self.asked else TapSubscription()
            for name in self.asked[-1].types:
                self.say(
                    TapSchema(
                        type=name, encoding="ros2msg", definition="int8 x", message_encoding="cdr"
                    )
                )

    def say(self, message) -> None:
        self._fanout.receive("farm", message)

    def publish(self, number: int, data: bytes, *, log_us: int = 0, kept: bool = False) -> None:
        self._seq += 1
        for at in range(0, max(1, len(data)), PIECE):
            self.say(
                TapMessage(
                    number=number,
                    seq=self._seq,
                    log_us=log_us,
                    kept=kept,
                    size=len(data),
                    at=at,
                    data=data[at : at + PIECE],
                )
            )


@pytest.fixture
def sites() -> Sites:
    found = Sites()
    found.describe_site(load_site(DESCRIPTION), "c1")
    return found


@pytest.fixture
def clock() -> HandClock:
    return HandClock()


@pytest.fixture
def fanout(sites, clock) -> TapFanout:
    return TapFanout(sites, clock, schema_s=0.05)


@pytest.fixture
async def gateway(sites, fanout) -> Gateway:
    return connected(sites, fanout)


def connected(sites: Sites, fanout: TapFanout) -> Gateway:
    gateway = Gateway(fanout)
    sites.find_site("farm").attach_link(gateway, LinkedGateway(), 0)
    fanout.link_up("farm")
    gateway.say(TopicList(topics=ENTRIES))
    return gateway


def events(taker) -> list:
    found = []
    while (event := taker.pop_event()) is not None:
        found.append(event)
    return found


def messages(taker) -> list[bytes]:
    return [event.message.data for event in events(taker) if isinstance(event, TapDelivery)]


@pytest.mark.parametrize(
    ("grants", "open_to_them"),
    [
        (GUEST, []),
        (BARN_VIEWER, ["/scan"]),
        (VIEWER, ["/scan", "/slow"]),
        (OPERATOR, ["/map", "/scan", "/slow"]),
        (TAPPER, ["/map", "/scan", "/slow"]),
        (ADMIN, ["/map", "/scan", "/secret", "/slow"]),
        (None, ["/map", "/scan", "/secret", "/slow"]),
    ],
)
async def test_everyone_gets_what_the_rules_open_to_them_and_nothing_else(
    fanout, gateway, grants, open_to_them
) -> None:
    assert [found.topic for found in fanout.topics("farm", grants)] == open_to_them
    taker = fanout.taker(grants)
    for entry in ENTRIES:
        if entry.topic in open_to_them:
            fanout.subscribe("farm", entry.topic, taker)
        else:
            with pytest.raises(TapRefused):
                fanout.subscribe("farm", entry.topic, taker)
            with pytest.raises(TapRefused):
                await fanout.schema("farm", entry.topic, grants)
    assert sorted((await gateway.now()).topics) == open_to_them
    events(taker)
    for entry in ENTRIES:
        gateway.publish(entry.number, entry.topic.encode())
    assert sorted(messages(taker)) == [topic.encode() for topic in open_to_them]


async def test_what_no_rule_names_is_for_admins_and_those_who_may_tap(sites, fanout, gateway):
    fanout.redescribe(sites.describe_site(load_site(SHUT), "c1"))
    assert not fanout.topics("farm", OPERATOR)
    assert len(fanout.topics("farm", ADMIN)) == len(fanout.topics("farm", TAPPER)) == len(ENTRIES)


async def test_a_topic_is_asked_for_once_for_all_and_rests_after_the_last(fanout, gateway) -> None:
    first, second = fanout.taker(VIEWER), fanout.taker(VIEWER)
    assert not gateway.asked
    fanout.subscribe("farm", "/scan", first)
    fanout.subscribe("farm", "/scan", second)
    assert (await gateway.now()).topics == {"/scan": 0.0}
    count = len(gateway.asked)
    fanout.remove_taker(first)
    await gateway.now()
    assert len(gateway.asked) == count
    fanout.remove_taker(second)
    assert (await gateway.now()).topics == {}


async def test_the_greatest_rate_is_asked_for_and_no_more_than_the_rule_allows(fanout, gateway):
    takers = [fanout.taker(OPERATOR) for _ in range(3)]
    fanout.subscribe("farm", "/map", takers[0], max_rate=2)
    fanout.subscribe("farm", "/map", takers[1], max_rate=10)
    fanout.subscribe("farm", "/slow", takers[1])
    assert (await gateway.now()).topics == {"/map": 10.0, "/slow": 5.0}
    fanout.subscribe("farm", "/map", takers[2])
    fanout.subscribe("farm", "/slow", takers[1], max_rate=1)
    assert (await gateway.now()).topics == {"/map": 0.0, "/slow": 1.0}


async def test_each_taker_gets_it_at_its_own_rate_but_for_what_comes_seldom(fanout, gateway):
    calm, eager = fanout.taker(VIEWER), fanout.taker(VIEWER)
    fanout.subscribe("farm", "/scan", calm, max_rate=5)
    fanout.subscribe("farm", "/scan", eager)
    await gateway.now()
    for number in range(95):
        gateway.publish(1, b"%d" % number, log_us=number * 10_000)
    assert len(messages(calm)) == 5
    assert len(messages(eager)) == 95
    gateway.publish(1, b"a", log_us=1_000_001, kept=True)
    gateway.publish(1, b"b", log_us=1_000_002, kept=True)
    assert messages(calm) == [b"a", b"b"]


async def test_the_bytes_are_the_same_object_for_all(fanout, gateway) -> None:
    takers = [fanout.taker(VIEWER) for _ in range(3)]
    for taker in takers:
        fanout.subscribe("farm", "/scan", taker)
    await gateway.now()
    gateway.publish(1, bytes(1_000_000))
    got = {id(event.message.data) for taker in takers for event in events(taker)[1:]}
    assert len(got) == 1


async def test_how_it_is_read_is_told_before_the_first_message(fanout, gateway) -> None:
    taker = fanout.taker(VIEWER)
    fanout.subscribe("farm", "/scan", taker)
    await gateway.now()
    gateway.publish(1, b"x")
    begun, delivered = events(taker)
    assert isinstance(begun, TapBegun)
    assert begun.schema.type == "sensor_msgs/msg/LaserScan"
    assert delivered.tap is begun.tap
    # Its type is another one from here on.
    gateway.say(TopicList(topics=[TopicEntry(number=9, topic="/scan", type="a/msg/B")]))
    await gateway.now()
    gateway.publish(1, b"late")
    gateway.publish(9, b"y")
    begun, delivered = events(taker)
    assert (begun.schema.type, delivered.message.data) == ("a/msg/B", b"y")


async def test_a_schema_can_be_had_without_hearing_anything(fanout, gateway) -> None:
    asking = asyncio.ensure_future(fanout.schema("farm", "/scan", VIEWER))
    await asyncio.sleep(0)
    assert (await gateway.now()).topics == {}
    assert (await asking).definition == "int8 x"
    # It is known now.
    count = len(gateway.asked)
    assert (await fanout.schema("farm", "/scan", VIEWER)).encoding == "ros2msg"
    assert len(gateway.asked) == count


async def test_a_gateway_that_tells_no_schema_is_not_waited_for_for_ever(fanout, gateway) -> None:
    with pytest.raises(TapRefused, match="does not tell"):
        await fanout.schema("farm", "/scan", VIEWER)


async def test_a_late_taker_gets_the_last_messages_of_a_latched_topic(fanout, gateway) -> None:
    first = fanout.taker(OPERATOR)
    fanout.subscribe("farm", "/map", first)
    await gateway.now()
    gateway.publish(4, b"one", kept=True)
    gateway.publish(4, b"two", kept=True)
    late = fanout.taker(OPERATOR)
    fanout.subscribe("farm", "/map", late)
    assert messages(late) == [b"one", b"two"]
    fanout.remove_taker(first)
    fanout.remove_taker(late)
    # The robot says it again to whoever comes then.
    again = fanout.taker(OPERATOR)
    fanout.subscribe("farm", "/map", again)
    assert messages(again) == []


async def test_a_taker_that_does_not_read_is_bounded_and_holds_up_nobody(
    fanout, gateway, clock
) -> None:
    stuck, reading = fanout.taker(OPERATOR), fanout.taker(OPERATOR)
    for taker in (stuck, reading):
        fanout.subscribe("farm", "/scan", taker)
        fanout.subscribe("farm", "/map", taker)
    await gateway.now()
    events(reading)
    for number in range(100):
        clock.advance(SECOND // 10)
        gateway.publish(1, bytes([number]) * 1_000_000)
        gateway.publish(4, bytes([number]) * 100_000, kept=True)
        assert [data[0] for data in messages(reading)] == [number, number]
        assert stuck.waiting_bytes < 6_000_000
    got = messages(stuck)
    # The newest of what came often, and as much of what is to be kept as is allowed.
    assert [data[0] for data in got if len(data) == 1_000_000] == [99]
    assert [data[0] for data in got if len(data) == 100_000][-1] == 99
    assert len(got) > 20


async def test_a_lost_right_ends_the_tap_at_once(fanout, gateway) -> None:
    taker = fanout.taker(OPERATOR)
    scan = fanout.subscribe("farm", "/scan", taker)
    mapped = fanout.subscribe("farm", "/map", taker)
    await gateway.now()
    gateway.publish(4, b"not read yet")
    fanout.change_grants(taker, VIEWER)
    gateway.publish(4, b"too late")
    gateway.publish(1, b"still open")
    got = events(taker)
    assert [event.tap for event in got if isinstance(event, TapEnded)] == [mapped]
    assert [event.message.data for event in got if isinstance(event, TapDelivery)] == [
        b"still open"
    ]
    assert (await gateway.now()).topics == {"/scan": 0.0}
    fanout.unsubscribe(mapped)
    assert list(taker.taps.values()) == [scan]


async def test_a_rule_that_is_taken_away_ends_the_taps_it_allowed(sites, fanout, gateway) -> None:
    taker = fanout.taker(VIEWER)
    fanout.follow_topics("farm", taker)
    fanout.subscribe("farm", "/scan", taker)
    await gateway.now()
    events(taker)
    fanout.redescribe(sites.describe_site(load_site(SHUT), "c1"))
    gateway.publish(1, b"x")
    ended, changed = events(taker)
    assert isinstance(ended, TapEnded)
    assert changed == TopicsChanged("farm")
    assert (await gateway.now()).topics == {}


async def test_taps_go_on_when_the_gateway_is_back(sites, fanout, gateway) -> None:
    taker = fanout.taker(VIEWER)
    fanout.subscribe("farm", "/scan", taker)
    await gateway.now()
    sites.find_site("farm").detach_link(0)
    fanout.link_lost("farm")
    assert [found.topic for found in fanout.topics("farm", VIEWER)] == ["/scan", "/slow"]
    again = connected(sites, fanout)
    assert (await again.now()).topics == {"/scan": 0.0}
    events(taker)
    again.publish(1, b"again")
    assert messages(taker) == [b"again"]


async def test_a_topic_that_is_not_there_yet_begins_when_it_comes(fanout, gateway) -> None:
    taker = fanout.taker(ADMIN)
    fanout.subscribe("farm", "/later", taker)
    assert (await gateway.now()).topics == {}
    later = TopicEntry(number=7, topic="/later", type="std_msgs/msg/String")
    gateway.say(TopicList(topics=[*ENTRIES, later]))
    assert (await gateway.now()).topics == {"/later": 0.0}
    gateway.publish(7, b"x")
    assert messages(taker) == [b"x"]


async def test_why_messages_are_missing_is_told_once(fanout, gateway) -> None:
    taker = fanout.taker(VIEWER)
    fanout.subscribe("farm", "/scan", taker)
    gateway.say(TapError(topic="/scan", why="too large"))
    gateway.say(TapError(topic="/scan", why="far too large"))
    (told,) = events(taker)
    assert (type(told), told.why) == (TapTrouble, "far too large")


async def test_pieces_that_make_no_message_end_the_connection(fanout, gateway) -> None:
    fanout.subscribe("farm", "/scan", fanout.taker(VIEWER))
    await gateway.now()
    first = TapMessage(number=1, size=10, data=b"12345")
    gateway.say(first)
    with pytest.raises(PeerError):
        gateway.say(TapMessage(number=1, size=10, at=6, data=b"7890"))
    # A message that another cuts short is left out, as is one whose beginning nobody heard.
    fanout.media_lost("farm")
    gateway.say(TapMessage(number=1, size=10, at=5, data=b"67890"))
    gateway.say(first)
    gateway.say(first)
    with pytest.raises(PeerError):
        gateway.say(TapMessage(number=1, size=10, at=5, data=b"678901"))


async def test_next_event_waits_for_what_comes(fanout, gateway) -> None:
    taker = fanout.taker(VIEWER)
    waiting = asyncio.ensure_future(taker.next_event())
    await asyncio.sleep(0)
    assert not waiting.done()
    fanout.subscribe("farm", "/scan", taker)
    await gateway.now()
    assert isinstance(await waiting, TapBegun)


async def test_a_hundred_topics_are_asked_for_at_one_blow(fanout, gateway) -> None:
    entries = [TopicEntry(number=n, topic=f"/t{n}", type="a/msg/B") for n in range(1, 101)]
    gateway.say(TopicList(topics=entries))
    taker = fanout.taker(ADMIN)
    for entry in entries:
        fanout.subscribe("farm", entry.topic, taker)
    assert len((await gateway.now()).topics) == 100
    assert len(gateway.asked) == 2


async def test_a_topic_whose_type_turns_out_to_hold_pictures_ends_where_a_camera_is_blurred(
    sites, fanout, gateway
) -> None:
    eye = "\n    streams: {eye: {name: E, blur: {}, source: {topic: /e, type: our_msgs/msg/Seen}}}"
    blurred = DESCRIPTION.replace("barn: {name: Barn}", "barn:\n    name: Barn" + eye)
    live = sites.describe_site(load_site(blurred), "c2")
    fanout.redescribe(live or sites.find_site("farm"))
    taker = fanout.taker(OPERATOR)
    with pytest.raises(TapRefused):
        fanout.subscribe("farm", "/e", taker)
    # Nobody publishes them yet, so nothing is known of what they hold.
    taps = [fanout.subscribe("farm", name, taker) for name in ("/late", "/hidden", "/map")]
    more = [
        TopicEntry(number=5, topic="/late", type="sensor_msgs/msg/Image"),
        TopicEntry(number=6, topic="/hidden", type="our_msgs/msg/Pair"),
    ]
    gateway.say(TopicList(topics=[*ENTRIES, *more]))
    definition = "std_msgs/Header header\nsensor_msgs/CompressedImage[2] shots"
    gateway.say(TapSchema(type="our_msgs/msg/Pair", encoding="ros2msg", definition=definition))
    gateway.publish(5, b"a face")
    gateway.publish(6, b"another")
    got = events(taker)
    assert [event.tap for event in got if isinstance(event, TapEnded)] == taps[:2]
    assert not [event for event in got if isinstance(event, TapDelivery)]
    assert set((await gateway.now()).topics) == {"/map"}
    # Whoever has the right has them.
    watch = {Permission(Right.USE), Permission(Right.UNBLURRED)}
    fanout.subscribe("farm", "/late", fanout.taker(Grants(frozenset(watch))))
    assert set((await gateway.now()).topics) == {"/map", "/late"}
