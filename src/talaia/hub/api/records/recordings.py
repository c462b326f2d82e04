"""Recordings of raw topics and films of cameras: begun and ended, listed, shown, deleted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
from fastapi import APIRouter, Request
from starlette.responses import FileResponse, Response

from talaia.hub.api.access import address_of, live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.records.query_params import STILL, Time
from talaia.hub.api.records.stored_files import send_stored_file
from talaia.hub.api.schemas.recording_schemas import (
    FilmListShape,
    FilmShape,
    RecordAskShape,
    RecorderShape,
    RecordingListShape,
    RecordingShape,
    UnfilmedShape,
)
from talaia.hub.auth.permissions import Right, sees_stream
from talaia.hub.live.files.recording_files import file_key
from talaia.hub.live.recorded.errors import RecordingUnreadable
from talaia.hub.store.sites.recordings import RecordingState
from talaia.model.connection import topic_of
from talaia.wire.frames import RecordingRequest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.live.files.recordings import Recordings
    from talaia.hub.live.recorded.film_pictures import FilmPictures
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.recordings import Recorded

__all__ = ["RecordingPages"]

_MOST_FILMS = 500  # in one answer; ``more`` says that there are others
# A file may have been made by anyone who has a gateway's key: it must not act in a page.
_PLAYED = {"Content-Security-Policy": "sandbox; default-src 'none'; media-src 'self'"}
_INCOMPLETE = "this recording is not here as a whole"
_UNDESCRIBED = "the site description says nothing of recording"
_OFFLINE = "the gateway is not connected now"
_UNABLE = "this gateway cannot film cameras; install talaia[camera] there, or a newer version"


class RecordingPages:
    """The routes of recordings."""

    def __init__(self, recordings: Recordings, pictures: FilmPictures, audit: Audit) -> None:
        """Answer from ``recordings``, and of their films from ``pictures``."""
        self._recordings = recordings
        self._pictures = pictures
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/recordings"
        router.get(at)(self.overview)
        router.post(at, status_code=202)(self.record)
        router.get(at + "/{recording}/file", response_class=FileResponse)(self.file)
        router.delete(at + "/{recording}", status_code=204)(self.remove)
        at = "/api/sites/{site}/films"
        router.get(at)(self.films)
        router.get(at + "/{recording}/file", response_class=FileResponse)(self.film)
        router.get(
            at + "/{recording}/picture",
            response_class=Response,
            responses={200: {"content": {"application/msgpack": {}}}},
        )(self.picture)
        return router

    async def overview(self, site: str, request: Request) -> RecordingListShape:
        """List what was recorded, and tell whether anything is being recorded now."""
        live, grants = live_of(request), who_of(request).grants
        found = await self._recordings.recordings_of(site)
        # ``retained`` outlives the link, so what it says counts only while the gateway is online.
        plan, now = live.description.recording, live.retained.recorder
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
                topics=list(live.description.recorded_topics()),
                cameras=list(live.description.filmed_cameras()),
                filming=list(now.films) if live.online and now is not None else [],
                can_film=now is not None and now.can_film,
                before_s=plan.before if plan is not None else 0.0,
                may_record=grants.has_right(Right.USE, site),
                may_delete=grants.has_right(Right.ADMIN, site),
            ),
            recordings=[_recording_schema(recording) for recording in found],
        )

    async def record(self, asked: RecordAskShape, request: Request) -> None:
        """Let the gateway begin or end a recording. An event tells how it went."""
        live, name = live_of(request), who_of(request).name
        if live.description.recording is None:
            raise ApiProblem(409, "undescribed", _UNDESCRIBED)
        # A request is not kept for later: a recording that begins hours after it is no use.
        if live.link is None:
            raise ApiProblem(409, "offline", _OFFLINE)
        if asked.stream and not _is_camera(live, asked.stream):
            raise ApiProblem(404, "unknown", "there is no such camera")
        if asked.stream and (live.retained.recorder is None or not live.retained.recorder.can_film):
            raise ApiProblem(409, "unable", _UNABLE)
        if not asked.stream and not (
            live.description.recorded_topics() or live.description.filmed_cameras()
        ):
            raise ApiProblem(409, "undescribed", "the site description names nothing to record")
        # Queued and forgotten here; the gateway answers by its state and an event.
        live.link.send(RecordingRequest(on=asked.on, who=name, why=asked.why, stream=asked.stream))
        kind = "recording asked" if asked.on else "recording end asked"
        about = f"film of {asked.stream}" if asked.stream else ""
        self._append_record(request, kind, live.name, ": ".join(filter(None, (about, asked.why))))

    async def file(self, site: str, recording: str, request: Request) -> Response:
        """Download a recording as MCAP, or a film as MP4; ranges may be asked for."""
        found = await self._find_recording(site, recording)
        return await self._send_file(found, request, "attachment")

    async def films(
        self, site: str, request: Request, from_us: Time = 0, to_us: Time = 2**53
    ) -> FilmListShape:
        """List films that have something of a time, of the cameras that you may see."""
        live, grants = live_of(request), who_of(request).grants
        found = await self._recordings.recordings_between(site, from_us, to_us)
        films = [recording for recording in found if _sees_recording(grants, live, recording)]
        why_not = _why_no_film(live, may=grants.has_right(Right.USE, site))
        now = live.retained.recorder
        rolling = now.films if live.online and now is not None else ()
        unfilmed = _pair_unfilmed(live, found) if grants.has_right(Right.VIEW, site) else []
        return FilmListShape(
            films=[_film_schema(film) for film in films[:_MOST_FILMS]],
            more=len(films) > _MOST_FILMS,
            unfilmed=unfilmed[:_MOST_FILMS],
            filming=[recording for recording in rolling if _sees_camera(grants, live, recording)],
            may_film=not why_not,
            why_not=why_not,
        )

    async def film(self, site: str, recording: str, request: Request) -> Response:
        """Show a film (MP4); ranges may be asked for."""
        found = await self._find_film(site, recording, request)
        return await self._send_file(found, request, "inline")

    async def picture(self, site: str, recording: str, request: Request, at_us: Time) -> Response:
        """Give the picture of a film that stands at a moment (H.264), in MessagePack.

        ``data`` has all that a decoder needs for it, in order: from the last picture that needs
        none before it up to this one, each as in an MP4 file of that ``codec`` and
        ``description`` (``avcC``). ``times_us`` says when each of them came, ``before_us`` and
        ``next_us`` when the pictures beside this one did.
        """
        found = await self._find_film(site, recording, request)
        if found.state is not RecordingState.COMPLETE:
            raise ApiProblem(409, "incomplete", _INCOMPLETE)
        try:
            picture = await self._pictures.find_picture(found, at_us)
        except FileNotFoundError as error:
            raise ApiProblem(409, "incomplete", _INCOMPLETE) from error
        except RecordingUnreadable as error:
            raise ApiProblem(409, "unreadable", "this film cannot be read by pictures") from error
        data = msgspec.msgpack.encode(picture._asdict())
        return Response(data, media_type="application/msgpack", headers=STILL)

    async def _find_film(self, site: str, recording: str, request: Request) -> Recorded:
        """Find a film of a camera that the person may see; of others they learn nothing."""
        found = await self._recordings.find_recording(site, recording)
        if found is None or not _sees_recording(who_of(request).grants, live_of(request), found):
            raise ApiProblem(404, "unknown", "there is no such film")
        return found

    async def _send_file(self, found: Recorded, request: Request, how: str) -> Response:
        camera = found.stream.replace("/", "-")
        name = f"{camera}-{found.id}.mp4" if camera else f"{found.id}.mcap"
        if found.state is not RecordingState.COMPLETE:
            raise ApiProblem(409, "incomplete", _INCOMPLETE)
        try:
            answer = await send_stored_file(
                self._recordings.store,
                file_key(found),
                request,
                name=f"{found.site}-{name}",
                kind="video/mp4" if camera else "application/octet-stream",
                headers=_PLAYED,
                disposition=how,
            )
        except FileNotFoundError as error:
            raise ApiProblem(409, "incomplete", _INCOMPLETE) from error
        # A player asks for a film in many parts: only whole downloads are written down.
        if "range" not in request.headers:
            self._append_record(request, "recording downloaded", found.site, found.id)
        return answer

    async def remove(self, site: str, recording: str, request: Request) -> None:
        """Delete a recording for good."""
        found = await self._find_recording(site, recording)
        await self._recordings.remove_recording(found)
        self._append_record(request, "recording deleted", site, found.id)

    async def _find_recording(self, site: str, recording: str) -> Recorded:
        found = await self._recordings.find_recording(site, recording)
        if found is None:
            raise ApiProblem(404, "unknown", "there is no such recording")
        return found

    def _append_record(self, request: Request, kind: str, site: str, message: str) -> None:
        name, address = who_of(request).name, address_of(request)
        self._audit.append_record(kind, who=name, address=address, site=site, message=message)


def _is_camera(live: LiveSite, stream: str) -> bool:
    device, _, name = stream.partition("/")
    described = live.description.devices.get(device)
    return described is not None and name in described.streams


def _sees_recording(grants: Grants, live: LiveSite, recorded: Recorded) -> bool:
    return bool(recorded.stream) and _sees_camera(grants, live, recorded.stream)


def _sees_camera(grants: Grants, live: LiveSite, stream: str) -> bool:
    """Tell whether a person may see a camera; of one that is no more, who may see the site."""
    device, _, name = stream.partition("/")
    if grants.has_right(Right.VIEW, live.name):
        return True
    return sees_stream(grants, live.description, device, name)


def _why_no_film(live: LiveSite, *, may: bool) -> str:
    if not may:
        return "You do not have the right to record at this site."
    if live.description.recording is None:
        return _UNDESCRIBED
    if not live.online or live.link is None:
        return _OFFLINE
    return "" if live.retained.recorder is not None and live.retained.recorder.can_film else _UNABLE


def _pair_unfilmed(live: LiveSite, found: Sequence[Recorded]) -> list[UnfilmedShape]:
    """Pair recordings with the cameras that only they have, and no film of that time."""
    topics = {
        topic_of(stream.source): f"{name}/{key}"
        for name, device in live.description.devices.items()
        for key, stream in device.streams.items()
        if topic_of(stream.source)
    }
    shapes = []
    for recording in found:
        # Films themselves, and recordings that nothing can be made of yet.
        if recording.stream or recording.state is not RecordingState.COMPLETE:
            continue
        for stream in (topics[topic] for topic in recording.topics if topic in topics):
            filmed = any(
                film.stream == stream
                and film.begin_us <= recording.end_us
                and film.end_us >= recording.begin_us
                for film in found
            )
            if not filmed:
                shapes.append(
                    UnfilmedShape(
                        recording=recording.id,
                        stream=stream,
                        begin_us=recording.begin_us,
                        end_us=recording.end_us,
                    )
                )
    return shapes


def _film_schema(recorded: Recorded) -> FilmShape:
    told = recorded._asdict()
    fields = {key: told[key] for key in FilmShape.model_fields if key not in ("state", "pictures")}
    return FilmShape(**fields, state=recorded.state, pictures=recorded.messages)


def _recording_schema(recorded: Recorded) -> RecordingShape:
    told = recorded._asdict()
    return RecordingShape(
        **{key: told[key] for key in RecordingShape.model_fields if key not in ("state", "topics")},
        state=recorded.state,
        topics=list(recorded.topics),
    )
