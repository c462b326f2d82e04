"""Requests between the form of the API and that of planners. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec

from talaia.hub.api.schemas.observing_schemas import (
    ConfigurationShape,
    ConstraintsShape,
    FixedTargetShape,
    GroupAsk,
    IcrsTargetShape,
    MovingTargetShape,
    PhaseShape,
    RequestAsk,
    RequestShape,
    WindowShape,
)
from talaia.model.observing.requests import Request, RequestGroup
from talaia.model.observing.targets import IcrsTarget, SolarSystemTarget

if TYPE_CHECKING:
    from talaia.hub.api.schemas.observing_schemas import TargetShape
    from talaia.model.observing.requests import Constraints
    from talaia.model.observing.states import RequestState
    from talaia.model.observing.targets import Target

__all__ = ["group_ask", "read_group", "request_shape", "window_problems"]

_SECOND = 1_000_000
# What of a request is asked for; the rest follows.
_ASKED = {"target", "configurations", "constraints", "windows"}
# Of what no row has yet.
_NEW = "new"


def read_group(asked: GroupAsk, requester: str, state: RequestState) -> RequestGroup:
    """Read what was asked, with every request in ``state``; ids are given when it is kept."""
    return RequestGroup(
        id=_NEW,
        proposal=asked.proposal,
        name=asked.name,
        requester=requester,
        operator=asked.operator,
        urgency=asked.urgency,
        priority=asked.priority,
        requests=tuple(_read_request(request, state) for request in asked.requests),
    )


def group_ask(group: RequestGroup) -> GroupAsk:
    """Write a group as it would be asked for, as a draft."""
    return GroupAsk(
        proposal=group.proposal,
        name=group.name,
        operator=group.operator,
        urgency=group.urgency,
        priority=group.priority,
        requests=[
            RequestAsk(**request_shape(request, 0.0).model_dump(include=_ASKED))
            for request in group.requests
        ],
        draft=True,
    )


def window_problems(group: RequestGroup, now: float) -> list[str]:
    """List what is wrong with the windows of requests, in words; ``now`` in s since the epoch."""
    found = []
    for at, request in enumerate(group.requests, 1):
        said = f"request {at}: " if len(group.requests) > 1 else ""
        if any(window.end <= window.start for window in request.windows):
            found.append(f"{said}a window ends before it begins")
        elif max(window.end for window in request.windows) <= now:
            found.append(f"{said}its last window is over")
    return found


def request_shape(request: Request, charge: float) -> RequestShape:
    """Write a request for pages."""
    return RequestShape(
        id=request.id,
        target=_target_shape(request.target) if request.target is not None else None,
        configurations=[
            ConfigurationShape(**msgspec.structs.asdict(configuration))
            for configuration in request.configurations
        ],
        constraints=_constraints_shape(request.constraints),
        windows=[
            WindowShape(start_us=_to_us(window.start), end_us=_to_us(window.end))
            for window in request.windows
        ],
        state=request.state,
        frames_done=list(request.frames_done),
        failures=request.failures,
        charge_s=charge,
    )


def _read_request(asked: RequestAsk, state: RequestState) -> Request:
    said: dict[str, Any] = asked.model_dump(exclude_none=True)
    said["windows"] = [
        {"start": window.start_us / _SECOND, "end": window.end_us / _SECOND}
        for window in asked.windows
    ]
    if asked.constraints.phase is not None:
        phase = asked.constraints.phase
        said["constraints"]["phase"] = {
            "epoch": phase.epoch_us / _SECOND,
            "period": phase.period_s,
            "start": phase.start,
            "end": phase.end,
        }
    # The bounds of both forms are the same, so nothing is refused here.
    return msgspec.convert({**said, "id": _NEW, "state": state}, Request, strict=False)


def _constraints_shape(constraints: Constraints) -> ConstraintsShape:
    said = msgspec.structs.asdict(constraints)
    phase = constraints.phase
    if phase is not None:
        said["phase"] = PhaseShape(
            epoch_us=_to_us(phase.epoch), period_s=phase.period, start=phase.start, end=phase.end
        )
    return ConstraintsShape(**said)


def _target_shape(target: Target) -> TargetShape:
    said = msgspec.structs.asdict(target)
    match target:
        case IcrsTarget():
            return IcrsTargetShape(type="ICRS", **said)
        case SolarSystemTarget():
            return MovingTargetShape(type="SOLAR_SYSTEM", **said)
        case _:
            return FixedTargetShape(type="FIXED", **said)


def _to_us(seconds: float) -> int:
    return round(seconds * _SECOND)
