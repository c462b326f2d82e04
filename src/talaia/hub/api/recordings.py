"""Recordings of raw topics: begun and ended, listed, downloaded, deleted."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request
from starlette.responses import FileResponse, Response

from talaia.hub.api.access import address_of, live_of, who_of
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.recording_shapes import (
    RecordAskShape,
    RecorderShape,
    RecordingListShape,
    RecordingShape,
)
from talaia.hub.auth.permissions import Right
from talaia.hub.store.recordings import RecordingState
from talaia.wire.frames import RecordAsk

if TYPE_CHECKING:
    from talaia.hub.live.recordings import Recordings
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.recordings import Recorded

__all__ = ["RecordingPages"]


class RecordingPages:
    """The routes of recordings."""

    def __init__(self, recordings: Recordings, audit: Audit) -> None:
        """Answer from ``recordings``."""
        self._recordings = recordings
        self._audit = audit

    def router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter()
        at = "/api/sites/{site}/recordings"
        router.get(at)(self.overview)
        router.post(at, status_code=202)(self.record)
        router.get(at + "/{recording}/file", response_class=FileResponse)(self.file)
        router.delete(at + "/{recording}", status_code=204)(self.remove)
        return router

    async def overview(self, site: str, request: Request) -> RecordingListShape:
        """List what was recorded, and tell whether anything is being recorded now."""
        live, grants = live_of(request), who_of(request).grants
        found = await self._recordings.of(site)
        plan, now = live.description.recording, live.recorder
        return RecordingListShape(
            zone=live.description.zone,
            recorder=RecorderShape(
                described=plan is not None,
                online=live.online,
                on=live.online and now is not None and now.on,
                id=now.id if now is not None else "",
                why=now.why if now is not None else "",
                who=now.who if now is not None else "",
                since_us=now.since_us if now is not None else 0,
                problem=now.problem if now is not None else "",
                topics=list(live.description.recorded()),
                before_s=plan.before if plan is not None else 0.0,
                may_record=grants.may(Right.USE, site),
                may_delete=grants.may(Right.ADMIN, site),
            ),
            recordings=[_shape(each) for each in found],
        )

    async def record(self, asked: RecordAskShape, request: Request) -> None:
        """Let the gateway begin or end a recording. An event tells how it went."""
        live, name = live_of(request), who_of(request).name
        if live.description.recording is None:
            raise ApiProblem(409, "undescribed", "the site description says nothing of recording")
        if live.link is None:
            raise ApiProblem(409, "offline", "the gateway is not connected now")
        live.link.send(RecordAsk(on=asked.on, who=name, why=asked.why))
        kind = "recording asked" if asked.on else "recording end asked"
        self._note(request, kind, live.name, asked.why)

    async def file(self, site: str, recording: str, request: Request) -> Response:
        """Download a recording as MCAP; ranges may be asked for."""
        found = await self._found(site, recording)
        path = self._recordings.path(found)
        there = await asyncio.to_thread(path.is_file)
        if found.state is not RecordingState.COMPLETE or not there:
            raise ApiProblem(409, "incomplete", "this recording is not here as a whole")
        if "range" not in request.headers:
            self._note(request, "recording downloaded", site, found.id)
        return FileResponse(
            path, media_type="application/octet-stream", filename=f"{site}-{found.id}.mcap"
        )

    async def remove(self, site: str, recording: str, request: Request) -> None:
        """Delete a recording for good."""
        found = await self._found(site, recording)
        await self._recordings.remove(found)
        self._note(request, "recording deleted", site, found.id)

    async def _found(self, site: str, recording: str) -> Recorded:
        found = await self._recordings.find(site, recording)
        if found is None:
            raise ApiProblem(404, "unknown", "there is no such recording")
        return found

    def _note(self, request: Request, kind: str, site: str, message: str) -> None:
        name, address = who_of(request).name, address_of(request)
        self._audit.note(kind, who=name, address=address, site=site, message=message)


def _shape(recorded: Recorded) -> RecordingShape:
    told = recorded._asdict()
    return RecordingShape(
        **{key: told[key] for key in RecordingShape.model_fields if key not in ("state", "topics")},
        state=recorded.state.value,
        topics=list(recorded.topics),
    )
