"""An alarm that is raised, with somebody who wants to be told."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.alarms.rules import Rule
from talaia.hub.alarms.state_machine import Raise, State, apply_event
from talaia.hub.store.accounts.people import People
from talaia.hub.store.alarms.alarm_states import AlarmChange, AlarmStore
from talaia.hub.store.alarms.notification_outbox import About
from talaia.model.alarms.alarm import Severity

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.store.alarms.notification_channels import NotifyStore, WayKind
    from talaia.hub.store.database import Database


async def raise_alarm(
    database: Database, clock: Clock, store: NotifyStore, kind: WayKind, *, secrets: dict[str, str]
) -> None:
    """Let an operator be told of everything by a channel, and the battery be low."""
    now = clock.wall_ns() // 1000
    user = await People(database, clock).add_person("op", "x", "operator")
    way = await store.put_way(None, "way", kind=kind, settings={}, secrets=secrets, now_us=0)
    await store.add_rule(
        Rule(
            id=0, user=user, site="*", way=way, target="", least=Severity.INFO, over=True,
            quiet_from=0, quiet_to=0, quiet_least=Severity.INFO, zone="UTC", group_s=0,
        )
    )  # fmt: skip
    state, happened = apply_event(State(), Raise(now, "Voltage is 10 V"))
    about = About("agv", "low", "power", Severity.CRITICAL, "Battery low", "AGV", "")
    await AlarmStore(database).commit_changes([AlarmChange(about, state, happened)], now)
