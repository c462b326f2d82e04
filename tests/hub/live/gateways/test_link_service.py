"""From the gateway to pages: values, acknowledgements, coming and going."""

import json
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from talaia.hub.live.gateways import ingest
from talaia.model.yaml_text.load import load_site
from talaia.wire.browser import (
    Greeting,
    PagePing,
    PagePong,
    RequestError,
    SiteUpdate,
    Subscribe,
    Subscribed,
    Unsubscribe,
    Values,
)  # fmt: skip
from talaia.wire.columns import unpack_columns
from talaia.wire.frames import Ack, Beat, BeatReply, Bye, Hello, ResendRequest, SampleGap, Welcome
from talaia.wire.message import PROTOCOL, is_compatible

from ...conftest import RunningHub

RECORDED = Path(__file__).parents[3] / "wire" / "recorded" / "first.json"
NOW = 1_700_000_000_000_000
# A device that comes before all others, and so moves the number of each of their channels.
APRON = """  apron:
    name: Apron
    signals:
      light: {name: Light, source: {topic: /light, type: std_msgs/msg/Float64, field: data}}
"""


def columns(values: Values):
    return unpack_columns(values)


async def subscribed(page, *channels: str, every_ms: int = 0, sub: int = 1) -> Subscribed:
    await page.say(Subscribe(sub=sub, site="agv", channels=list(channels), every_ms=every_ms))
    return await page.hear(Subscribed)


async def test_page_is_greeted_with_who_it_is_and_which_sites_there_are(hub, gateway) -> None:
    page = await hub.page("operator")
    greeting = await page.hear(Greeting)
    assert (greeting.who, greeting.role) == ("operator", "operator")
    assert (await page.hear(SiteUpdate)).online


@pytest.mark.parametrize("text", [False, True])
async def test_sample_reaches_a_page_that_asked_for_it(hub, gateway, text) -> None:
    page = await hub.page("operator", text=text)
    await subscribed(page, "power/charge", "base/speed")
    await gateway.samples(("base/speed", NOW, 0.5), ("base/turn_rate", NOW, 9.0))
    got = columns(await page.hear(Values))
    assert got.channel.tolist() == [1]
    assert got.value.tolist() == [0.5]
    assert got.time_us.tolist() == [NOW]


async def test_first_values_hold_what_is_known_with_its_age(hub, gateway) -> None:
    await gateway.samples(("base/speed", NOW, 0.25))
    await gateway.hear(Ack)
    page = await hub.page("operator")
    await subscribed(page, "power/charge", "base/speed")
    values = await page.hear(Values)
    assert columns(values).channel.tolist() == [1]
    assert columns(values).value.tolist() == [0.25]
    assert len(values.age_ms) == 1
    assert 0 <= values.age_ms[0] < 5000


async def test_paced_subscription_gathers_and_keeps_extremes(hub, gateway) -> None:
    page = await hub.page("operator")
    await subscribed(page, "base/speed", every_ms=100)
    await gateway.samples(("base/speed", NOW - 1, 0.0))
    await page.hear(Values)
    rows = [("base/speed", NOW + at, float(np.sin(at))) for at in range(50)]
    await gateway.samples(*rows)
    got = columns(await page.hear(Values)).value
    every = [row[2] for row in rows]
    assert {every[0], every[-1], min(every), max(every)} == set(got.tolist())


async def test_channels_that_are_not_there_or_not_for_a_guest_are_refused(hub, gateway) -> None:
    page = await hub.page("guest")
    answer = await subscribed(page, "base/speed", "base/turn_rate", "nothing/here")
    assert answer.refused == ["base/turn_rate", "nothing/here"]
    await gateway.samples(("base/turn_rate", NOW, 1.0), ("base/speed", NOW, 0.5))
    assert columns(await page.hear(Values)).value.tolist() == [0.5]


async def test_samples_are_acknowledged_only_when_they_are_stored(hub, gateway, history) -> None:
    page = await hub.page("operator")
    await subscribed(page, "base/speed")
    history.gate.clear()
    await gateway.samples(("base/speed", NOW, 0.5))
    # Live values do not wait for the disk.
    await page.hear(Values)
    assert not any(isinstance(message, Ack) for message in gateway.heard)
    history.gate.set()
    assert await gateway.hear(Ack) == Ack(boot="boot-1", below=1)
    assert history.samples["agv", "boot-1"][0] == ("base/speed", NOW, 0.5, "")


async def test_acknowledgement_stays_below_the_first_hole(hub, gateway) -> None:
    await gateway.samples(("base/speed", NOW, 3.0), first=3)
    assert (await gateway.hear(Ack)).below == 0
    await gateway.samples(("base/speed", NOW, 0.0), ("base/speed", NOW, 1.0), first=0, live=False)
    assert (await gateway.hear(Ack)).below == 2
    await gateway.say(
        SampleGap(boot="boot-1", first=2, last=2, from_us=1, to_us=2, reason="disk full")
    )
    assert (await gateway.hear(Ack)).below == 4


async def test_old_samples_are_stored_and_not_shown_as_live(hub, gateway) -> None:
    page = await hub.page("operator")
    await subscribed(page, "base/speed")
    await gateway.samples(("base/speed", NOW, 1.0), live=False)
    await gateway.samples(("base/speed", NOW, 2.0))
    assert columns(await page.hear(Values)).value.tolist() == [2.0]
    assert (await gateway.hear(Ack, lambda ack: ack.below == 2)).boot == "boot-1"


async def test_gateway_that_comes_back_is_told_what_is_stored(hub, gateway) -> None:
    await gateway.samples(("base/speed", NOW, 1.0))
    await gateway.hear(Ack)
    await gateway.close()
    again = await hub.gateway()
    assert (await again.hello()).acked == 1


async def test_page_sees_its_site_go_and_come(hub, gateway) -> None:
    page = await hub.page("operator")
    await page.hear(SiteUpdate, lambda news: news.online)
    await gateway.close()
    gone = await page.hear(SiteUpdate, lambda news: not news.online)
    assert gone.why
    await (await hub.gateway()).hello()
    await page.hear(SiteUpdate, lambda news: news.online)


async def test_gateway_and_page_of_a_later_version_are_understood(hub) -> None:
    gateway = await hub.gateway()
    text = gateway.description
    await gateway.say(Hello(protocol=2, site="agv", boot="b", catalogue="c1", description=text))
    await gateway.hear(Welcome)
    await gateway.close()
    gateway = await hub.gateway()
    await gateway.hello()
    await gateway.connection.send(msgspec.msgpack.encode({"t": "from_the_future", "x": 1}))
    await gateway.samples(("base/speed", NOW, 0.5))
    await gateway.hear(Ack)
    page = await hub.page("operator")
    await page.connection.send(msgspec.msgpack.encode({"t": "from_the_future", "x": 1}))
    problem = await page.hear(RequestError)
    assert (problem.code, problem.about) == ("unknown", "from_the_future")
    assert (await subscribed(page, "base/speed")).refused == []


async def test_gateway_of_an_earlier_version_is_taken_in_by_the_hello_it_recorded(hub) -> None:
    rows = json.loads(RECORDED.read_text())
    hello = msgspec.msgpack.decode(bytes.fromhex(rows[0]["frame"]))
    assert rows[0]["kind"] == "Hello"
    gateway = await hub.gateway()
    own = {"protocol": PROTOCOL - 1, "site": "agv", "description": gateway.description}
    await gateway.connection.send(msgspec.msgpack.encode({**hello, **own}))
    assert is_compatible((await gateway.hear(Welcome)).protocol)
    await gateway.close()
    gateway = await hub.gateway()
    await gateway.connection.send(
        msgspec.msgpack.encode({**hello, **own, "protocol": PROTOCOL + 2})
    )
    assert "update" in (await gateway.hear(Bye)).reason


async def test_what_the_hub_has_no_room_for_is_asked_for_again_and_nothing_else_waits(
    hub, gateway, history, monkeypatch
) -> None:
    monkeypatch.setattr(ingest, "_MOST_WAITING", 3)
    monkeypatch.setattr(ingest, "_ROOM", 1)
    page = await hub.page("operator")
    await subscribed(page, "base/speed")
    history.gate.clear()
    for number in range(10):
        await gateway.samples(("base/speed", NOW + number, float(number)))
        # Live values and beats do not wait for the database.
        await page.hear(Values)
    await gateway.say(Beat(n=1, mono_us=1))
    await gateway.hear(BeatReply)
    history.gate.set()
    again = await gateway.hear(ResendRequest)
    assert again.boot == "boot-1"
    assert again.below == 10
    assert 3 <= again.first <= 5
    for number in range(again.first, 10):
        row = ("base/speed", NOW + number, float(number))
        await gateway.samples(row, first=number, live=False)
        await gateway.hear(Ack)
    assert sorted(history.samples["agv", "boot-1"]) == [*range(10)]


async def test_description_with_a_mistake_is_refused_with_the_path_to_it(hub) -> None:
    gateway = await hub.gateway()
    mistaken = "talaia: 1\nsite: agv\nname: X\ndevices: {base: {nam: B}}"
    await gateway.say(Hello(site="agv", boot="b", catalogue="c", description=mistaken))
    assert "$.devices.base" in (await gateway.hear(Bye)).reason
    assert await gateway.closed() == 4400


async def test_garbage_from_a_gateway_closes_its_link_and_nothing_else(hub, gateway) -> None:
    page = await hub.page("operator")
    await gateway.connection.send(b"\xc1garbage")
    assert await gateway.closed() == 1002
    await page.hear(SiteUpdate, lambda news: not news.online)


async def test_gateway_that_falls_silent_is_gone_after_three_beats(hub) -> None:
    page = await hub.page("operator")
    gateway = await hub.gateway()
    await gateway.hello()
    gateway.take = lambda message: super(type(gateway), gateway).take(message)
    await page.hear(SiteUpdate, lambda news: not news.online)


async def test_changed_description_renews_subscriptions(hub, gateway) -> None:
    page = await hub.page("operator")
    assert (await subscribed(page, "power/charge")).refused == []
    second = await hub.gateway()
    await second.hello(second.description.replace("charge:", "level:"))
    assert (await page.hear(Subscribed)).refused == ["power/charge"]


@pytest.mark.parametrize("every_ms", [0, 20])
async def test_pages_that_share_a_channel_keep_it_when_a_description_moves_its_number(
    hub, gateway, every_ms
) -> None:
    pages = [await hub.page("operator"), await hub.page("admin")]
    for page in pages:
        await subscribed(page, "base/speed", every_ms=every_ms)
    await gateway.close()
    second = await hub.gateway()
    changed = second.description.replace("devices:\n", f"devices:\n{APRON}", 1)
    await second.hello(changed)
    second.channels = {
        channel.address: at for at, channel in enumerate(load_site(changed).channels())
    }
    assert second.channels["base/speed"] > gateway.channels["base/speed"]
    for page in pages:
        await page.hear(Subscribed)
    # Every channel has a value of its own, so that another one's is told from it.
    await second.samples(*[(address, NOW, float(at)) for address, at in second.channels.items()])
    for page in pages:
        values = columns(await page.hear(Values))
        assert values.value.tolist() == [float(second.channels["base/speed"])]


async def test_address_that_is_asked_twice_is_sent_once(hub, gateway) -> None:
    page = await hub.page("operator")
    answer = await subscribed(page, "base/speed", "base/speed")
    assert answer.refused == []
    await gateway.samples(("base/speed", NOW, 0.5))
    assert columns(await page.hear(Values)).channel.tolist() == [0]


async def test_subscription_asked_for_while_the_database_was_away_is_granted_by_itself(
    hub, gateway, monkeypatch
) -> None:
    page = await hub.page("operator")
    await page.hear(SiteUpdate)
    seats = type(hub.hub.people.seats)
    monkeypatch.setattr(seats, "sure", property(lambda _: False))
    await page.say(Subscribe(sub=1, site="agv", channels=["base/speed"], every_ms=0))
    await page.say(Subscribe(sub=2, site="agv", channels=["base/speed"], every_ms=0))
    for _ in range(2):
        assert (await page.hear(RequestError)).code == "store"
    # One it does not want any more.
    await page.say(Unsubscribe(sub=2))
    await page.say(PagePing(n=1, at_ms=0.0))
    await page.hear(PagePong)
    await gateway.samples(("base/speed", NOW, 0.5))
    await gateway.hear(Ack)
    monkeypatch.setattr(seats, "sure", property(lambda _: True))
    assert (await page.hear(Subscribed)).sub == 1
    assert columns(await page.hear(Values)).value.tolist() == [0.5]
    await gateway.samples(("base/speed", NOW + 1, 0.75))
    assert (await page.hear(Values)).sub == 1
    assert not [each for each in page.heard if isinstance(each, Subscribed)]


async def test_a_gateway_is_served_while_the_server_of_its_history_is_away(settings) -> None:
    disk = settings.data / "disk"
    servers = settings.data / "servers.yaml"
    servers.write_text(f"servers: {{east: 'sqlite:///{disk}/talaia.db'}}\ndefault: east\n")
    async with RunningHub(replace(settings, history_servers=servers), None) as hub:
        await hub.populate()
        # One that does not say what it was told could take any answer for lost samples.
        older = await hub.gateway()
        await older.say(older.hello_message())
        assert (await older.hear(Bye)).after_s > 0
        gateway = await hub.gateway()
        gateway.acked = 7
        # What it was told stays: neither more is stored, nor is anything lost.
        assert (await gateway.hello()).acked == 7
        page = await hub.page("operator")
        await subscribed(page, "power/charge", "base/speed")
        await gateway.samples(("base/speed", NOW, 0.5), first=7)
        assert columns(await page.hear(Values)).value.tolist() == [0.5]
        asked = await (await hub.client("operator")).get(
            "/api/sites/agv/history", params={"channel": "base/speed", "from_us": 0, "to_us": 1}
        )
        assert (asked.status_code, asked.json()["code"]) == (503, "history")
        assert not [message for message in gateway.heard if isinstance(message, Ack)]
        disk.mkdir()
        await hub.hub.history.store.mend_servers()
        # Sent before, and kept: it is stored by itself; what came before it is still missing.
        assert (await gateway.hear(Ack)).below == 0
        await gateway.samples(*[("base/speed", NOW - 9 + at, 0.25) for at in range(7)], first=0)
        await gateway.hear(Ack, lambda ack: ack.below == 8)


async def test_a_hub_that_starts_without_the_server_of_a_history_says_so(settings) -> None:
    disk = settings.data / "disk"
    disk.mkdir()
    servers = settings.data / "servers.yaml"
    servers.write_text(f"servers: {{east: 'sqlite:///{disk}/talaia.db'}}\ndefault: east\n")
    settings = replace(settings, history_servers=servers)
    async with RunningHub(settings, None) as hub:
        await hub.populate()
        gateway = await hub.gateway()
        await gateway.hello()
        await gateway.samples(("base/speed", NOW, 0.5))
        await gateway.hear(Ack, lambda ack: ack.below == 1)
        keys = hub.keys
    disk.rename(settings.data / "elsewhere")
    async with RunningHub(settings, None) as hub:
        page = await hub.page("operator")
        site = await page.hear(SiteUpdate)
        assert "its history is on a server that is away" in site.why
        outlook = (await (await hub.client("admin")).get("/api/storage/outlook")).json()
        assert "the history of agv is on 'east', which is away" in outlook["trouble"]
        (settings.data / "elsewhere").rename(disk)
        gateway = await hub.gateway(key=keys["agv"])
        gateway.acked, gateway.sequence = 1, 1
        assert (await gateway.hello()).acked == 1
        await gateway.samples(("base/speed", NOW + 1, 0.75))
        await hub.hub.history.store.mend_servers()
        await gateway.hear(Ack, lambda ack: ack.below == 2)
        found = await hub.hub.history.store.read_series("agv", ["base/speed"], 0, 2**62, width=9)
        assert found[0].value.tolist() == [0.5, 0.75]
