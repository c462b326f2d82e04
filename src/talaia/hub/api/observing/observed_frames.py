"""Pictures by what they were taken for: of a request, of a proposal, and as a table of ObsCore."""

from __future__ import annotations

import tarfile
from typing import TYPE_CHECKING, Literal

from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse

from talaia.hub.api.access import live_of, number_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.observing.group_lookup import access_of
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.records.archive import frame_shape, visible_cameras
from talaia.hub.api.records.query_params import STILL, Time, Word
from talaia.hub.api.schemas.archive_schemas import FrameList
from talaia.hub.archive.frame_rows import Wanted
from talaia.hub.archive.obscore import (
    ObscoreContext,
    obscore_row,
    write_csv,
    write_votable,
)
from talaia.hub.observing.frame_assignment import SLACK_US, ObservationSpan, assign_frames

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Collection

    from talaia.hub.api.observing.group_lookup import GroupLookup
    from talaia.hub.archive.frame_rows import ArchivedFrame
    from talaia.hub.archive.obscore import ObscoreValue
    from talaia.hub.archive.store import Archive
    from talaia.hub.files.ports import OpenFile
    from talaia.hub.store.observing.observations import ObservationStore
    from talaia.hub.store.observing.proposals import ProposalStore
    from talaia.hub.store.observing.request_store import RequestStore

__all__ = ["ObservedFramePages"]

_VOTABLE = "application/x-votable+xml"
_TAR = "application/x-tar"
_PIECE = 1024 * 1024
# Of one request; a night has fewer.
_MOST_FRAMES = 500


class ObservedFramePages:
    """Routes that join the archive with what gateways report on observations.

    A picture is seen by who may view its camera; which request and proposal it belongs to by who
    sees the proposal (decision 0090).
    """

    def __init__(
        self,
        *,
        archive: Archive,
        observations: ObservationStore,
        proposals: ProposalStore,
        requests: RequestStore,
        lookup: GroupLookup,
    ) -> None:
        """Answer from what is kept."""
        self._archive = archive
        self._observations = observations
        self._proposals = proposals
        self._requests = requests
        self._lookup = lookup

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/sites/{site}/requests/{number}/frames")(self.of_request)
        router.get(
            "/api/sites/{site}/proposals/{proposal}/pictures", response_class=StreamingResponse
        )(self.of_proposal)
        router.get("/api/sites/{site}/obscore", response_class=StreamingResponse)(self.obscore)
        return router

    async def of_request(self, site: str, number: str, request: Request) -> FrameList:
        """List the pictures that were taken for a request, the newest first."""
        wanted = number_of(number, "request")
        found = await self._requests.find_request(site, wanted)
        if found is None:
            raise ApiProblem(404, "unknown", "there is no such request")
        await self._lookup.open_group(found[0], request, "request")
        tries = await self._observations.observations_of(site, wanted)
        if not tries:
            return FrameList(frames=[], more=False)
        spans = await self._observations.spans_between(
            site,
            min(one.began_us for one in tries),
            max(one.changed_us for one in tries) + SLACK_US,
        )
        own = [span for span in spans if span.request == wanted]
        ends = [span.end_us for span in own if span.end_us is not None]
        goes_on = len(ends) < len(own)
        frames, more = await self._archive.find_frames(
            site,
            _night_cameras(request),
            Wanted(
                from_us=min(span.begin_us for span in own) - SLACK_US,
                to_us=2**62 if goes_on else max(ends) + SLACK_US,
            ),
            _MOST_FRAMES,
        )
        known = assign_frames(frames, spans)
        mine = [frame for frame in frames if _request_of(known, frame) == wanted]
        return FrameList(frames=[frame_shape(frame) for frame in mine], more=more)

    async def of_proposal(
        self, site: str, proposal: str, request: Request, *, from_us: Time = 0, to_us: Time = 2**53
    ) -> StreamingResponse:
        """Download all pictures of a proposal as a tar of FITS files, in a folder a night."""
        found = await self._proposals.find_proposal(site, proposal)
        if found is None or not access_of(found, request).sees:
            raise ApiProblem(404, "unknown", "there is no such proposal")
        frames = self._of_proposal(site, proposal, request, Wanted(from_us=from_us, to_us=to_us))
        name = "".join(letter for letter in proposal if letter.isalnum() or letter in "-_.")
        headers = {**STILL, "Content-Disposition": f'attachment; filename="{name}.tar"'}
        return StreamingResponse(self._tar(frames), media_type=_TAR, headers=headers)

    async def obscore(
        self,
        *,
        request: Request,
        site: str,
        format: Literal["votable", "csv"] = "votable",  # noqa: A002 - the query's name for it
        night: Word = "",
        target: Word = "",
        from_us: Time = 0,
        to_us: Time = 2**53,
    ) -> StreamingResponse:
        """Export the archive as a table of IVOA ObsCore 1.1."""
        wanted = Wanted(night=night, target=target, from_us=from_us, to_us=to_us)
        rows = [row async for row in self._rows(site, request, wanted)]
        made = write_csv(rows) if format == "csv" else write_votable(rows, site)
        kind = "text/csv; charset=utf-8" if format == "csv" else _VOTABLE
        ending = "csv" if format == "csv" else "vot"
        headers = {**STILL, "Content-Disposition": f'attachment; filename="{site}.{ending}"'}
        return StreamingResponse(made, media_type=kind, headers=headers)

    async def _rows(
        self, site: str, request: Request, wanted: Wanted
    ) -> AsyncIterator[tuple[ObscoreValue, ...]]:
        listed = await self._proposals.list_proposals(site)
        seen = {kept.id for kept in listed if access_of(kept, request).sees}
        origin = str(request.base_url).rstrip("/")
        async for frames in self._archive.each_batch(site, visible_cameras(request), wanted):
            known = await self._assign(site, request, frames)
            for frame in frames:
                span = known.get(frame.id)
                proposal = span.proposal if span is not None and span.proposal in seen else ""
                yield obscore_row(frame, ObscoreContext(origin, proposal))

    async def _of_proposal(
        self, site: str, proposal: str, request: Request, wanted: Wanted
    ) -> AsyncIterator[ArchivedFrame]:
        cameras = _night_cameras(request)
        async for frames in self._archive.each_batch(site, cameras, wanted):
            known = await self._assign(site, request, frames)
            for frame in frames:
                span = known.get(frame.id)
                if span is not None and span.proposal == proposal:
                    yield frame

    async def _assign(
        self, site: str, request: Request, frames: Collection[ArchivedFrame]
    ) -> dict[int, ObservationSpan]:
        cameras = _night_cameras(request)
        of_nights = [frame for frame in frames if frame.device in cameras]
        if not of_nights:
            return {}
        times = [frame.time_us for frame in of_nights]
        spans = await self._observations.spans_between(
            site, min(times) - SLACK_US, max(times) + SLACK_US
        )
        return assign_frames(of_nights, spans)

    async def _tar(self, frames: AsyncIterator[ArchivedFrame]) -> AsyncIterator[bytes]:
        async for frame in frames:
            try:
                file = await self._archive.files.open_file(self._archive.frame_key(frame))
            except FileNotFoundError:
                # One that somebody took away is left out, and the others still come.
                continue
            async for piece in _tar_member(file, f"{frame.night}/{frame.name}", frame.time_us):
                yield piece
        # The end of a tar: two empty blocks (POSIX.1-2017, pax).
        yield bytes(2 * tarfile.BLOCKSIZE)


async def _tar_member(file: OpenFile, name: str, time_us: int) -> AsyncIterator[bytes]:
    """Give a file as a member of a tar, piece by piece; it is closed at the end."""
    try:
        info = tarfile.TarInfo(name)
        # Of the open file: it may be measured just now, and another one take its place.
        info.size = file.size
        info.mtime = time_us // 1_000_000
        yield info.tobuf(tarfile.PAX_FORMAT)
        left = info.size
        while left:
            piece = await file.read_part(info.size - left, min(_PIECE, left))
            # Its size is promised already: what was cut off meanwhile is filled up.
            piece = piece or bytes(min(_PIECE, left))
            left -= len(piece)
            yield piece
        yield bytes(-info.size % tarfile.BLOCKSIZE)
    finally:
        await file.close()


def _night_cameras(request: Request) -> list[str]:
    """Name the cameras with which the night observes, of those that the person may see."""
    night = live_of(request).description.night
    if night is None:
        return []
    used = night.light.command.partition("/")[0]
    return [camera for camera in visible_cameras(request) if camera == used]


def _request_of(known: dict[int, ObservationSpan], frame: ArchivedFrame) -> int | None:
    span = known.get(frame.id)
    return span.request if span is not None else None
