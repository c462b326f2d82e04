"""The archive's pictures: nights, search, one picture, its file and how it looks."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import FileResponse, Response

from talaia.hub.api.access import live_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.records.query_params import STILL, Time, Word
from talaia.hub.api.records.stored_files import send_stored_file
from talaia.hub.api.schemas.archive_schemas import (
    CardShape,
    FrameDetail,
    FrameList,
    FrameShape,
    HistogramShape,
    NightList,
    NightShape,
)
from talaia.hub.archive.fits_reader import PREVIEW_PX, SMALL_PX, STRETCHES, NotKept, TooMuchToRead
from talaia.hub.archive.frame_rows import Cone, MeasureState, Wanted
from talaia.hub.policy import AccessNeed, allows
from talaia.model.site import Visibility

if TYPE_CHECKING:
    from talaia.hub.archive.fits_reader import Looks
    from talaia.hub.archive.frame_rows import ArchivedFrame
    from talaia.hub.archive.store import Archive

__all__ = ["ArchivePages", "frame_shape", "visible_cameras"]

# One for both coordinates; each is held against its own bounds below.
_Degrees = Annotated[float | None, Query(ge=-90, le=360, allow_inf_nan=False)]
_LONGEST_RADIUS = 180.0


class ArchivePages:
    """The routes of the archive."""

    def __init__(self, archive: Archive) -> None:
        """Answer from what is kept."""
        self._archive = archive

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/sites/{site}/nights")(self.nights)
        router.get("/api/sites/{site}/frames")(self.find)
        router.get("/api/sites/{site}/frames/{frame}")(self.one)
        router.get("/api/sites/{site}/frames/{frame}/file", response_class=FileResponse)(self.file)
        router.get("/api/sites/{site}/frames/{frame}/preview", response_class=Response)(
            self.preview
        )
        return router

    async def nights(self, request: Request, site: str) -> NightList:
        """List the nights of which there are pictures that you may see, newest first."""
        found = await self._archive.list_nights(site, visible_cameras(request))
        return NightList(
            nights=[NightShape(night=a.night, frames=a.frames, bytes=a.bytes) for a in found]
        )

    async def find(
        self,
        *,
        request: Request,
        site: str,
        night: Word = "",
        target: Word = "",
        filter: Word = "",  # noqa: A002 - the field's word
        kind: Word = "",
        device: Word = "",
        from_us: Time = 0,
        to_us: Time = 2**53,
        ra: _Degrees = None,
        dec: _Degrees = None,
        radius: Annotated[float, Query(gt=0, le=_LONGEST_RADIUS, allow_inf_nan=False)] = 1.0,
        limit: Annotated[int, Query(ge=1, le=500)] = 100,
    ) -> FrameList:
        """Find pictures, newest first; ``ra`` and ``dec`` are J2000 degrees."""
        if (ra is None) != (dec is None):
            raise ApiProblem(422, "invalid", "give both ra and dec, in degrees, or neither")
        cone = None
        if ra is not None and dec is not None:
            if not (0 <= ra <= 360 and -90 <= dec <= 90):
                raise ApiProblem(422, "invalid", "expected ra 0 to 360 and dec -90 to 90 degrees")
            cone = Cone(ra, dec, radius)
        # The right is a part of the query, so that pages and ``more`` count only what may be seen.
        cameras = [camera for camera in visible_cameras(request) if not device or camera == device]
        wanted = Wanted(night, target, filter, kind, from_us, to_us, cone)
        found, more = await self._archive.find_frames(site, cameras, wanted, limit)
        return FrameList(frames=[frame_shape(frame) for frame in found], more=more)

    async def one(self, request: Request, site: str, frame: str) -> FrameDetail:
        """Give a picture's facts, its header, and how its values lie."""
        found = await self._find_frame(request, site, frame)
        try:
            looks = await self._archive.frame_looks(found)
        except (NotKept, TooMuchToRead) as error:
            # The row is there and the file is not, or is damaged: somebody worked on the folder.
            raise ApiProblem(410, "gone", f"the file cannot be read any more: {error}") from error
        return FrameDetail(
            frame=frame_shape(found),
            histogram=_histogram_schema(looks),
            header=[CardShape(key=a, value=b, comment=c) for a, b, c in looks.cards],
        )

    async def file(self, request: Request, site: str, frame: str) -> Response:
        """Download the FITS file."""
        found = await self._find_frame(request, site, frame)
        try:
            return await send_stored_file(
                self._archive.files,
                self._archive.frame_key(found),
                request,
                name=found.name,
                kind="application/fits",
                headers=STILL,
            )
        except FileNotFoundError as error:
            raise ApiProblem(410, "gone", "the file is not there any more") from error

    async def preview(
        self,
        *,
        request: Request,
        site: str,
        frame: str,
        stretch: Annotated[str, Query(pattern=f"^({'|'.join(STRETCHES)})$")] = "asinh",
        px: Annotated[int, Query(ge=64, le=2048)] = PREVIEW_PX,
    ) -> Response:
        """Draw the picture as PNG of at most ``px`` a side, with limits by zscale."""
        found = await self._find_frame(request, site, frame)
        try:
            # All small sizes are one, so that a list of pictures is drawn once for every screen.
            data = await self._archive.render_preview(
                found, stretch, SMALL_PX if px <= SMALL_PX else px
            )
        except (NotKept, TooMuchToRead) as error:
            raise ApiProblem(410, "gone", f"the file cannot be read any more: {error}") from error
        return Response(data, media_type="image/png", headers=STILL)

    async def _find_frame(self, request: Request, site: str, frame: str) -> ArchivedFrame:
        found = await self._archive.find_frame(site, number_of(frame, "picture"))
        # A picture of another's camera is told like one that is not there.
        if found is None or found.device not in visible_cameras(request):
            raise ApiProblem(404, "unknown", "there is no such picture")
        return found


def visible_cameras(request: Request) -> list[str]:
    """Name the devices whose pictures the person may see."""
    site, grants = live_of(request).description, who_of(request).grants
    return [
        name
        for name, device in site.devices.items()
        # A public number makes no public picture: the camera itself must be.
        if device.visibility is Visibility.PUBLIC or allows(AccessNeed.VIEW, grants, site, name)
    ]


def frame_shape(frame: ArchivedFrame) -> FrameShape:
    """Write a picture for a page."""
    measures = frame.measures
    return FrameShape(
        id=str(frame.id),
        device=frame.device,
        night=frame.night,
        name=frame.name,
        time_us=frame.time_us,
        target=frame.target,
        filter=frame.filter,
        kind=frame.kind,
        exposure_s=_format_number(frame.exposure_s),
        ra_deg=_format_number(frame.ra_deg),
        dec_deg=_format_number(frame.dec_deg),
        width=frame.width,
        height=frame.height,
        bytes=frame.bytes,
        digest=frame.digest,
        problems=list(frame.problems),
        measured=measures.state is MeasureState.MEASURED,
        solved=bool(measures.wcs),
        stars=measures.stars,
        fwhm=_format_number(measures.fwhm),
        background=_format_number(measures.background),
        zero_point=_format_number(measures.zero_point),
        note=measures.note,
    )


def _histogram_schema(looks: Looks) -> HistogramShape:
    return HistogramShape(
        minimum=_format_number(looks.minimum),
        maximum=_format_number(looks.maximum),
        median=_format_number(looks.median),
        deviation=_format_number(looks.deviation),
        low=_format_number(looks.low),
        high=_format_number(looks.high),
        counts=list(looks.counts),
    )


def _format_number(value: float) -> float | None:
    # JSON has no word for NaN.
    return value if math.isfinite(value) else None
