"""Alarms of enclosures and gateways; who is told again, and who next. Clock moved by hand."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given, strategies as st
from msgspec.structs import replace as changed
from sqlalchemy import select

from talaia.clock import SECOND, HandClock
from talaia.hub.alarms.conditions import AlarmCondition, Truth
from talaia.hub.alarms.reminders import Reminding, first_told
from talaia.hub.alarms.rules import Rule
from talaia.hub.alarms.state_machine import (
    Acknowledge,
    Clear,
    Phase,
    Raise,
    Remind,
    Shelve,
    State,
    What,
    apply_event,
)
from talaia.hub.auth.secret_box import Seal
from talaia.hub.live.alarms.alarm_engine import AlarmEngine
from talaia.hub.live.pages.page_connections import Browsers
from talaia.hub.live.sites import Sites
from talaia.hub.store.accounts.people import People
from talaia.hub.store.alarm_tables import notices
from talaia.hub.store.alarms.alarm_states import AlarmStore
from talaia.hub.store.alarms.notification_channels import NotifyStore, WayKind
from talaia.hub.store.alarms.notification_outbox import NotificationOutbox
from talaia.hub.store.database import Database
from talaia.model.alarms.alarm import Alarm, AlarmKind, Escalation, Severity
from talaia.model.alarms.standard_alarms import standard_alarms
from talaia.model.checks.alarm_checks import Addresses
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site, read_site

EXAMPLE = read_site(Path(__file__).parents[3] / "examples/observatory/site.yaml")
ROOF = Alarm(name="Roof", kind=AlarmKind.ENCLOSURE, repeat=300.0, remind=1800.0)
NEXT = (Escalation(who="anna"), Escalation(who="ben", after=120.0))


def told(alarm: Alarm, until_s: int, *acts: tuple[int, object]) -> list[tuple[int, What, object]]:
    """What is told, second by second, of an alarm that is raised at once."""
    reminding, state, said = Reminding(0), State(), []
    story = {0: Raise(0, "NOT CLOSED", first_told(alarm)), **dict(acts)}
    reminding.next_due(alarm, state, 0, 0)
    for second in range(until_s):
        now_us = second * 1_000_000
        events = [story[second]] if second in story else []
        again = reminding.next_due(alarm, state, second * SECOND, now_us)
        for event in [*events, *([again] if again else [])]:
            state, happened = apply_event(state, event)  # type: ignore[arg-type]
            said += [(second, each.what, each.to) for each in happened if each.tell]
    return said


def test_it_is_told_again_until_acknowledged_and_then_at_a_longer_interval_until_cleared() -> None:
    said = told(ROOF, 5000, (700, Acknowledge(700_000_000, "op")), (4700, Clear(0, "closed")))
    assert [(at, what) for at, what, _ in said] == [
        (0, What.RAISED),
        (301, What.REMINDED),
        (601, What.REMINDED),
        (2501, What.REMINDED),
        (4301, What.REMINDED),
        (4700, What.CLEARED),
    ]


def test_the_next_person_is_told_when_the_first_has_not_acknowledged() -> None:
    alarm = Alarm(name="Roof", kind=AlarmKind.ENCLOSURE, repeat=300.0, escalate=NEXT)
    assert told(alarm, 500) == [
        (0, What.RAISED, ("anna",)),
        (120, What.REMINDED, ("anna", "ben")),
        (420, What.REMINDED, ("anna", "ben")),
    ]
    # Acknowledged, it stands on, and goes to nobody else.
    assert told(alarm, 500, (60, Acknowledge(60_000_000, "anna"))) == [(0, What.RAISED, ("anna",))]


def test_what_is_over_and_was_not_seen_stays_visible_and_is_told_no_more() -> None:
    said = told(ROOF, 3000, (10, Clear(10_000_000, "closed")))
    assert [what for _, what, _ in said] == [What.RAISED, What.CLEARED]
    over, _ = apply_event(State(phase=Phase.ACTIVE, episode=1), Clear(0, "closed"))
    assert over.phase is Phase.CLEARED
    assert over.unseen


def test_nobody_is_reminded_of_what_is_put_aside() -> None:
    said = told(ROOF, 3000, (10, Shelve(10_000_000, "op", 2**60, "known")))
    assert [what for _, what, _ in said] == [What.RAISED]


@given(st.lists(st.integers(1, 900), min_size=1, max_size=60))
def test_reminders_are_never_closer_than_their_interval_however_it_is_looked_at(
    gaps: list[int],
) -> None:
    state = State(phase=Phase.ACTIVE, episode=1)
    reminding, now, at = Reminding(0), 0, [0]
    reminding.next_due(ROOF, state, 0, 0)
    for gap in gaps:
        now += gap
        if reminding.next_due(ROOF, state, now * SECOND, now * 1_000_000):
            at.append(now)
    assert all(later - earlier >= 300 for earlier, later in pairwise(at))


def test_a_site_with_a_roof_has_its_alarms_without_describing_them() -> None:
    found = standard_alarms(EXAMPLE)
    assert set(found) == {"dome_not_closed", "gateway_silent"}
    assert all(each.severity is Severity.CRITICAL and each.repeat for each in found.values())
    own = {"mine": Alarm(name="Mine", kind=AlarmKind.ENCLOSURE)}
    assert set(standard_alarms(changed(EXAMPLE, alarms=own))) == {"gateway_silent"}
    assert standard_alarms(changed(EXAMPLE, enclosures={})) == {}


def test_an_enclosure_is_judged_by_what_its_gateway_tells_and_by_nothing_else() -> None:
    condition = AlarmCondition(Addresses(EXAMPLE), standard_alarms(EXAMPLE)["dome_not_closed"])

    def judged(enclosures: dict[str, str], *, online: bool = True) -> Truth:
        return condition.judge_condition(
            {}, (), held=False, online=online, enclosures=enclosures
        ).truth

    assert judged({"dome": "NOT CLOSED"}) is Truth.HOLDS
    assert judged({"dome": ""}) is Truth.FALSE
    # Another one's trouble, an older gateway, and one that is away.
    assert judged({"other": "NOT CLOSED"}) is Truth.UNKNOWN
    assert judged({}) is Truth.UNKNOWN
    assert judged({"dome": ""}, online=False) is Truth.UNKNOWN


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("kind: enclosure, enclosure: shed", "$.alarms.a.enclosure"),
        ("kind: gateway, signal: dome/shutter", "$.alarms.a.signal"),
        ("kind: gateway, repeat: 1", "$.alarms.a.repeat"),
        ("kind: gateway, escalate: [{who: a}]", "$.alarms.a.repeat"),
        (
            "kind: gateway, repeat: 60, escalate: [{who: a, after: 9}, {who: b}]",
            "$.alarms.a.escalate[1].after",
        ),
    ],
)
def test_what_does_not_fit_is_named(text: str, wrong: str) -> None:
    site = load_site(
        f"talaia: 1\nsite: a\nname: A\ndevices: {{}}\nalarms:\n  a: {{name: A, {text}}}"
    )
    assert [each.where for each in check_site(site) if each.where != "$.devices"] == [wrong]


async def test_a_roof_that_is_not_closed_reaches_the_next_person_through_the_hubs_outbox(
    tmp_path: Path,
) -> None:
    database, clock = Database(f"sqlite:///{tmp_path}/talaia.db"), HandClock()
    await database.migrate()
    people = People(database, clock)
    for name in ("anna", "ben"):
        await people.add_person(name, "x", "operator")
    store = NotifyStore(database, lambda: Seal(bytes(32)))
    way = await store.put_way(
        None, WayKind.MAIL, kind=WayKind.MAIL, settings={}, secrets={}, now_us=0
    )
    for user in (1, 2):
        await store.add_rule(
            Rule(
                id=0,
                user=user,
                site="*",
                way=way,
                target="a@example.org",
                least=Severity.INFO,
                over=True,
                quiet_from=0,
                quiet_to=0,
                quiet_least=Severity.INFO,
                zone="UTC",
                group_s=0,
            )
        )
    described = load_site("""
talaia: 1
site: hill
name: Hill
devices: {}
alarms:
  roof:
    name: Roof
    kind: enclosure
    severity: critical
    repeat: 300
    escalate: [{who: anna}, {who: ben, after: 120}]
""")
    sites = Sites()
    live = sites.describe_site(described, "c")
    live.presence.link = object()  # type: ignore[assignment] - there is one; nothing is sent on it
    alarms = AlarmEngine(
        sites=sites,
        browsers=Browsers(),
        store=AlarmStore(database),
        notices=NotificationOutbox(database),
        clock=clock,
    )
    await alarms.open()

    async def outbox() -> list[tuple[int, str]]:
        async with database.read() as connection:
            rows = await connection.execute(
                select(notices.c.user_id, notices.c.what).order_by(notices.c.id)
            )
            return [(row.user_id, row.what) for row in rows]

    live.retained.enclosures["roof"] = "Roof: NOT CLOSED after 3 tries"
    for _ in range(130):
        alarms.evaluate_conditions()
        await alarms.settle_changes()
        clock.advance(SECOND)
    assert await outbox() == [(1, "raised"), (1, "reminded"), (2, "reminded")]
    found = alarms.find_alarm("hill", "roof")
    assert found is not None
    acting = Acknowledge(clock.wall_ns() // 1000, "ben")
    alarms._enqueue_event(found, acting)
    for _ in range(700):
        alarms.evaluate_conditions()
        await alarms.settle_changes()
        clock.advance(SECOND)
    assert len(await outbox()) == 3
    assert found.state.phase is Phase.ACKNOWLEDGED
    await database.close()


def test_a_reminder_says_who_has_acknowledged_it() -> None:
    state = State(phase=Phase.ACKNOWLEDGED, episode=1, why="NOT CLOSED", acked_by="anna")
    _, happened = apply_event(state, Remind(5))
    assert happened[0].message == "still so (acknowledged by anna): NOT CLOSED"
    assert apply_event(replace(state, phase=Phase.NORMAL), Remind(5))[1] == ()
