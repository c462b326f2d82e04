"""Nights and plans as pages read them. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.schemas.observing_schemas import (
    NightStateShape,
    PlanBlockShape,
    PlanPauseShape,
    PlanShape,
    WhyNotShape,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.hub.store.observing.request_queries import PlannedRequest
    from talaia.model.observing.plan import Plan, WhyNot
    from talaia.wire.frames import NightState

__all__ = ["night_state_shape", "plan_shape", "why_not_shape"]


def night_state_shape(state: NightState, heard_us: int) -> NightStateShape:
    """Write how a night stands."""
    return NightStateShape(
        phase=state.phase,
        armed_by=state.armed_by,
        armed_until_us=_to_us(state.armed_until),
        why=state.why,
        since_us=_to_us(state.since),
        request=state.request,
        step=state.step,
        frames_done=state.frames_done,
        frames=state.frames,
        heard_us=heard_us,
        site_time_us=_to_us(state.site_time),
        speed=state.speed,
    )


def plan_shape(plan: Plan, seen: Mapping[str, PlannedRequest]) -> PlanShape:
    """Write a plan for somebody; of requests that are not ``seen`` only when they are planned."""
    blocks = []
    for block in plan.blocks:
        known = seen.get(block.request)
        blocks.append(
            PlanBlockShape(
                request=block.request if known is not None else "",
                proposal=known.proposal if known is not None else "",
                target=known.target if known is not None else "",
                start_us=_to_us(block.start),
                end_us=_to_us(block.end),
                overhead_s=block.overhead,
                reason=block.reason if known is not None else "",
                # What the telescope does says nothing of whose target it is.
                pauses=[
                    PlanPauseShape(
                        kind=pause.kind,
                        start_us=_to_us(pause.start),
                        end_us=_to_us(pause.end),
                        reason=pause.reason if known is not None else "",
                    )
                    for pause in block.pauses
                ],
            )
        )
    return PlanShape(
        made_us=_to_us(plan.made_at),
        night_start_us=_to_us(plan.night_start),
        night_end_us=_to_us(plan.night_end),
        method=plan.method,
        value=plan.value,
        bound=plan.bound,
        blocks=blocks,
    )


def why_not_shape(reason: WhyNot | None) -> WhyNotShape | None:
    """Write why a request is not observed now."""
    if reason is None:
        return None
    return WhyNotShape(
        cause=reason.cause,
        message=reason.sentence,
        until_us=_to_us(reason.until) if reason.until is not None else None,
        planned_us=_to_us(reason.planned_at) if reason.planned_at is not None else None,
    )


def _to_us(seconds: float) -> int:
    return round(seconds * 1_000_000)
