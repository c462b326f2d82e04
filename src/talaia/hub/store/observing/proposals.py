"""Proposals with their members, and the time that each has used.

Long, because a proposal, who is in it and what it has used are read and written together.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import and_, delete, func, insert, or_, select, update

from talaia.hub.errors import HubError, NameTaken, UnknownPerson
from talaia.hub.observing.proposal_access import ProposalRole
from talaia.hub.observing.quotas import ProposalLimits, TimeAccount
from talaia.hub.store.observing.revisions import raise_revision
from talaia.hub.store.observing_tables import (
    observations,
    observing_requests,
    proposal_members,
    proposals,
    request_groups,
)
from talaia.hub.store.tables import users
from talaia.model.observing.requests import Proposal, Urgency
from talaia.model.observing.states import RequestState

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from sqlalchemy import ColumnElement, Row
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["KeptProposal", "ProposalInUse", "ProposalMember", "ProposalStore", "time_accounts"]

_HOUR = 3600.0
_NOTHING = TimeAccount()


class ProposalInUse(HubError):
    """A proposal that requests were made for is ended, not removed."""


class ProposalMember(NamedTuple):
    """Who is in a proposal, and as what."""

    user: int
    name: str
    role: ProposalRole


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptProposal:
    """A proposal as it is kept.

    Attributes:
        site: whose nights it is for.
        id: short, as on forms.
        title: what it is about.
        share: of the shutter time that it is due (0 to 1).
        limits: what may be asked in its name.
        is_open: whoever may view the site sees its requests.
        needs_approval: what is handed in waits until somebody approves it.
        members: by name; empty where it is about to be written.
        account: time that it has used and promised.

    """

    site: str
    id: str
    title: str
    share: float
    limits: ProposalLimits
    is_open: bool
    needs_approval: bool
    members: tuple[ProposalMember, ...] = ()
    account: TimeAccount = _NOTHING

    def role_of(self, user: int) -> ProposalRole | None:
        """Give what a person is in it; None: no member."""
        return next((member.role for member in self.members if member.user == user), None)

    def planned(self) -> Proposal:
        """Give it as planners know it."""
        return Proposal(
            id=self.id,
            title=self.title,
            share=self.share,
            hours_allocated=self.limits.hours,
            hours_used=min(200_000.0, self.account.used / _HOUR),
            active=self.limits.active,
        )


class ProposalStore:
    """Rows of proposals."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps changes."""
        self._database = database
        self._clock = clock

    async def list_proposals(self, site: str) -> list[KeptProposal]:
        """List a site's proposals in the order of their ids."""
        async with self._database.read() as connection:
            return await read_proposals(connection, site)

    async def find_proposal(self, site: str, proposal: str) -> KeptProposal | None:
        """Find one."""
        async with self._database.read() as connection:
            found = await read_proposals(connection, site, proposal)
        return found[0] if found else None

    async def person_account(self, site: str, proposal: str, user: int) -> TimeAccount:
        """Give what one person has used and promised of a proposal."""
        async with self._database.read() as connection:
            found = await time_accounts(connection, site, proposal, user)
        return found.get(proposal, TimeAccount())

    async def add_proposal(self, proposal: KeptProposal) -> None:
        """Add a proposal; its members are set by `set_member`.

        Raises:
            NameTaken: the site has one of that id, in any case.

        """
        async with self._database.write() as connection:
            known = await connection.execute(
                select(proposals.c.proposal).where(proposals.c.site == proposal.site)
            )
            # In any case: people write both for one.
            if proposal.id.lower() in {name.lower() for name in known.scalars()}:
                raise NameTaken(f"there is a proposal {proposal.id!r} already")
            await connection.execute(
                insert(proposals).values(
                    site=proposal.site, proposal=proposal.id, **self._row_of(proposal)
                )
            )
            # Gateways plan by what proposals may use: what is asked is sent to them anew.
            await raise_revision(connection, proposal.site)

    async def change_proposal(self, proposal: KeptProposal) -> bool:
        """Change all of it but its id and members; False: there is no such proposal."""
        async with self._database.write() as connection:
            done = await connection.execute(
                update(proposals)
                .where(*_is_proposal(proposal.site, proposal.id))
                .values(**self._row_of(proposal))
            )
            await raise_revision(connection, proposal.site)
        return done.rowcount == 1

    async def remove_proposal(self, site: str, proposal: str) -> bool:
        """Remove one for which nothing was ever asked; False: there is none.

        Raises:
            ProposalInUse: there are requests.

        """
        async with self._database.write() as connection:
            # In the same transaction: a request may be handed in meanwhile.
            asked = select(func.count()).where(
                request_groups.c.site == site, request_groups.c.proposal == proposal
            )
            if (await connection.execute(asked)).scalar_one():
                raise ProposalInUse("there are requests for this proposal", "end it instead")
            # Members first: a proposal of the same id may be made later, by others.
            await connection.execute(
                delete(proposal_members).where(
                    proposal_members.c.site == site, proposal_members.c.proposal == proposal
                )
            )
            done = await connection.execute(delete(proposals).where(*_is_proposal(site, proposal)))
            await raise_revision(connection, site)
        return done.rowcount == 1

    async def set_member(
        self, site: str, proposal: str, name: str, role: ProposalRole | None
    ) -> bool:
        """Let an account be in a proposal, or no more (no role); False: no such proposal.

        Raises:
            UnknownPerson: nobody has that name.

        """
        async with self._database.write() as connection:
            known = await connection.execute(
                select(proposals.c.proposal).where(*_is_proposal(site, proposal))
            )
            if known.first() is None:
                return False
            user = (
                await connection.execute(select(users.c.id).where(users.c.name == name))
            ).scalar()
            if user is None:
                raise UnknownPerson(f"there is nobody named {name!r}")
            await connection.execute(
                delete(proposal_members).where(
                    proposal_members.c.site == site,
                    proposal_members.c.proposal == proposal,
                    proposal_members.c.user_id == user,
                )
            )
            if role is not None:
                await connection.execute(
                    insert(proposal_members).values(
                        site=site, proposal=proposal, user_id=user, role=role.value
                    )
                )
        return True

    def _row_of(self, proposal: KeptProposal) -> dict[str, object]:
        limits = proposal.limits
        return {
            "title": proposal.title,
            "share": proposal.share,
            "hours_allocated": limits.hours,
            "person_hours": limits.person_hours,
            "max_priority": limits.max_priority,
            "urgencies": ",".join(sorted(urgency.value for urgency in limits.urgencies)),
            "active": limits.active,
            "is_open": proposal.is_open,
            "needs_approval": proposal.needs_approval,
            "changed_us": self._clock.wall_ns() // 1000,
        }


async def read_proposals(
    connection: AsyncConnection, site: str, proposal: str = ""
) -> list[KeptProposal]:
    """Read a site's proposals, or one of them, with members and accounts."""
    chosen = [proposals.c.site == site]
    if proposal:
        chosen.append(proposals.c.proposal == proposal)
    rows = (
        await connection.execute(select(proposals).where(*chosen).order_by(proposals.c.proposal))
    ).all()
    if not rows:
        return []
    members = await _read_members(connection, site, proposal)
    accounts = await time_accounts(connection, site, proposal)
    return [
        _row_to_proposal(
            row, members.get(row.proposal, ()), accounts.get(row.proposal, TimeAccount())
        )
        for row in rows
    ]


async def time_accounts(
    connection: AsyncConnection, site: str, proposal: str = "", user: int | None = None
) -> dict[str, TimeAccount]:
    """Add up what each proposal of a site has used and promised, or one person of it."""
    used = select(observations.c.proposal, func.sum(observations.c.block_s)).where(
        observations.c.site == site
    )
    promised = (
        select(observing_requests.c.proposal, func.sum(observing_requests.c.charge_s))
        .join(request_groups, request_groups.c.id == observing_requests.c.group_id)
        .where(
            observing_requests.c.site == site,
            # A draft that was handed in waits to be approved: its time is promised, too.
            or_(
                observing_requests.c.state == RequestState.PENDING.value,
                and_(
                    observing_requests.c.state == RequestState.DRAFT.value,
                    request_groups.c.submitted_us > 0,
                ),
            ),
        )
    )
    if proposal:
        used = used.where(observations.c.proposal == proposal)
        promised = promised.where(observing_requests.c.proposal == proposal)
    if user is not None:
        used = used.where(observations.c.user_id == user)
        promised = promised.where(request_groups.c.user_id == user)
    sums: list[dict[str, float]] = []
    for asked, by in ((used, observations.c.proposal), (promised, observing_requests.c.proposal)):
        rows = await connection.execute(asked.group_by(by))
        sums.append({row[0]: float(row[1] or 0.0) for row in rows})
    return {
        name: TimeAccount(sums[0].get(name, 0.0), sums[1].get(name, 0.0))
        for name in sums[0].keys() | sums[1].keys()
    }


async def _read_members(
    connection: AsyncConnection, site: str, proposal: str
) -> Mapping[str, Sequence[ProposalMember]]:
    asked = (
        select(proposal_members, users.c.name)
        .join(users, users.c.id == proposal_members.c.user_id)
        .where(proposal_members.c.site == site)
        .order_by(users.c.name)
    )
    if proposal:
        asked = asked.where(proposal_members.c.proposal == proposal)
    found: dict[str, list[ProposalMember]] = {}
    for row in await connection.execute(asked):
        member = ProposalMember(row.user_id, row.name, ProposalRole(row.role))
        found.setdefault(row.proposal, []).append(member)
    return found


def _row_to_proposal(
    row: Row[tuple[object, ...]], members: Sequence[ProposalMember], account: TimeAccount
) -> KeptProposal:
    return KeptProposal(
        site=row.site,
        id=row.proposal,
        title=row.title,
        share=row.share,
        limits=ProposalLimits(
            hours=row.hours_allocated,
            person_hours=row.person_hours,
            max_priority=row.max_priority,
            urgencies=frozenset(map(Urgency, filter(None, row.urgencies.split(",")))),
            # Booleans are numbers in MariaDB and SQLite.
            active=bool(row.active),
        ),
        is_open=bool(row.is_open),
        needs_approval=bool(row.needs_approval),
        members=tuple(members),
        account=account,
    )


def _is_proposal(site: str, proposal: str) -> tuple[ColumnElement[bool], ...]:
    return proposals.c.site == site, proposals.c.proposal == proposal
