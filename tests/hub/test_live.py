"""From the gateway to pages: values, acknowledgements, coming and going."""

import numpy as np
import pytest

from talaia.wire.browser import EventNews, Greeting, SiteNews, Subscribe, Subscribed, Values
from talaia.wire.columns import unpack
from talaia.wire.frames import Ack, Bye, Gap, Hello

NOW = 1_700_000_000_000_000


def columns(values: Values):
    return unpack(values.base_us, values.channel, values.offset, values.value, values.texts)


async def subscribed(page, *channels: str, every_ms: int = 0, sub: int = 1) -> Subscribed:
    await page.say(Subscribe(sub=sub, site="agv", channels=list(channels), every_ms=every_ms))
    return await page.hear(Subscribed)


async def test_page_is_greeted_with_who_it_is_and_which_sites_there_are(hub, gateway) -> None:
    page = await hub.page("operator")
    greeting = await page.hear(Greeting)
    assert (greeting.who, greeting.role) == ("operator", "operator")
    assert (await page.hear(SiteNews)).online


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
    await gateway.say(Gap(boot="boot-1", first=2, last=2, from_us=1, to_us=2, reason="disk full"))
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
    await page.hear(SiteNews, lambda news: news.online)
    await gateway.close()
    gone = await page.hear(SiteNews, lambda news: not news.online)
    assert gone.why
    await (await hub.gateway()).hello()
    await page.hear(SiteNews, lambda news: news.online)


async def test_of_two_gateways_with_one_key_the_newest_wins(hub, gateway) -> None:
    page = await hub.page("operator")
    second = await hub.gateway()
    await second.hello(boot="boot-2")
    assert "another gateway" in (await gateway.hear(Bye)).reason
    assert await gateway.closed() == 4409
    assert not (await page.hear(EventNews, lambda news: news.kind == "second gateway")).good
    await subscribed(page, "base/speed")
    await second.samples(("base/speed", NOW, 0.5))
    await page.hear(Values)


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
    await page.hear(SiteNews, lambda news: not news.online)


async def test_gateway_that_falls_silent_is_gone_after_three_beats(hub) -> None:
    page = await hub.page("operator")
    gateway = await hub.gateway()
    await gateway.hello()
    gateway.take = lambda message: super(type(gateway), gateway).take(message)
    await page.hear(SiteNews, lambda news: not news.online)


async def test_changed_description_renews_subscriptions(hub, gateway) -> None:
    page = await hub.page("operator")
    assert (await subscribed(page, "power/charge")).refused == []
    second = await hub.gateway()
    await second.hello(second.description.replace("charge:", "level:"))
    assert (await page.hear(Subscribed)).refused == ["power/charge"]


async def test_address_that_is_asked_twice_is_sent_once(hub, gateway) -> None:
    page = await hub.page("operator")
    answer = await subscribed(page, "base/speed", "base/speed")
    assert answer.refused == []
    await gateway.samples(("base/speed", NOW, 0.5))
    assert columns(await page.hear(Values)).channel.tolist() == [0]
