"""Whether a mission may begin or go on now: nothing starts on a stale state. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from talaia.clock import SECOND
from talaia.hub.alarms.conditions import AlarmCondition, ConditionReading, Truth
from talaia.hub.auth.permissions import Right
from talaia.model.alarms.alarm import Alarm, AlarmKind
from talaia.model.checks.alarm_checks import Addresses
from talaia.model.missions.mission import StepKind
from talaia.model.missions.mission_checks import site_findings

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.sites import LiveSite
    from talaia.model.missions.mission import Mission

__all__ = ["judge_condition", "latched_stop", "start_problem"]

_NEVER = np.iinfo(np.int64).min


def start_problem(live: LiveSite, mission: Mission, who: Who, now_ns: int) -> str:
    """Say why a mission may not begin now; empty where it may.

    Args:
        live: the site.
        mission: all of its steps count, also those that come later.
        who: with whose rights.
        now_ns: now (monotonic).

    """
    site = live.description
    if live.link is None:
        return f"{site.name} is not connected"
    for finding in site_findings(mission, site):
        return f"it does not fit the site any more: {finding}"
    devices = {step.device: None for step in mission.steps if step.kind is StepKind.COMMAND}
    for device in devices:
        if not who.grants.has_right(Right.USE, live.name, device):
            return f"{who.name} may not use {site.devices[device].name}"
    if stopped := latched_stop(live):
        return stopped
    for device in devices:
        if device in live.current.unreached:
            return f"the gateway does not reach {site.devices[device].name}"
        if not _is_heard(live, device, now_ns):
            return f"nothing is heard of {site.devices[device].name}: its state is stale"
    for step in mission.steps:
        if step.kind is StepKind.UNTIL:
            truth, why = judge_condition(live, step.condition, now_ns)
            if truth is Truth.UNKNOWN:
                return f"a condition cannot be judged now: {why}"
    return ""


def latched_stop(live: LiveSite) -> str:
    """Say by whom a device of the site is stopped; empty where none is."""
    for device, stop in live.retained.stops.items():
        if stop.latched:
            described = live.description.devices.get(device)
            name = device if described is None else described.name
            return f"STOP is latched at {name}" + (f", pressed by {stop.who}" if stop.who else "")
    return ""


def judge_condition(live: LiveSite, condition: str, now_ns: int) -> tuple[Truth, str]:
    """Judge the condition of a step as an alarm's: what is unknown or too old does not hold."""
    # Made anew each time: the description may have changed since the last one.
    watched = AlarmCondition(
        Addresses(live.description),
        Alarm(name="condition", kind=AlarmKind.EXPRESSION, expression=condition),
    )
    readings = _readings_of(live, watched.channels, now_ns)
    verdict = watched.judge_condition(readings, (), held=False, online=live.online)
    return verdict.truth, verdict.why


def _readings_of(
    live: LiveSite, addresses: Iterable[str], now_ns: int
) -> dict[str, ConditionReading]:
    number = {channel.address: at for at, channel in enumerate(live.channels)}
    latest = live.latest
    return {
        address: ConditionReading(
            float(latest.value[at]),
            latest.texts.get(at, ""),
            (now_ns - int(latest.arrived_ns[at])) / SECOND,
        )
        for address in addresses
        if (at := number.get(address)) is not None
        and latest.arrived_ns[at] != _NEVER
        # Of a device out of reach no value counts, however young.
        and address.partition("/")[0] not in live.current.unreached
    }


def _is_heard(live: LiveSite, device: str, now_ns: int) -> bool:
    """Tell whether a device has said anything lately; one without signals has nothing to say."""
    own = [(at, one) for at, one in enumerate(live.channels) if one.device == device]
    signals = live.description.devices[device].signals
    return not own or any(
        live.latest.arrived_ns[at] != _NEVER
        and now_ns - int(live.latest.arrived_ns[at]) <= signals[one.signal].stale_after * SECOND
        for at, one in own
    )
