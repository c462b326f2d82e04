"""What the database keeps of alarms and of messages, on every kind of database."""

from __future__ import annotations

import pytest

from talaia.clock import HandClock
from talaia.hub.alarms.machine import Acknowledge, Raise, State, What, step
from talaia.hub.alarms.rules import Rule
from talaia.hub.auth.seal import Seal
from talaia.hub.errors import NameTaken
from talaia.hub.store.alarms import AlarmStore, Change, Made
from talaia.hub.store.audit import Audit, Filter
from talaia.hub.store.notices import About, Notices
from talaia.hub.store.notify import NotifyStore, WayKind
from talaia.hub.store.people import People
from talaia.model.alarm import Severity

LOW = About("agv", "low", "base", Severity.CRITICAL, "Low ⚡", "AGV", "Bring it home.")


def rule(user: int, way: int, **changes) -> Rule:
    said = {
        "id": 0, "user": user, "site": "*", "way": way, "target": "a@example.org",
        "least": Severity.INFO, "over": True, "quiet_from": 0, "quiet_to": 0,
        "quiet_least": Severity.INFO, "zone": "Europe/Madrid", "group_s": 5,
    }  # fmt: skip
    return Rule(**{**said, **changes})


@pytest.fixture
def ways(database) -> NotifyStore:
    return NotifyStore(database, lambda: Seal(bytes(32)))


@pytest.fixture
async def person(database) -> int:
    return await People(database, HandClock()).add("op", "x", "operator")


async def raised(database) -> AlarmStore:
    store = AlarmStore(database)
    state, happened = step(State(), Raise(1_000_000, "it is \n low"))
    await store.commit([Change(LOW, state, happened)], 1_000_000)
    return store


async def test_state_its_past_and_the_logbook_are_kept_together(database) -> None:
    store = await raised(database)
    state = (await store.states())["agv", "low"]
    after, happened = step(state, Acknowledge(2, "ada"))
    await store.commit([Change(LOW, after, happened)], 2)
    assert (await store.states())["agv", "low"] == after
    past = await store.past("agv", "low", 10)
    assert [each.happened.what for each in past] == [What.ACKNOWLEDGED, What.RAISED]
    # Nobody makes one line look like two.
    assert past[1].happened.message == "it is \\n low"
    audit = Audit(database, HandClock())
    rows, _ = await audit.find(Filter(site="agv", text="LOW"), 10)
    assert [row.entry.kind for row in rows] == ["alarm acknowledged", "alarm raised"]
    assert (await audit.verify()).broken == 0


async def test_everybody_who_may_and_wants_to_is_told_once(database, ways, person) -> None:
    guest = await People(database, HandClock()).add("guest", "x", "guest")
    way = await ways.put_way(None, "way", WayKind.MAIL, {}, {}, 0)
    await ways.add_rule(rule(person, way))
    await ways.add_rule(rule(person, way, site="moon"))
    await ways.add_rule(rule(guest, way))
    await raised(database)
    outbox = Notices(database)
    assert await outbox.next_due_us() == 6_000_000
    assert await outbox.take(5_999_999) is None
    parcel = await outbox.take(6_000_000)
    assert (parcel.user, parcel.target, parcel.zone, parcel.tries) == (
        person,
        "a@example.org",
        "Europe/Madrid",
        1,
    )
    assert [notice.title for notice in parcel.notices] == ["AGV: Low ⚡"]
    assert parcel.notices[0].text.endswith("\nBring it home.")
    # It is being sent: nobody else takes it.
    assert await outbox.take(10**15) is None


async def test_message_under_way_when_the_hub_ended_is_unsure_or_the_same_again(
    database, ways, person
) -> None:
    for name, kind in (("mail", WayKind.MAIL), ("hook", WayKind.WEBHOOK)):
        await ways.add_rule(rule(person, await ways.put_way(None, name, kind, {}, {}, 0)))
    await raised(database)
    outbox = Notices(database)
    first, second = await outbox.take(10**12), await outbox.take(10**12)
    hook = next(way.id for way in await ways.ways() if way.kind is WayKind.WEBHOOK)
    keys = {first.way: first.key, second.way: second.key}
    assert await outbox.recover([hook], 10**12) == 1
    again = await outbox.take(10**12)
    assert (again.way, again.key, again.tries) == (hook, keys[hook], 2)
    assert "may have been delivered" in (await outbox.troubles())["agv", "low"]
    await outbox.sent(again, 10**12)
    assert await outbox.take(10**15) is None


async def test_whoever_lost_the_right_or_the_rule_is_not_told(database, ways, person) -> None:
    way = await ways.put_way(None, "way", WayKind.MAIL, {}, {}, 0)
    await ways.add_rule(rule(person, way))
    await raised(database)
    await People(database, HandClock()).set_role("op", "guest")
    parcel = await Notices(database).take(10**12)
    assert parcel.notices == ()
    assert await Notices(database).troubles() == {}


async def test_secret_is_sealed_and_a_way_and_its_rules_go_together(database, ways, person) -> None:
    secret = {"password": "hush"}
    way = await ways.put_way(None, "way", WayKind.MAIL, {"host": "a"}, secret, 0)
    with pytest.raises(NameTaken):
        await ways.put_way(None, "way", WayKind.MAIL, {}, {}, 0)
    assert (await ways.way(way))[1] == secret
    await ways.put_way(way, "other", WayKind.MAIL, {"host": "a"}, {}, 0)
    assert (await ways.way(way))[1] == secret
    await ways.put_way(way, "other", WayKind.MAIL, {"host": "b"}, {}, 0)
    assert (await ways.way(way))[1] == {}
    await ways.add_rule(rule(person, way))
    assert await ways.remove_way(way)
    assert await ways.rules(person) == []


async def test_browser_takes_messages_of_one_person_only(database, ways, person) -> None:
    other = await People(database, HandClock()).add("other", "x", "operator")
    said = {"endpoint": "https://push.example/1", "p256dh": "a", "auth": "b"}
    await ways.add_browser(person, said, "Firefox", 0)
    await ways.add_browser(other, said, "Firefox", 0)
    assert await ways.browsers(person) == []
    found = await ways.browsers(other)
    assert found[0].subscription == said
    assert not await ways.remove_browser(person, found[0].id)
    assert await ways.remove_browser(other, found[0].id)


async def test_alarm_made_in_the_page_takes_the_place_of_the_one_of_its_name(database) -> None:
    store = AlarmStore(database)
    await store.define(Made("agv", "a", "{}", "ada", 1))
    await store.define(Made("agv", "a", '{"x":1}', "ada", 2))
    assert await store.made() == [Made("agv", "a", '{"x":1}', "ada", 2)]
    assert await store.forget("agv", "a")
    assert not await store.forget("agv", "a")
