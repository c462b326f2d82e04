"""What the database keeps of alarms and of messages, on every kind of database."""

from __future__ import annotations

import pytest

from talaia.clock import HandClock
from talaia.hub.alarms.rules import Rule
from talaia.hub.alarms.state_machine import Acknowledge, Clear, Raise, State, What, apply_event
from talaia.hub.auth.secret_box import Seal
from talaia.hub.errors import NameTaken
from talaia.hub.store.accounts.people import People
from talaia.hub.store.alarms.alarm_states import AlarmChange, AlarmStore, MadeAlarm
from talaia.hub.store.alarms.notification_channels import NotifyStore, WayKind
from talaia.hub.store.alarms.notification_outbox import About, NotificationOutbox
from talaia.hub.store.audit import Audit, AuditFilter
from talaia.model.alarms.alarm import Severity

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
    return await People(database, HandClock()).add_person("op", "x", "operator")


async def raised(database) -> AlarmStore:
    store = AlarmStore(database)
    state, happened = apply_event(State(), Raise(1_000_000, "it is \n low"))
    await store.commit_changes([AlarmChange(LOW, state, happened)], 1_000_000)
    return store


async def test_state_its_past_and_the_logbook_are_kept_together(database) -> None:
    store = await raised(database)
    state = (await store.load_states())["agv", "low"]
    after, happened = apply_event(state, Acknowledge(2, "ada"))
    await store.commit_changes([AlarmChange(LOW, after, happened)], 2)
    assert (await store.load_states())["agv", "low"] == after
    past = await store.alarm_history("agv", "low", 10)
    assert [each.happened.what for each in past] == [What.ACKNOWLEDGED, What.RAISED]
    # Nobody makes one line look like two.
    assert past[1].happened.message == "it is \\n low"
    audit = Audit(database, HandClock())
    rows, _ = await audit.find_records(AuditFilter(site="agv", text="LOW"), 10)
    assert [row.entry.kind for row in rows] == ["alarm acknowledged", "alarm raised"]
    # Of several kinds at once, by their beginnings.
    for kind, found in (("command,alarm r", 1), ("command,stop", 0), (",", 0), ("", 2)):
        rows, _ = await audit.find_records(AuditFilter(site="agv", kind=kind), 10)
        assert len(rows) == found
    assert (await audit.verify_chain()).broken == 0


async def test_everybody_who_may_and_wants_to_is_told_once(database, ways, person) -> None:
    guest = await People(database, HandClock()).add_person("guest", "x", "guest")
    way = await ways.put_way(None, "way", kind=WayKind.MAIL, settings={}, secrets={}, now_us=0)
    await ways.add_rule(rule(person, way))
    await ways.add_rule(rule(person, way, site="moon"))
    await ways.add_rule(rule(guest, way))
    await raised(database)
    outbox = NotificationOutbox(database)
    assert await outbox.next_due_us() == 6_000_000
    assert await outbox.claim_due(5_999_999) is None
    parcel = await outbox.claim_due(6_000_000)
    assert (parcel.user, parcel.target, parcel.zone, parcel.tries) == (
        person,
        "a@example.org",
        "Europe/Madrid",
        1,
    )
    assert [notice.title for notice in parcel.notices] == ["AGV: Low ⚡"]
    assert parcel.notices[0].text.endswith("\nBring it home.")
    # It is being sent: nobody else takes it.
    assert await outbox.claim_due(10**15) is None


async def test_message_under_way_when_the_hub_ended_is_unsure_or_the_same_again(
    database, ways, person
) -> None:
    for name, kind in (("mail", WayKind.MAIL), ("hook", WayKind.WEBHOOK)):
        await ways.add_rule(
            rule(
                person, await ways.put_way(None, name, kind=kind, settings={}, secrets={}, now_us=0)
            )
        )
    await raised(database)
    outbox = NotificationOutbox(database)
    first, second = await outbox.claim_due(10**12), await outbox.claim_due(10**12)
    hook = next(way.id for way in await ways.list_ways() if way.kind is WayKind.WEBHOOK)
    keys = {first.way: first.key, second.way: second.key}
    assert await outbox.recover_unsent([hook], 10**12) == 1
    again = await outbox.claim_due(10**12)
    assert (again.way, again.key, again.tries) == (hook, keys[hook], 2)
    assert "may have been delivered" in (await outbox.failed_alarms())["agv", "low"]
    await outbox.mark_sent(again, 10**12)
    assert await outbox.claim_due(10**15) is None


async def test_rule_is_changed_by_its_own_person_and_keeps_its_number(
    database, ways, person
) -> None:
    other = await People(database, HandClock()).add_person("other", "x", "operator")
    way = await ways.put_way(None, "way", kind=WayKind.MAIL, settings={}, secrets={}, now_us=0)
    number = await ways.add_rule(rule(person, way))
    changed = rule(person, way, id=number, site="agv", over=False, group_s=7)
    assert not await ways.change_rule(rule(other, way, id=number))
    assert not await ways.change_rule(rule(person, way, id=number + 1))
    # Saved as it is, it is there as well.
    assert await ways.change_rule(rule(person, way, id=number))
    assert await ways.change_rule(changed)
    assert await ways.rules_of(person) == [changed]
    assert await ways.rules_of(other) == []


async def test_what_waits_goes_where_its_rule_says_by_then_and_once(database, ways, person) -> None:
    mail = await ways.put_way(None, "mail", kind=WayKind.MAIL, settings={}, secrets={}, now_us=0)
    chat = await ways.put_way(None, "chat", kind=WayKind.CHAT, settings={}, secrets={}, now_us=0)
    number = await ways.add_rule(rule(person, mail))
    store = await raised(database)
    # It does not want such a thing any more, but what it wanted is not lost.
    later = rule(
        person, chat, id=number, target="", least=Severity.CRITICAL, site="moon", group_s=3600
    )
    await ways.change_rule(later)
    outbox = NotificationOutbox(database)
    assert await outbox.next_due_us() == 6_000_000
    parcel = await outbox.claim_due(6_000_000)
    assert (parcel.way, parcel.target, len(parcel.notices)) == (chat, "", 1)
    # While it is under way the rule changes once more; it certainly did not arrive.
    await ways.change_rule(rule(person, mail, id=number, target="b@example.org", over=False))
    await outbox.retry_later(parcel, 10_000_000, "no luck", same=False)
    again = await outbox.claim_due(10_000_000)
    assert (again.way, again.target, again.tries) == (mail, "b@example.org", 2)
    await outbox.mark_sent(again, 11_000_000)
    # The rule as it is by now decides of what happens from now on.
    state = (await store.load_states())["agv", "low"]
    after, happened = apply_event(state, Clear(12_000_000, "it is well"))
    assert happened[0].tell
    await store.commit_changes([AlarmChange(LOW, after, happened)], 12_000_000)
    assert await outbox.claim_due(10**15) is None


async def test_what_may_have_arrived_is_sent_once_more_by_no_other_way(
    database, ways, person
) -> None:
    hook = await ways.put_way(None, "hook", kind=WayKind.WEBHOOK, settings={}, secrets={}, now_us=0)
    mail = await ways.put_way(None, "mail", kind=WayKind.MAIL, settings={}, secrets={}, now_us=0)
    number = await ways.add_rule(rule(person, hook, target=""))
    await raised(database)
    outbox = NotificationOutbox(database)
    first = await outbox.claim_due(10**12)
    await ways.change_rule(rule(person, mail, id=number))
    await outbox.retry_later(first, 10**12, "the line broke", same=True)
    again = await outbox.claim_due(10**12)
    assert (again.way, again.key, again.tries) == (hook, first.key, 2)
    # Nor after the hub has ended meanwhile.
    assert await outbox.recover_unsent([hook], 10**12) == 0
    third = await outbox.claim_due(10**12)
    assert (third.way, third.key, third.tries) == (hook, first.key, 3)


async def test_burst_that_begins_before_a_rule_is_changed_is_one_message(
    database, ways, person
) -> None:
    way = await ways.put_way(None, "way", kind=WayKind.MAIL, settings={}, secrets={}, now_us=0)
    number = await ways.add_rule(rule(person, way))
    store = await raised(database)
    await ways.change_rule(rule(person, way, id=number, group_s=60))
    mild = LOW._replace(alarm="mild")
    state, happened = apply_event(State(), Raise(2_000_000, "it is so"))
    await store.commit_changes([AlarmChange(mild, state, happened)], 2_000_000)
    parcel = await NotificationOutbox(database).claim_due(6_000_000)
    assert [notice.alarm for notice in parcel.notices] == ["low", "mild"]
    assert await NotificationOutbox(database).next_due_us() is None


async def test_whoever_lost_the_right_or_the_rule_is_not_told(database, ways, person) -> None:
    way = await ways.put_way(None, "way", kind=WayKind.MAIL, settings={}, secrets={}, now_us=0)
    await ways.add_rule(rule(person, way))
    await raised(database)
    await People(database, HandClock()).set_role("op", "guest")
    parcel = await NotificationOutbox(database).claim_due(10**12)
    assert parcel.notices == ()
    assert await NotificationOutbox(database).failed_alarms() == {}


async def test_secret_is_sealed_and_a_way_and_its_rules_go_together(database, ways, person) -> None:
    secret = {"password": "hush"}
    way = await ways.put_way(
        None, "way", kind=WayKind.MAIL, settings={"host": "a"}, secrets=secret, now_us=0
    )
    with pytest.raises(NameTaken):
        await ways.put_way(None, "way", kind=WayKind.MAIL, settings={}, secrets={}, now_us=0)
    assert (await ways.find_way(way))[1] == secret
    await ways.put_way(
        way, "other", kind=WayKind.MAIL, settings={"host": "a"}, secrets={}, now_us=0
    )
    assert (await ways.find_way(way))[1] == secret
    await ways.put_way(
        way, "other", kind=WayKind.MAIL, settings={"host": "b"}, secrets={}, now_us=0
    )
    assert (await ways.find_way(way))[1] == {}
    await ways.add_rule(rule(person, way))
    assert await ways.remove_way(way)
    assert await ways.rules_of(person) == []


async def test_browser_takes_messages_of_one_person_only(database, ways, person) -> None:
    other = await People(database, HandClock()).add_person("other", "x", "operator")
    said = {"endpoint": "https://push.example/1", "p256dh": "a", "auth": "b"}
    await ways.add_browser(person, said, "Firefox", 0)
    await ways.add_browser(other, said, "Firefox", 0)
    assert await ways.browsers_of(person) == []
    found = await ways.browsers_of(other)
    assert found[0].subscription == said
    assert not await ways.remove_browser(person, found[0].id)
    assert await ways.remove_browser(other, found[0].id)


async def test_alarm_made_in_the_page_takes_the_place_of_the_one_of_its_name(database) -> None:
    store = AlarmStore(database)
    await store.save_made(MadeAlarm("agv", "a", "{}", "ada", 1))
    await store.save_made(MadeAlarm("agv", "a", '{"x":1}', "ada", 2))
    assert await store.list_made() == [MadeAlarm("agv", "a", '{"x":1}', "ada", 2)]
    assert await store.delete_made("agv", "a")
    assert not await store.delete_made("agv", "a")


async def test_what_waits_for_the_end_of_quiet_hours_does_not_go_along_with_what_does_not(
    database, ways, person
) -> None:
    # Quiet all day but for a minute; the clock shows 01:00:01 in Madrid.
    way = await ways.put_way(None, "way", kind=WayKind.MAIL, settings={}, secrets={}, now_us=0)
    quiet = {"quiet_from": 30, "quiet_to": 29, "quiet_least": Severity.CRITICAL}
    await ways.add_rule(rule(person, way, **quiet))
    store = await raised(database)
    mild = LOW._replace(alarm="mild", severity=Severity.WARNING)
    state, happened = apply_event(State(), Raise(2_000_000, "it is so"))
    await store.commit_changes([AlarmChange(mild, state, happened)], 2_000_000)
    outbox = NotificationOutbox(database)
    parcel = await outbox.claim_due(60_000_000)
    assert [notice.alarm for notice in parcel.notices] == ["low"]
    # At 00:29 of the next day.
    assert await outbox.next_due_us() == (23 * 60 + 29) * 60_000_000
