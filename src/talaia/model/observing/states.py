"""The states of requests and observations, and which may follow which.

States of a request are those of Las Cumbres' portal. An observation is one try at a request: a
request whose roof closed above it has one that was suspended and goes on, not a failed one.
"""

from __future__ import annotations

from enum import StrEnum

__all__ = [
    "FINAL_OBSERVATION_STATES",
    "FINAL_REQUEST_STATES",
    "OBSERVATION_CHANGES",
    "REQUEST_CHANGES",
    "ObservationState",
    "RequestState",
    "SuspensionCause",
]


class RequestState(StrEnum):
    """Where a request stands."""

    # Written, not yet handed in or not yet approved: no planner sees it.
    DRAFT = "DRAFT"
    PENDING = "PENDING"
    COMPLETED = "COMPLETED"
    WINDOW_EXPIRED = "WINDOW_EXPIRED"
    CANCELED = "CANCELED"
    FAILURE_LIMIT_REACHED = "FAILURE_LIMIT_REACHED"


class ObservationState(StrEnum):
    """Where one try at a request stands."""

    PENDING = "PENDING"
    IN_PROGRESS = "IN_PROGRESS"
    # Frames that were read out are kept; the rest is taken later.
    SUSPENDED = "SUSPENDED"
    COMPLETED = "COMPLETED"
    # Ended by a person.
    ABORTED = "ABORTED"
    # Ended by a device; counts towards the request's limit.
    FAILED = "FAILED"
    NOT_ATTEMPTED = "NOT_ATTEMPTED"
    CANCELED = "CANCELED"
    # Taken, and of no use.
    BAD_DATA = "BAD_DATA"


class SuspensionCause(StrEnum):
    """Why an observation was suspended: none of these counts as a failure of its request."""

    WEATHER = "weather"
    RAPID = "rapid"
    FAULT = "fault"
    PERSON = "person"


REQUEST_CHANGES: dict[RequestState, frozenset[RequestState]] = {
    RequestState.DRAFT: frozenset({RequestState.PENDING, RequestState.CANCELED}),
    RequestState.PENDING: frozenset(
        {
            # Taken back for a change.
            RequestState.DRAFT,
            RequestState.COMPLETED,
            RequestState.WINDOW_EXPIRED,
            RequestState.CANCELED,
            RequestState.FAILURE_LIMIT_REACHED,
        }
    ),
    # Bad data: it is observed once more.
    RequestState.COMPLETED: frozenset({RequestState.PENDING}),
    RequestState.WINDOW_EXPIRED: frozenset({RequestState.COMPLETED}),
    RequestState.CANCELED: frozenset({RequestState.COMPLETED}),
    # A person looked at what failed, and lets it be tried again.
    RequestState.FAILURE_LIMIT_REACHED: frozenset(
        {RequestState.PENDING, RequestState.COMPLETED, RequestState.CANCELED}
    ),
}
"""What may follow. An ended one is completed all the same by a report that came late."""

FINAL_REQUEST_STATES = frozenset(
    {
        RequestState.COMPLETED,
        RequestState.WINDOW_EXPIRED,
        RequestState.CANCELED,
        RequestState.FAILURE_LIMIT_REACHED,
    }
)

_ENDS = frozenset(
    {
        ObservationState.COMPLETED,
        ObservationState.ABORTED,
        ObservationState.FAILED,
        ObservationState.CANCELED,
        ObservationState.BAD_DATA,
    }
)

OBSERVATION_CHANGES: dict[ObservationState, frozenset[ObservationState]] = {
    ObservationState.PENDING: frozenset(
        {ObservationState.IN_PROGRESS, ObservationState.NOT_ATTEMPTED, ObservationState.CANCELED}
    ),
    ObservationState.IN_PROGRESS: _ENDS | {ObservationState.SUSPENDED},
    ObservationState.SUSPENDED: _ENDS | {ObservationState.IN_PROGRESS},
    ObservationState.COMPLETED: frozenset({ObservationState.BAD_DATA}),
    ObservationState.ABORTED: frozenset(),
    ObservationState.FAILED: frozenset(),
    ObservationState.NOT_ATTEMPTED: frozenset(),
    ObservationState.CANCELED: frozenset(),
    ObservationState.BAD_DATA: frozenset(),
}

FINAL_OBSERVATION_STATES = frozenset(
    {ObservationState.NOT_ATTEMPTED, *_ENDS},
)
