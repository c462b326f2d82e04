"""Which state of a request follows from what people do and gateways report. Pure."""

from __future__ import annotations

from typing import NamedTuple

from talaia.hub.errors import HubError
from talaia.model.observing.states import (
    OBSERVATION_CHANGES,
    REQUEST_CHANGES,
    ObservationState,
    RequestState,
)

__all__ = [
    "FAILURE_LIMIT",
    "ImpossibleChange",
    "ObservationEffect",
    "StateChange",
    "can_follow",
    "change_request",
    "observation_effect",
]

# So many failed tries end a request: a person looks at it before it is tried again.
FAILURE_LIMIT = 3


class ImpossibleChange(HubError):
    """A request cannot come from its state to the one that was asked for."""


class StateChange(NamedTuple):
    """A request's step from one state to another, and why."""

    before: RequestState
    after: RequestState
    why: str


class ObservationEffect(NamedTuple):
    """What a report on an observation does to its request.

    Attributes:
        changes: in order; most reports make none.
        failures: of the request from now on.

    """

    changes: tuple[StateChange, ...]
    failures: int


def change_request(before: RequestState, after: RequestState, why: str) -> StateChange:
    """Let a request change its state.

    Raises:
        ImpossibleChange: it cannot follow; says from which to which.

    """
    if after not in REQUEST_CHANGES[before]:
        possible = ", ".join(sorted(state.value for state in REQUEST_CHANGES[before]))
        raise ImpossibleChange(
            f"a request that is {before.value} cannot become {after.value}",
            f"what may follow is {possible}" if possible else "nothing follows it",
        )
    return StateChange(before, after, why)


def can_follow(before: ObservationState | None, after: ObservationState) -> bool:
    """Tell whether a report may follow the one before; the first may be of any state."""
    # A report is repeated until it is acknowledged, and frames are counted in one state.
    return before is None or before is after or after in OBSERVATION_CHANGES[before]


def observation_effect(
    state: RequestState,
    failures: int,
    *,
    before: ObservationState | None,
    after: ObservationState,
    why: str = "",
) -> ObservationEffect:
    """Work out what a report on an observation does to its request.

    Args:
        state: of the request.
        failures: of the request, so far.
        before: state of the observation by the report before; none: this is the first.
        after: by this one.
        why: as the gateway put it.

    """
    if before is after or not can_follow(before, after):
        return ObservationEffect((), failures)
    match after:
        case ObservationState.COMPLETED if state is not RequestState.COMPLETED:
            return ObservationEffect(_completed(state, why or "observed"), failures)
        case ObservationState.FAILED:
            failures += 1
            if state is RequestState.PENDING and failures >= FAILURE_LIMIT:
                said = f"failed {failures} times, last: {why or 'no reason was given'}"
                return ObservationEffect(
                    (change_request(state, RequestState.FAILURE_LIMIT_REACHED, said),), failures
                )
        case ObservationState.BAD_DATA if state is RequestState.COMPLETED:
            said = f"the data are of no use: {why}" if why else "the data are of no use"
            return ObservationEffect((change_request(state, RequestState.PENDING, said),), failures)
        case _:
            pass
    return ObservationEffect((), failures)


def _completed(state: RequestState, why: str) -> tuple[StateChange, ...]:
    if RequestState.COMPLETED in REQUEST_CHANGES[state]:
        return (change_request(state, RequestState.COMPLETED, why),)
    # A draft: it was taken back for a change while its telescope was at it.
    return (
        change_request(state, RequestState.PENDING, "observed all the same"),
        change_request(RequestState.PENDING, RequestState.COMPLETED, why),
    )
