"""How a night has ended, and that it needs somebody, reaches those who want to know and may."""

from __future__ import annotations

import asyncio
import dataclasses
import ipaddress
import time
from pathlib import Path

import pytest
from patience import PATIENCE_S

from talaia.wire.frames import Event

from ..mailbox import want_mail

SITE = "observatory"
DESCRIPTION = (Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml").read_text()
ENDED = "2 requests observed, 6 frames: M 31, M 33; open for 2 h 10 min; broken off 1 time: rain"


@pytest.fixture
def settings(settings):
    return dataclasses.replace(settings, notify_networks=(ipaddress.ip_network("127.0.0.0/8"),))


@pytest.fixture
async def dome(hub):
    hub.keys[SITE] = await hub.hub.gateways.registry.new_key(SITE)
    gateway = await hub.gateway(key=hub.keys[SITE])
    await gateway.hello(DESCRIPTION, site=SITE)
    return gateway


def event(kind: str, message: str, *, after_us: int = 0, good: bool = True) -> Event:
    time_us = time.time_ns() // 1000 + after_us
    return Event(kind=kind, message=message, good=good, time_us=time_us)


async def mails(mailbox, many: int) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while len(mailbox.envelopes) < many:
            mailbox.news.clear()
            await mailbox.news.wait()


async def test_a_night_that_is_over_is_told_once_to_those_who_want_to_know(
    hub,
    dome,
    mailbox,
) -> None:
    await want_mail(hub, mailbox, site=SITE, nights=True)
    # Wants to know of alarms alone.
    await want_mail(hub, mailbox, "admin", site="*", target="admin@example.org")
    ended = event("night_ended", ENDED)
    # A gateway that has lost its line says it once more.
    for _ in range(2):
        await dome.say(ended)
    await mails(mailbox, 1)
    assert mailbox.envelopes[0].rcpt_tos == ["op@example.org"]
    said = mailbox.text()
    assert said.startswith("Observatory: the night is over (info)")
    assert ENDED in said
    # What comes after it is the next that is told: nothing was told twice or to another.
    await dome.say(event("night_disarmed", "by ada"))
    await dome.say(event("night_not_closed", "closing the roof took longer than 60 s", good=False))
    await mails(mailbox, 2)
    assert mailbox.envelopes[1].rcpt_tos == ["op@example.org"]
    assert mailbox.text(1).startswith("Observatory: the roof is not closed (critical)")


async def test_who_may_not_view_the_site_is_told_nothing_of_its_nights(hub, dome, mailbox) -> None:
    await want_mail(hub, mailbox, site="*", nights=True)
    admin = await hub.client("admin")
    right = {"site": "agv", "device": "*", "right": "view"}
    made = await admin.post("/api/roles", json={"name": "drivers", "permissions": [right]})
    assert made.is_success, made.text
    people = {row["name"]: row["id"] for row in (await admin.get("/api/people")).json()["people"]}
    moved = await admin.patch(f"/api/people/{people['operator']}", json={"role": "drivers"})
    assert moved.is_success, moved.text
    await want_mail(hub, mailbox, "admin", site=SITE, target="admin@example.org", nights=True)
    await dome.say(event("night_fault", "the dome does not turn", good=False))
    await mails(mailbox, 1)
    assert [one.rcpt_tos for one in mailbox.envelopes] == [["admin@example.org"]]
    assert "the night has failed (critical)" in mailbox.text()


async def test_a_gateway_that_says_it_without_end_fills_nobody_s_mailbox(
    hub,
    dome,
    mailbox,
) -> None:
    await want_mail(hub, mailbox, site=SITE, nights=True, group_s=1)
    for number in range(60):
        await dome.say(event("night_fault", f"fault {number}", after_us=number, good=False))
    # Nonsense in its clock, too.
    await dome.say(Event(kind="night_fault", message="no time", time_us=2**63 - 1, good=False))
    await mails(mailbox, 1)
    told = sum(mailbox.text(at).count("fault ") for at in range(len(mailbox.envelopes)))
    assert told <= 20
