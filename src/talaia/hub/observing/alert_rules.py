"""Rules by which notices of transients become rapid requests, kept with a proposal. Pure."""

from __future__ import annotations

import hashlib
from datetime import UTC, datetime
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.model.observing.requests import (
    Configuration,
    Constraints,
    Request,
    RequestGroup,
    Urgency,
    Window,
)
from talaia.model.observing.targets import IcrsTarget
from talaia.wire.alerts.filters import AlertFilter  # noqa: TC001 - msgspec reads it

if TYPE_CHECKING:
    from talaia.model.observing.states import RequestState
    from talaia.wire.alerts.notice import AlertNotice

__all__ = [
    "AlertRule",
    "RuleVerdict",
    "event_key",
    "judge_notice",
    "notice_key",
    "request_of_notice",
]

_HOUR = 3600.0
# Clocks of senders differ; an event of further in the future is a mistake (s).
_LATER_S = 600.0
_NEW = "new"


class AlertRule(msgspec.Struct, frozen=True, kw_only=True):
    """What is asked for when a notice passes a filter.

    Attributes:
        name: as its maker calls it.
        filter: what a notice must be.
        configurations: taken of the place that it names.
        constraints: under which.
        hours: after the event it may be observed for so long (h).
        priority: of the request.
        active: one that is not makes no requests.

    """

    name: str
    filter: AlertFilter
    configurations: tuple[Configuration, ...]
    constraints: Constraints = Constraints()
    hours: float = 24.0
    priority: float = 10.0
    active: bool = True


class RuleVerdict(NamedTuple):
    """What a rule makes of a notice.

    Attributes:
        window: in which it is observed; none: it is not.
        why: it is, or is not.

    """

    window: Window | None
    why: str


def judge_notice(rule: AlertRule, notice: AlertNotice, now: float) -> RuleVerdict:
    """Tell whether a notice that came at ``now`` (s since the epoch, UTC) becomes a request."""
    refusal = rule.filter.refusal(notice)
    if refusal:
        return RuleVerdict(None, refusal)
    event = _event_time(notice.time)
    # Of what does not say when it was, the notice's arrival is the best that is known.
    begin = now if event is None else event
    if begin > now + _LATER_S:
        return RuleVerdict(None, f"its event is {(begin - now) / _HOUR:.1f} h in the future")
    end = begin + rule.hours * _HOUR
    if end <= now:
        age = (now - begin) / _HOUR
        return RuleVerdict(None, f"its event is {age:.1f} h old, more than {rule.hours:g} h")
    return RuleVerdict(Window(start=now, end=end), rule.filter.acceptance(notice))


def request_of_notice(
    rule: AlertRule,
    notice: AlertNotice,
    window: Window,
    *,
    proposal: str,
    requester: str,
    state: RequestState,
) -> RequestGroup:
    """Write the rapid request that a rule asks for; the notice must have passed its filter.

    Raises:
        ValueError: the notice names no place.

    """
    if notice.ra is None or notice.dec is None:
        raise ValueError("a notice without a place becomes no request")
    target = IcrsTarget(name=notice.event[:100], ra=notice.ra, dec=notice.dec)
    return RequestGroup(
        id=_NEW,
        proposal=proposal,
        name=f"{rule.name}: {notice.event}"[:200],
        requester=requester,
        urgency=Urgency.RAPID_RESPONSE,
        priority=rule.priority,
        requests=(
            Request(
                id=_NEW,
                target=target,
                configurations=rule.configurations,
                constraints=rule.constraints,
                windows=(window,),
                state=state,
            ),
        ),
    )


def notice_key(name: str) -> str:
    """Give a key of fixed length for a notice's id (an IVORN may be long)."""
    return hashlib.sha256(name.encode()).hexdigest()


def event_key(notice: AlertNotice) -> str:
    """Give a key of what a notice is about.

    With its source: the numbers of triggers are a mission's own.
    """
    return notice_key(f"{notice.source}\n{notice.event}")


def _event_time(text: str) -> float | None:
    """Read a time of the event (ISO 8601; without a zone it is UTC) as s since the epoch."""
    try:
        time = datetime.fromisoformat(text)
    except ValueError:
        return None
    return (time if time.tzinfo is not None else time.replace(tzinfo=UTC)).timestamp()
