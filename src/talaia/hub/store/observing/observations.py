"""What gateways report on observations: each report once, whatever happens to link and hub.

A report is known by its observation and its number: one that is not newer than what is kept
changes nothing, so a gateway may repeat all that was not acknowledged.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec
from sqlalchemy import insert, or_, select, update

from talaia.hub.observing.changes import can_follow, observation_effect
from talaia.hub.observing.frame_assignment import ObservationSpan
from talaia.hub.store.observing.request_notices import add_request_notices
from talaia.hub.store.observing.request_rows import EndedRequest, write_change
from talaia.hub.store.observing.revisions import raise_revision
from talaia.hub.store.observing_tables import observations, observing_requests, request_groups
from talaia.hub.store.safe_text import safe_text
from talaia.model.observing.states import FINAL_REQUEST_STATES, ObservationState, RequestState

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Row
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.store.database import Database
    from talaia.wire.gateway_messages.night import ObservationUpdate

__all__ = ["KeptObservation", "ObservationStore", "StoredReports"]

_SECOND = 1_000_000
# Names of files of one observation that are kept; a night has fewer.
_MOST_FILES = 20_000


class KeptObservation(NamedTuple):
    """One try at a request, as its gateway reported it last."""

    id: str
    request: int
    state: ObservationState
    cause: str
    why: str
    began_us: int
    changed_us: int
    frames_done: list[int]
    block_s: float
    files: list[str]


class StoredReports(NamedTuple):
    """What reports came to.

    Attributes:
        ended: requests that have reached a final state by them.
        changed: numbers of requests of which anything is new.
        oddities: what cannot be, in words: an unknown request, a state that cannot follow.
        again: requests that are to be observed once more, as their gateway has to be told.

    """

    ended: list[EndedRequest]
    changed: list[int]
    oddities: list[str]
    again: list[int]


class ObservationStore:
    """Rows of observations."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps changes of requests."""
        self._database = database
        self._clock = clock

    async def store_reports(self, site: str, reports: Sequence[ObservationUpdate]) -> StoredReports:
        """Keep reports in the order of their numbers, all or none."""
        stored = StoredReports([], [], [], [])
        async with self._database.write() as connection:
            # One message may hold several reports of one observation, and a later state must win.
            for report in sorted(reports, key=lambda one: one.number):
                await self._store_report(connection, site, report, stored)
        return stored

    async def observations_of(self, site: str, request: int) -> list[KeptObservation]:
        """List the tries at a request, the first first."""
        chosen = (
            select(observations)
            .where(observations.c.site == site, observations.c.request_id == request)
            .order_by(observations.c.began_us, observations.c.observation)
        )
        async with self._database.read() as connection:
            return [_row_to_observation(row) for row in await connection.execute(chosen)]

    async def spans_between(self, site: str, begin_us: int, end_us: int) -> list[ObservationSpan]:
        """List the observations of which a part lies between two moments."""
        chosen = (
            select(observations, observing_requests.c.target_name)
            .join(observing_requests, observing_requests.c.id == observations.c.request_id)
            .where(
                observations.c.site == site,
                observations.c.began_us <= end_us,
                or_(
                    observations.c.changed_us >= begin_us,
                    observations.c.state == ObservationState.IN_PROGRESS.value,
                ),
            )
        )
        async with self._database.read() as connection:
            return [
                ObservationSpan(
                    row.observation,
                    row.request_id,
                    row.proposal,
                    row.target_name,
                    row.began_us,
                    None if row.state == ObservationState.IN_PROGRESS.value else row.changed_us,
                )
                for row in await connection.execute(chosen)
            ]

    async def _store_report(
        self,
        connection: AsyncConnection,
        site: str,
        report: ObservationUpdate,
        stored: StoredReports,
    ) -> None:
        before = (
            await connection.execute(
                select(observations).where(
                    observations.c.site == site, observations.c.observation == report.id
                )
            )
        ).first()
        # Repeated since its acknowledgement was lost, or overtaken by a newer one.
        if before is not None and before.number >= report.number:
            return
        asked = await _find_request(connection, site, report.request)
        # Kept all the same: what a telescope did stays on record even if its request was deleted
        # since.
        if asked is None:
            stored.oddities.append(
                f"observation {report.id} is of a request {report.request!r} that nobody made"
            )
        was = ObservationState(before.state) if before is not None else None
        # Kept, too: the gateway was there and we were not; people are told that it cannot be.
        if not can_follow(was, report.state):
            stored.oddities.append(
                f"observation {report.id} went from {was} to {report.state}, which cannot follow"
            )
        await _write_observation(connection, site, report, before=before, asked=asked)
        if asked is not None:
            stored.changed.append(asked.id)
            await self._apply_report(connection, report, was=was, asked=asked, stored=stored)

    async def _apply_report(
        self,
        connection: AsyncConnection,
        report: ObservationUpdate,
        *,
        was: ObservationState | None,
        asked: Row[tuple[object, ...]],
        stored: StoredReports,
    ) -> None:
        site = asked.site
        # In the same transaction as the report, so that a request is never complete without the
        # observation that completed it.
        effect = observation_effect(
            RequestState(asked.state),
            asked.failures,
            before=was,
            after=report.state,
            why=report.why,
        )
        await connection.execute(
            update(observing_requests)
            .where(observing_requests.c.id == asked.id)
            .values(
                frames_done=msgspec.json.encode(report.frames_done).decode(),
                failures=effect.failures,
            )
        )
        for change in effect.changes:
            log = await write_change(
                connection, asked.id, change, who="", now_us=self._clock.wall_ns() // 1000
            )
            if change.after in FINAL_REQUEST_STATES:
                ended = EndedRequest(
                    id=asked.id,
                    site=site,
                    proposal=asked.proposal,
                    user=asked.user_id,
                    target=asked.target_name,
                    state=change.after,
                    why=change.why,
                    log=log,
                )
                stored.ended.append(ended)
                await add_request_notices(connection, ended, self._clock.wall_ns() // 1000)
            else:
                # It is to be observed once more, which its gateway does not know by itself.
                await raise_revision(connection, site)
                stored.again.append(asked.id)


async def _find_request(
    connection: AsyncConnection, site: str, request: str
) -> Row[tuple[object, ...]] | None:
    # So many digits always fit a column of 64 bits.
    if not (request.isascii() and request.isdecimal()) or len(request) > 18:
        return None
    found = await connection.execute(
        select(observing_requests, request_groups.c.user_id)
        .join(request_groups, request_groups.c.id == observing_requests.c.group_id)
        .where(observing_requests.c.site == site, observing_requests.c.id == int(request))
    )
    return found.first()


async def _write_observation(
    connection: AsyncConnection,
    site: str,
    report: ObservationUpdate,
    *,
    before: Row[tuple[object, ...]] | None,
    asked: Row[tuple[object, ...]] | None,
) -> None:
    time_us = round(report.time * _SECOND)
    # Each report names only the files since the one before it.
    known = _FILES.decode(before.files) if before is not None else []
    # A report that was repeated in another one's place names some of them again.
    files = list(dict.fromkeys([*known, *report.files]))[:_MOST_FILES]
    values = {
        "number": report.number,
        "state": report.state.value,
        "cause": report.cause.value if report.cause is not None else "",
        "why": safe_text(report.why, 2000),
        "changed_us": time_us,
        "frames_done": msgspec.json.encode(report.frames_done).decode(),
        "block_s": report.block_s,
        "files": msgspec.json.encode(files).decode(),
    }
    if before is not None:
        await connection.execute(
            update(observations)
            .where(observations.c.site == site, observations.c.observation == report.id)
            .values(**values)
        )
        return
    await connection.execute(
        insert(observations).values(
            site=site,
            observation=report.id,
            # 0: of no request that is known here.
            request_id=asked.id if asked is not None else 0,
            proposal=asked.proposal if asked is not None else "",
            user_id=asked.user_id if asked is not None else 0,
            began_us=time_us,
            **values,
        )
    )


def _row_to_observation(row: Row[tuple[object, ...]]) -> KeptObservation:
    return KeptObservation(
        row.observation,
        row.request_id,
        ObservationState(row.state),
        row.cause,
        row.why,
        row.began_us,
        row.changed_us,
        _FRAMES.decode(row.frames_done),
        row.block_s,
        _FILES.decode(row.files),
    )


_FRAMES = msgspec.json.Decoder(list[int])
_FILES = msgspec.json.Decoder(list[str])
