"""Request groups and requests: handed in, found, changed, with the log of every change.

Long, because what a person may do with a group is one transaction each, and they share their steps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sqlalchemy import delete, select, update

from talaia.hub.observing.changes import ImpossibleChange, StateChange, change_request
from talaia.hub.observing.quotas import TimeAccount
from talaia.hub.store.history_servers.own_rows import every_row
from talaia.hub.store.observing.proposals import read_proposals, time_accounts
from talaia.hub.store.observing.request_notices import add_request_notices
from talaia.hub.store.observing.request_queries import (
    Admission,
    GroupRefused,
    GroupStep,
    PendingSet,
    PlannedRequest,
    RequestFilter,
    RequestLine,
    RequestSummary,
)
from talaia.hub.store.observing.request_rows import (
    EndedRequest,
    KeptGroup,
    insert_requests,
    insert_row,
    read_groups,
    write_change,
)
from talaia.hub.store.observing.revisions import raise_revision, read_revision
from talaia.hub.store.observing_tables import observing_requests, request_groups, request_log
from talaia.model.observing.states import FINAL_REQUEST_STATES, RequestState

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterable, Sequence

    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.store.database import Database
    from talaia.hub.store.history_servers.own_rows import OwnRows

__all__ = ["RequestStore"]


class RequestStore:
    """Rows of groups and requests."""

    def __init__(self, database: Database, clock: Clock, own: OwnRows = every_row) -> None:
        """Work on ``database``; ``clock`` stamps what happens. Only ``own`` sites' ones end."""
        self._database = database
        self._own = own
        self._clock = clock

    async def add_group(
        self,
        kept: KeptGroup,
        admit: Admission | None,
        also: Callable[[AsyncConnection, int], Awaitable[None]] | None = None,
    ) -> int:
        """Write a new group; give its number.

        Args:
            kept: the group, whose ids are not meant; its requests have the state they begin in.
            admit: asked whether it may be handed in; none: it is a draft.
            also: writes what is to be there if, and only if, the group is; given its number.

        Raises:
            GroupRefused: there is no such proposal, or the group may not be handed in.

        """
        now_us = self._now_us()
        async with self._database.write() as connection:
            await _check_admission(connection, kept, admit)
            # Time was counted in this same transaction, so two groups handed in at once cannot
            # both have the last hour of a proposal.
            number = await insert_row(connection, kept, now_us)
            await insert_requests(connection, number, kept, who=kept.group.requester, now_us=now_us)
            # A draft is nothing to the gateway; only what may be observed makes it ask for a new
            # set.
            if any(request.state is RequestState.PENDING for request in kept.group.requests):
                await raise_revision(connection, kept.site)
            if also is not None:
                await also(connection, number)
        return number

    async def replace_draft(self, number: int, kept: KeptGroup, who: str) -> bool:
        """Write a draft anew; False: there is no such group, or it is no draft any more."""
        now_us, group = self._now_us(), kept.group
        async with self._database.write() as connection:
            await _check_admission(connection, kept, None)
            done = await connection.execute(
                update(request_groups)
                .where(
                    request_groups.c.id == number,
                    request_groups.c.site == kept.site,
                    request_groups.c.submitted_us == 0,
                )
                .values(
                    proposal=group.proposal,
                    name=group.name,
                    operator=group.operator.value,
                    urgency=group.urgency.value,
                    priority=group.priority,
                )
            )
            states = select(observing_requests.c.state).where(
                observing_requests.c.group_id == number
            )
            # Looked at after the update, which holds the row: handing in at the same time waits or
            # has won.
            if done.rowcount != 1 or set((await connection.execute(states)).scalars()) != {
                RequestState.DRAFT.value
            }:
                await connection.rollback()
                return False
            ids = select(observing_requests.c.id).where(observing_requests.c.group_id == number)
            # Requests of a draft get new numbers; nobody else knows the old ones yet.
            old = list((await connection.execute(ids)).scalars())
            await connection.execute(delete(request_log).where(request_log.c.request_id.in_(old)))
            await connection.execute(
                delete(observing_requests).where(observing_requests.c.group_id == number)
            )
            await insert_requests(connection, number, kept, who=who, now_us=now_us)
        return True

    async def find_group(self, site: str, number: int) -> KeptGroup | None:
        """Find a group of a site."""
        async with self._database.read() as connection:
            return await _find_group(connection, site, number)

    async def find_request(self, site: str, number: int) -> tuple[KeptGroup, int] | None:
        """Find the group of a request, and the request's place in it."""
        async with self._database.read() as connection:
            row = (
                await connection.execute(
                    select(observing_requests.c.group_id).where(
                        observing_requests.c.site == site, observing_requests.c.id == number
                    )
                )
            ).first()
            kept = await _find_group(connection, site, row.group_id) if row else None
        if kept is None:
            return None
        ids = [request.id for request in kept.group.requests]
        return kept, ids.index(str(number))

    async def list_requests(
        self, site: str, asked: RequestFilter, limit: int
    ) -> tuple[list[RequestSummary], bool]:
        """List requests, the newest first; tell whether there are more."""
        # Who may see no proposal sees no request, whatever else was asked for.
        if not asked.proposals:
            return [], False
        request, group = observing_requests.c, request_groups.c
        chosen = (
            select(
                request.id,
                request.group_id,
                group.name,
                request.proposal,
                group.requester,
                group.user_id,
                request.target_name,
                request.state,
                group.urgency,
                group.priority,
                request.charge_s,
                request.start_us,
                request.end_us,
                request.changed_us,
                group.submitted_us,
            )
            .join(request_groups, group.id == request.group_id)
            .where(request.site == site, *asked.sql_conditions())
            .order_by(request.id.desc())
            # One more than is shown tells whether there are more, without a count of all.
            .limit(limit + 1)
        )
        async with self._database.read() as connection:
            rows = (await connection.execute(chosen)).all()
        return [_row_to_summary(row) for row in rows[:limit]], len(rows) > limit

    async def describe_requests(self, site: str, ids: Iterable[str]) -> dict[str, PlannedRequest]:
        """Give proposal and target of requests by their ids; those that nobody made are not in."""
        # So many digits always fit a column of 64 bits.
        numbers = [int(one) for one in ids if one.isascii() and one.isdecimal() and len(one) <= 18]
        request = observing_requests.c
        found: dict[str, PlannedRequest] = {}
        async with self._database.read() as connection:
            for at in range(0, len(numbers), _AT_ONCE):
                rows = await connection.execute(
                    select(request.id, request.proposal, request.target_name).where(
                        request.site == site, request.id.in_(numbers[at : at + _AT_ONCE])
                    )
                )
                for row in rows:
                    found[str(row.id)] = PlannedRequest(row.proposal, row.target_name)
        return found

    async def read_log(self, request: int) -> list[RequestLine]:
        """Give a request's log, the oldest line first."""
        chosen = (
            select(request_log)
            .where(request_log.c.request_id == request)
            .order_by(request_log.c.id)
        )
        async with self._database.read() as connection:
            return [
                RequestLine(row.time_us, row.who, row.from_state, row.to_state, row.why)
                for row in await connection.execute(chosen)
            ]

    async def change_group(
        self, site: str, number: int, step: GroupStep, admit: Admission | None = None
    ) -> list[EndedRequest]:
        """Change the state of a group's requests; give those that have ended by it.

        Args:
            site: whose group it is.
            number: of the group.
            step: what is done.
            admit: asked whether it may be handed in; none: that is not asked.

        Raises:
            ImpossibleChange: none of its requests is in a state from which that may follow.
            GroupRefused: the group may not be handed in.

        """
        now_us, ended = self._now_us(), []
        async with self._database.write() as connection:
            kept = await _find_group(connection, site, number)
            if kept is None:
                raise ImpossibleChange("there is no such group any more")
            if step.approved and not kept.submitted_us:
                # Taken back a moment ago: what was read is not what would be approved.
                raise ImpossibleChange("it is not handed in any more")
            if admit is not None:
                await _check_admission(connection, kept, admit)
            meant = [
                request
                for request in kept.group.requests
                if request.state in step.states and step.request in {None, int(request.id)}
            ]
            if not meant:
                stand = ", ".join(sorted({one.state.value for one in kept.group.requests}))
                raise ImpossibleChange(
                    f"nothing of this group can become {step.after.value}: it is {stand}"
                )
            for request in meant:
                # Asked for twice (a double click, a repeated request): it is so already.
                if step.after is request.state:
                    continue
                change = change_request(request.state, step.after, step.why)
                # Tried again: its failures are of before.
                again = 0 if step.after is RequestState.PENDING else None
                log = await write_change(
                    connection,
                    int(request.id),
                    change,
                    who=step.who,
                    now_us=now_us,
                    failures=again,
                )
                if step.after in FINAL_REQUEST_STATES:
                    ended.append(_ended(kept, request.id, change, log))
            await self._mark_group(connection, number, step, now_us)
            await raise_revision(connection, site)
        return ended

    async def expire_requests(self, limit: int = 500) -> list[EndedRequest]:
        """End those of own sites whose last window is over, up to ``limit``; give them."""
        now_us, ended, column = self._now_us(), [], observing_requests.c
        is_over = (column.state == RequestState.PENDING.value, column.end_us < now_us)
        over = (*is_over, *self._own(column.site))
        ids = select(observing_requests.c.id, request_groups.c.user_id).join(
            request_groups, request_groups.c.id == observing_requests.c.group_id
        )
        # Looked for first without the turn to write: mostly there is nothing.
        async with self._database.read() as connection:
            if (await connection.execute(ids.where(*over).limit(1))).first() is None:
                return []
        async with self._database.write() as connection:
            rows = await connection.execute(
                select(observing_requests, request_groups.c.user_id)
                .join(request_groups, request_groups.c.id == observing_requests.c.group_id)
                .where(*over)
                .order_by(observing_requests.c.id)
                .limit(limit)
            )
            for row in rows.all():
                change = change_request(
                    RequestState.PENDING, RequestState.WINDOW_EXPIRED, "its last window is over"
                )
                log = await write_change(connection, row.id, change, who="", now_us=now_us)
                one = EndedRequest(
                    id=row.id,
                    site=row.site,
                    proposal=row.proposal,
                    user=row.user_id,
                    target=row.target_name,
                    state=change.after,
                    why=change.why,
                    log=log,
                )
                ended.append(one)
                await add_request_notices(connection, one, now_us)
        return ended

    async def pending_set(self, site: str) -> PendingSet:
        """Give all groups with a request that is pending, and their revision, as of one moment."""
        found: list[KeptGroup] = []
        pending = (
            select(observing_requests.c.group_id)
            .where(
                observing_requests.c.site == site,
                observing_requests.c.state == RequestState.PENDING.value,
            )
            .distinct()
        )
        async with self._database.read() as connection:
            revision, last = await read_revision(connection, site), 0
            # In pages, yet in one transaction: the revision and the set belong to one moment.
            while page := await read_groups(
                connection,
                [request_groups.c.id.in_(pending), request_groups.c.id > last],
                _AT_ONCE,
            ):
                found += page
                last = int(page[-1].group.id)
        return PendingSet(revision, found)

    async def newest_revision(self, site: str) -> int:
        """Give the revision of a site's requests; 0: nothing was ever asked."""
        async with self._database.read() as rows:
            return await read_revision(rows, site)

    async def raise_revision(self, site: str, beyond: int) -> int:
        """Raise a site's revision above what its gateway says that it has."""
        async with self._database.write() as connection:
            return await raise_revision(connection, site, beyond)

    async def _mark_group(
        self, connection: AsyncConnection, number: int, step: GroupStep, now_us: int
    ) -> None:
        values: dict[str, object] = {}
        if step.submitted is not None:
            values["submitted_us"] = now_us if step.submitted else 0
        if step.approved:
            values |= {"approved_us": now_us, "approved_by": step.who}
        elif step.submitted is False:
            values |= {"approved_us": 0, "approved_by": ""}
        if values:
            await connection.execute(
                update(request_groups).where(request_groups.c.id == number).values(**values)
            )

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


# Groups that are read at a time.
_AT_ONCE = 500


async def _check_admission(
    connection: AsyncConnection, kept: KeptGroup, admit: Admission | None
) -> None:
    found = await read_proposals(connection, kept.site, kept.group.proposal)
    if not found:
        raise GroupRefused([f"there is no proposal {kept.group.proposal!r}"])
    if admit is None:
        return
    accounts = await time_accounts(connection, kept.site, kept.group.proposal, kept.user)
    problems = admit(found[0], accounts.get(kept.group.proposal, TimeAccount()))
    if problems:
        raise GroupRefused(problems)


async def _find_group(connection: AsyncConnection, site: str, number: int) -> KeptGroup | None:
    found = await read_groups(
        connection, [request_groups.c.site == site, request_groups.c.id == number], 1
    )
    return found[0] if found else None


def _ended(kept: KeptGroup, request: str, change: StateChange, log: int) -> EndedRequest:
    wanted = next(one for one in kept.group.requests if one.id == request)
    name = wanted.target.name if wanted.target is not None else ""
    return EndedRequest(
        int(request),
        kept.site,
        kept.group.proposal,
        kept.user,
        name,
        change.after,
        change.why,
        log,
    )


def _row_to_summary(row: Sequence[Any]) -> RequestSummary:
    summary = RequestSummary(*row)
    # The last is when it was handed in.
    return summary._replace(state=RequestState(summary.state), submitted=bool(summary.submitted))
