"""A gateway is told what is on a screen, and what is no more; and nothing of what nobody sees."""

from __future__ import annotations

import numpy as np

from talaia.wire.browser import Subscribe, Subscribed, Unsubscribe
from talaia.wire.frames import DescriptionUpdate, SignalSubscription
from talaia.wire.sealing import compress_text

from ...conftest import DESCRIPTION

SPEED, TURN, CHARGE = "base/speed", "base/turn_rate", "power/charge"


async def look(page, *channels: str, every_ms: int = 0, sub: int = 1) -> None:
    await page.say(Subscribe(sub=sub, site="agv", channels=list(channels), every_ms=every_ms))
    await page.hear(Subscribed)


async def told(gateway, *channels: str) -> SignalSubscription:
    """Wait until the gateway is told just these."""
    wanted = sorted(gateway.channels[address] for address in channels)
    return await gateway.hear(
        SignalSubscription,
        lambda said: np.frombuffer(said.channels, "<u2").tolist() == wanted,
    )


async def test_gateway_is_told_who_looks_and_when_nobody_does_any_more(hub, gateway) -> None:
    page = await hub.page("operator")
    await look(page, SPEED, CHARGE)
    said = await told(gateway, SPEED, CHARGE)
    assert (said.catalogue, said.every_ms) == ("c1", 0)
    await page.say(Unsubscribe(sub=1))
    await told(gateway)


async def test_what_one_page_leaves_another_may_still_look_at(hub, gateway) -> None:
    first, second = await hub.page("operator"), await hub.page("admin")
    await look(first, SPEED, CHARGE)
    await look(second, SPEED, TURN, every_ms=50)
    await told(gateway, SPEED, CHARGE, TURN)
    await first.close()
    # A chart sees no single sample.
    assert (await told(gateway, SPEED, TURN)).every_ms == 50
    await second.close()
    await told(gateway)


async def test_who_looks_seldom_and_what_is_not_for_a_person_is_not_told(hub, gateway) -> None:
    page, guest = await hub.page("operator"), await hub.page("guest")
    await look(page, CHARGE, every_ms=200)
    # Not for a guest.
    await look(guest, TURN)
    await look(page, SPEED, sub=2)
    await told(gateway, SPEED)
    assert not any(isinstance(message, SignalSubscription) for message in gateway.heard)


async def test_a_gateway_that_comes_back_is_told_anew(hub, gateway) -> None:
    page = await hub.page("operator")
    await look(page, SPEED)
    await told(gateway, SPEED)
    await gateway.close()
    again = await hub.gateway()
    await again.hello()
    await told(again, SPEED)


async def test_a_gateway_that_nobody_looks_at_is_told_nothing(hub, gateway) -> None:
    page = await hub.page("operator")
    await look(page, SPEED, every_ms=200)
    await gateway.close()
    again = await hub.gateway()
    await again.hello()
    await again.samples((SPEED, 1_700_000_000_000_000, 0.5))
    assert not any(isinstance(message, SignalSubscription) for message in again.heard)


async def test_channels_are_told_by_the_list_of_a_new_description(hub, gateway) -> None:
    page = await hub.page("operator")
    await look(page, SPEED)
    await told(gateway, SPEED)
    changed = DESCRIPTION.replace("devices:\n", "devices:\n" + APRON, 1)
    assert changed != DESCRIPTION
    addresses = [APRON_LIGHT, *gateway.channels]
    await gateway.say(
        DescriptionUpdate(
            description=compress_text(changed), catalogue="c2", addresses=addresses, renamed={}
        )
    )
    said = await gateway.hear(SignalSubscription, lambda said: said.catalogue == "c2")
    assert np.frombuffer(said.channels, "<u2").tolist() == [gateway.channels[SPEED] + 1]


async def test_pages_that_come_and_go_quickly_do_not_flood_the_gateway(hub, gateway) -> None:
    page = await hub.page("operator")
    for _ in range(100):
        await look(page, SPEED, CHARGE)
        await page.say(Unsubscribe(sub=1))
    await told(gateway)
    said = [message for message in gateway.heard if isinstance(message, SignalSubscription)]
    assert len(said) < 50


APRON_LIGHT = "apron/light"
APRON = """  apron:
    name: Apron
    signals:
      light: {name: Light, source: {topic: /light, type: std_msgs/msg/Float64, field: data}}
"""
