"""What is asked of the store of requests, and what it gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

from sqlalchemy import func, or_

from talaia.hub.errors import HubError
from talaia.hub.store.observing_tables import observing_requests, request_groups
from talaia.model.observing.states import RequestState

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from sqlalchemy import ColumnElement

    from talaia.hub.observing.quotas import TimeAccount
    from talaia.hub.store.observing.proposals import KeptProposal
    from talaia.hub.store.observing.request_rows import KeptGroup

__all__ = [
    "Admission",
    "GroupRefused",
    "GroupStep",
    "PendingSet",
    "PlannedRequest",
    "RequestFilter",
    "RequestLine",
    "RequestSummary",
]


class GroupRefused(HubError):
    """A group does not fit its proposal; the problems say each why.

    Attributes:
        problems: in words.

    """

    def __init__(self, problems: Sequence[str]) -> None:
        """Keep each problem."""
        super().__init__("; ".join(problems))
        self.problems = tuple(problems)


class Admission(Protocol):
    """Says why a group may not be handed in; asked in the transaction that writes it."""

    def __call__(self, proposal: KeptProposal, person: TimeAccount) -> list[str]:
        """List what is wrong, in words."""
        ...


class RequestSummary(NamedTuple):
    """A request in a list."""

    id: int
    group: int
    group_name: str
    proposal: str
    requester: str
    user: int
    target: str
    state: RequestState
    urgency: str
    priority: float
    charge: float
    start_us: int
    end_us: int
    changed_us: int
    submitted: bool


class RequestLine(NamedTuple):
    """A line of a request's log; ``before`` is empty in the first."""

    time_us: int
    who: str
    before: str
    after: str
    why: str


class PlannedRequest(NamedTuple):
    """What a plan's block is of."""

    proposal: str
    target: str


class PendingSet(NamedTuple):
    """Groups with a request that is pending, and the revision that they are of."""

    revision: int
    groups: list[KeptGroup]


@dataclass(frozen=True, slots=True, kw_only=True)
class RequestFilter:
    """Which requests are meant; what is None or empty does not matter.

    Attributes:
        proposals: of one of these; the person sees no others.
        user: asked by this account.
        states: in one of these.
        text: stands in the target's or the group's name, in any case.
        waiting: handed in and not yet approved.
        before: only those with a smaller number.

    """

    proposals: Collection[str]
    user: int | None = None
    states: Collection[RequestState] = ()
    text: str = ""
    waiting: bool = False
    before: int | None = None

    def sql_conditions(self) -> list[ColumnElement[bool]]:
        """Write it in SQL."""
        request, group = observing_requests.c, request_groups.c
        said: list[ColumnElement[bool]] = [request.proposal.in_(sorted(self.proposals))]
        if self.user is not None:
            said.append(group.user_id == self.user)
        if self.states:
            said.append(request.state.in_(sorted(state.value for state in self.states)))
        if self.text:
            wanted = self.text.lower()
            said.append(
                or_(
                    func.lower(request.target_name).contains(wanted, autoescape=True),
                    func.lower(group.name).contains(wanted, autoescape=True),
                )
            )
        if self.waiting:
            said += [group.submitted_us > 0, request.state == RequestState.DRAFT.value]
        if self.before is not None:
            said.append(request.id < self.before)
        return said


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupStep:
    """What somebody does with requests of a group.

    Attributes:
        states: those in one of these change; others stay.
        after: what they become.
        who: does it.
        why: as it is logged.
        request: only this one; none: all.
        submitted: whether the group is handed in from now on; none: as it is.
        approved: by ``who``.

    """

    states: frozenset[RequestState]
    after: RequestState
    who: str
    why: str
    request: int | None = None
    submitted: bool | None = None
    approved: bool = False
