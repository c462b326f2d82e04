"""Who is told of what, by which way and when: rules of people, as values.

A message that falls into somebody's quiet hours is not lost: it waits for their end.
"""

from __future__ import annotations

import datetime as dt
from dataclasses import dataclass
from typing import TYPE_CHECKING
from zoneinfo import ZoneInfo

from talaia.hub.alarms.state_machine import What

if TYPE_CHECKING:
    from talaia.hub.alarms.state_machine import Happened
    from talaia.model.alarms.alarm import Severity

__all__ = ["DAY_MIN", "Rule", "due_us", "rule_matches"]

DAY_MIN = 24 * 60
_SECOND_US = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """What one person wants to be told, and how.

    Attributes:
        user: number of the person.
        site: its short name; ``*`` for every site.
        way: number of the way that an admin has set up.
        target: where to, for ways that need it: a mail address.
        least: told of alarms at least so bad.
        over: told also when it is over.
        quiet_from: quiet hours begin at this minute of the day in ``zone``; the same as
            ``quiet_to``: none.
        quiet_to: and end at this one.
        quiet_least: alarms at least so bad come in quiet hours too.
        group_s: what follows within this time comes in one message (s).
        own_requests: told also when a request of theirs is done, or has failed.
        nights: told also how a night that runs by itself has ended, and when it needs somebody.

    """

    id: int
    user: int
    site: str
    way: int
    target: str
    least: Severity
    over: bool
    quiet_from: int
    quiet_to: int
    quiet_least: Severity
    # IANA name of the time zone by which quiet hours count.
    zone: str
    group_s: int
    own_requests: bool = False
    nights: bool = False


def rule_matches(rule: Rule, site: str, severity: Severity, happened: Happened) -> bool:
    """Tell whether somebody is to hear of what happened. Their rights are another matter."""
    return (
        happened.tell
        and rule.site in {"*", site}
        and severity.rank >= rule.least.rank
        and (rule.over or happened.what is not What.CLEARED)
    )


def due_us(rule: Rule, severity: Severity, now_us: int) -> int:
    """Give when a message that comes up now may go out (µs, UTC)."""
    # Grouping first: what counts is whether it is quiet when the message would go out.
    at = now_us + rule.group_s * _SECOND_US
    if rule.quiet_from == rule.quiet_to or severity.rank >= rule.quiet_least.rank:
        return at
    local = dt.datetime.fromtimestamp(at / 1e6, ZoneInfo(rule.zone))
    minute = local.hour * 60 + local.minute
    # Modulo a day, for quiet hours may go over midnight.
    left = (rule.quiet_to - minute) % DAY_MIN
    length = (rule.quiet_to - rule.quiet_from) % DAY_MIN
    # Not quiet: the end is farther away than the quiet hours are long.
    if not 0 < left <= length:
        return at
    end = local.replace(second=0, microsecond=0, tzinfo=None) + dt.timedelta(minutes=left)
    # By the person's own clock, also on the night on which it is put forward or back.
    return round(end.replace(tzinfo=ZoneInfo(rule.zone)).timestamp() * 1e6)
