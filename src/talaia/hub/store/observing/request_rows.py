"""Rows of request groups and requests, read and written; every change of a state has its log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import msgspec
from sqlalchemy import insert, select, update

from talaia.hub.store.observing_tables import observing_requests, request_groups, request_log
from talaia.hub.store.safe_text import safe_text
from talaia.model.observing.requests import GroupOperator, Request, RequestGroup, Urgency
from talaia.model.observing.states import RequestState
from talaia.model.observing.targets import target_name

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from sqlalchemy import ColumnElement, Row
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.hub.observing.changes import StateChange

__all__ = [
    "EndedRequest",
    "KeptGroup",
    "insert_requests",
    "insert_row",
    "read_groups",
    "write_change",
]

_SECOND = 1_000_000
# Of a request that no row has yet.
_NEW = "new"


class EndedRequest(NamedTuple):
    """A request that has just reached a final state.

    Attributes:
        id: its number.
        user: who asked.
        log: the number of its line in the request's log.

    """

    id: int
    site: str
    proposal: str
    user: int
    target: str
    state: RequestState
    why: str
    log: int


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptGroup:
    """A request group as it is kept.

    Attributes:
        group: with its requests, as they stand.
        site: whose night is asked for.
        user: the number of the account that asked.
        charges: estimate of each request (s).
        submitted_us: when it was handed in (UTC); 0: a draft.
        approved_us: when somebody approved it (UTC); 0: nobody has.
        approved_by: who; empty: nobody.

    """

    group: RequestGroup
    site: str
    user: int
    charges: tuple[float, ...]
    submitted_us: int = 0
    approved_us: int = 0
    approved_by: str = ""

    @property
    def charge(self) -> float:
        """What is charged for it all (s)."""
        return sum(self.charges)


async def insert_row(connection: AsyncConnection, kept: KeptGroup, now_us: int) -> int:
    """Write a new group without its requests; give its number."""
    group = kept.group
    added = await connection.execute(
        insert(request_groups).values(
            site=kept.site,
            proposal=group.proposal,
            name=safe_text(group.name, 200),
            user_id=kept.user,
            requester=group.requester,
            operator=group.operator.value,
            urgency=group.urgency.value,
            priority=group.priority,
            created_us=now_us,
            submitted_us=kept.submitted_us,
            approved_us=kept.approved_us,
            approved_by=kept.approved_by,
        )
    )
    key = added.inserted_primary_key
    return int(key[0]) if key else 0


async def insert_requests(
    connection: AsyncConnection, number: int, kept: KeptGroup, *, who: str, now_us: int
) -> None:
    """Write the requests of a group, each with the first line of its log."""
    for position, (request, charge) in enumerate(
        zip(kept.group.requests, kept.charges, strict=True)
    ):
        bare = msgspec.structs.replace(
            request, id=_NEW, state=RequestState.DRAFT, frames_done=(), failures=0
        )
        added = await connection.execute(
            insert(observing_requests).values(
                group_id=number,
                site=kept.site,
                proposal=kept.group.proposal,
                position=position,
                state=request.state.value,
                target_name=safe_text(target_name(request.target), 200) if request.target else "",
                definition=msgspec.json.encode(bare).decode(),
                charge_s=charge,
                start_us=round(min(window.start for window in request.windows) * _SECOND),
                end_us=round(max(window.end for window in request.windows) * _SECOND),
                frames_done="[]",
                failures=0,
                changed_us=now_us,
            )
        )
        key = added.inserted_primary_key
        await connection.execute(
            insert(request_log).values(
                request_id=int(key[0]) if key else 0,
                time_us=now_us,
                who=who,
                from_state="",
                to_state=request.state.value,
                why="made",
            )
        )


async def write_change(
    connection: AsyncConnection,
    number: int,
    change: StateChange,
    *,
    who: str,
    now_us: int,
    failures: int | None = None,
) -> int:
    """Write a request's change of state and its line in the log; give the line's number."""
    values: dict[str, object] = {"state": change.after.value, "changed_us": now_us}
    if failures is not None:
        values["failures"] = failures
    await connection.execute(
        update(observing_requests).where(observing_requests.c.id == number).values(**values)
    )
    added = await connection.execute(
        insert(request_log).values(
            request_id=number,
            time_us=now_us,
            who=who,
            from_state=change.before.value,
            to_state=change.after.value,
            why=safe_text(change.why, 2000),
        )
    )
    key = added.inserted_primary_key
    return int(key[0]) if key else 0


async def read_groups(
    connection: AsyncConnection, conditions: Sequence[ColumnElement[bool]], limit: int
) -> list[KeptGroup]:
    """Read groups with their requests, in the order of their numbers."""
    rows = (
        await connection.execute(
            select(request_groups).where(*conditions).order_by(request_groups.c.id).limit(limit)
        )
    ).all()
    if not rows:
        return []
    requests = await connection.execute(
        select(observing_requests)
        .where(observing_requests.c.group_id.in_([row.id for row in rows]))
        .order_by(observing_requests.c.group_id, observing_requests.c.position)
    )
    by_group: dict[int, list[Row[tuple[object, ...]]]] = {}
    for row in requests:
        by_group.setdefault(row.group_id, []).append(row)
    return list(_kept_groups(rows, by_group))


def _kept_groups(
    rows: Iterable[Row[tuple[object, ...]]],
    by_group: Mapping[int, Sequence[Row[tuple[object, ...]]]],
) -> Iterable[KeptGroup]:
    for row in rows:
        of_group = by_group.get(row.id, ())
        # Written in one transaction with its requests: there are always some.
        if of_group:
            yield KeptGroup(
                group=RequestGroup(
                    id=str(row.id),
                    proposal=row.proposal,
                    name=row.name,
                    requester=row.requester,
                    operator=GroupOperator(row.operator),
                    urgency=Urgency(row.urgency),
                    priority=row.priority,
                    created_at=row.created_us / _SECOND,
                    requests=tuple(map(_row_to_request, of_group)),
                ),
                site=row.site,
                user=row.user_id,
                charges=tuple(request.charge_s for request in of_group),
                submitted_us=row.submitted_us,
                approved_us=row.approved_us,
                approved_by=row.approved_by,
            )


def _row_to_request(row: Row[tuple[object, ...]]) -> Request:
    return msgspec.structs.replace(
        _DEFINITION.decode(row.definition),
        id=str(row.id),
        state=RequestState(row.state),
        frames_done=tuple(_FRAMES.decode(row.frames_done)),
        failures=row.failures,
    )


_DEFINITION = msgspec.json.Decoder(Request)
_FRAMES = msgspec.json.Decoder(list[int])
