"""Alarms of all sites are told by one hub, once; each hub shows which could not be."""

from __future__ import annotations

import dataclasses
import ipaddress
import time

import pytest
from sqlalchemy import select

from talaia.hub.sharding.plan import MAIN
from talaia.hub.store.alarm_tables import notices
from talaia.hub.store.alarms.notification_outbox import NoticeState
from talaia.wire.browser import AlarmUpdate

from ..mailbox import mailbox, want_mail  # noqa: F401 - a fixture
from .two_shards import AGV, EAST, LAB

LOW = """
alarms:
  low: {name: Battery low, kind: limit, signal: power/voltage, below: 11, max_age: 3600}
"""


@pytest.fixture
def settings(settings):
    return dataclasses.replace(settings, notify_networks=(ipaddress.ip_network("127.0.0.0/8"),))


async def raise_low(gateway) -> None:
    await gateway.samples(("power/voltage", time.time_ns() // 1000, 10.0))


async def states_of_notices(shards) -> list[tuple[str, str]]:
    async with shards.database.read() as connection:
        rows = await connection.execute(select(notices.c.site, notices.c.state))
        return sorted((row.site, row.state) for row in rows)


async def test_alarms_of_every_site_are_told_once_by_the_main_hub(shards, mailbox) -> None:  # noqa: F811
    for site in (AGV, LAB):
        await want_mail(shards.main, mailbox, site=site)
        gateway = await shards.gateway(site, LOW)
        await raise_low(gateway)
        while not mailbox.envelopes:
            await mailbox.news.wait()
        mailbox.news.clear()
        (mail,) = mailbox.envelopes
        assert b"Battery low" in mail.content
        mailbox.envelopes.clear()
    # What went out is not sent again, whichever hub begins anew.
    for shard in (EAST, MAIN):
        await shards.end(shard)
        await shards.start(shard)
    assert not mailbox.envelopes
    assert await states_of_notices(shards) == [(AGV, "sent"), (LAB, "sent")]


async def test_a_hub_that_begins_leaves_alone_what_the_main_one_sends(shards) -> None:
    row = {
        "happened": 1, "rule": 1, "user_id": 1, "way": 1, "site": AGV, "alarm": "low",
        "device": "power", "episode": 1, "what": "raised", "severity": "critical",
        "title": "", "text": "", "time_us": 1, "state": NoticeState.SENDING.value,
        "parcel": "a", "tries": 1, "due_us": 1, "done_us": 0, "problem": "",
    }  # fmt: skip
    async with shards.database.write() as connection:
        await connection.execute(notices.insert().values(**row))
    await shards.end(EAST)
    await shards.start(EAST)
    assert await states_of_notices(shards) == [(AGV, "sending")]
    await shards.end(MAIN)
    await shards.start(MAIN)
    assert await states_of_notices(shards) == [(AGV, "unsure")]


async def test_a_hub_shows_which_of_its_alarms_the_main_one_could_not_tell(shards, mailbox) -> None:  # noqa: F811
    await want_mail(shards.main, mailbox)
    mailbox.answer = "550 no"
    gateway = await shards.gateway(AGV, LOW)
    page = await shards.east.page("operator")
    await raise_low(gateway)
    news = await page.hear(AlarmUpdate, lambda news: news.undelivered)
    assert (news.site, news.alarm) == (AGV, "low")
