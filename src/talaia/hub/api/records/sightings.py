"""What cameras have seen: found by time, camera and class, with a picture of each."""

from __future__ import annotations

import datetime as dt
from typing import TYPE_CHECKING, Annotated
from zoneinfo import ZoneInfo

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response

from talaia.hub.api.access import live_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.records.query_params import STILL, Time, Word
from talaia.hub.api.schemas.sighting_schemas import (
    LabelShape,
    ReviewDay,
    ReviewDays,
    SeenAsk,
    SeenMarks,
    SeenShape,
    SightingLabels,
    SightingList,
    StoryShape,
)
from talaia.hub.auth.permissions import Right, sees_stream
from talaia.hub.store.sites.sightings import SightingsAsked

if TYPE_CHECKING:
    from talaia.hub.store.sites.sighting_reviews import SightingReviews
    from talaia.hub.store.sites.sightings import Kept, SightingStore

__all__ = ["SightingPages", "seen_shape"]


class SightingPages:
    """The routes of sightings."""

    def __init__(self, store: SightingStore, reviews: SightingReviews) -> None:
        """Answer from what is kept, with each person's marks."""
        self._store = store
        self._reviews = reviews

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/sightings"
        router.get(at)(self.find)
        router.get(at + "/labels")(self.labels)
        router.get(at + "/days")(self.days)
        router.post(at + "/seen")(self.mark)
        router.get(at + "/{sighting}/picture", response_class=Response)(self.picture)
        return router

    async def find(
        self,
        *,
        request: Request,
        site: str,
        from_us: Time = 0,
        to_us: Time = 2**53,
        camera: Word = "",
        label: Word = "",
        open: bool | None = None,  # noqa: A002 - a part of the address
        before: Time | None = None,
        zone: Word = "",
        unseen: bool = False,
        limit: Annotated[int, Query(ge=1, le=500)] = 100,
    ) -> SightingList:
        """List what was in sight from one time to another, the last to begin first.

        ``open`` asks for what is in sight now, or is not. ``before`` is the id of the last one of
        a page, for the next page. ``zone`` is what a zone or a line is called; ``unseen`` leaves
        out what the person has looked at.
        """
        user, cameras = who_of(request).user, await self._open_cameras(request, site, camera)
        asked = SightingsAsked(
            from_us=from_us,
            to_us=to_us,
            cameras=cameras,
            label=label,
            open=open,
            before=before,
            zone=zone,
            unseen_by=user if unseen else None,
        )
        found, more = await self._store.find_sightings(site, asked, limit)
        # A database may compare names without regard to case; a right does not.
        mine = [sighting for sighting in found if sighting.sighted.camera in cameras]
        marked = await self._reviews.find_seen(user, [sighting.id for sighting in mine])
        shapes = [seen_shape(sighting, seen=sighting.id in marked) for sighting in mine]
        return SightingList(sightings=shapes, more=more)

    async def labels(self, request: Request, site: str) -> SightingLabels:
        """List what was seen by which camera, of all that is kept."""
        return SightingLabels(
            labels=[
                LabelShape(camera=camera, label=label)
                for camera, label in await self._store.seen_labels(site)
                if _may_see(request, camera)
            ]
        )

    async def days(
        self, request: Request, site: str, camera: Word = "", label: Word = ""
    ) -> ReviewDays:
        """Count what each camera saw on each day, and how much of it is still to be looked at."""
        cameras = await self._open_cameras(request, site, camera)
        user, zone = who_of(request).user, ZoneInfo(live_of(request).description.zone)
        rows = await self._reviews.list_rows(site, user, cameras, label)
        counts: dict[tuple[str, str], list[int]] = {}
        for row in rows:
            day = dt.datetime.fromtimestamp(row.began_us / 1e6, zone).date().isoformat()
            count = counts.setdefault((day, row.camera), [0, 0])
            count[0] += 1
            count[1] += not row.seen
        # Twice: the second sorting keeps the order of the first one within a day.
        newest = sorted(sorted(counts), key=lambda key: key[0], reverse=True)
        return ReviewDays(
            days=[
                ReviewDay(day=day, camera=at, count=counts[day, at][0], unseen=counts[day, at][1])
                for day, at in newest
            ]
        )

    async def mark(self, request: Request, site: str, asked: SeenAsk) -> SeenMarks:
        """Mark sightings as looked at, or as not; the marks are the person's own."""
        numbers = {int(number) for number in asked.ids}
        found = await self._reviews.find_cameras(site, numbers)
        mine = sorted(number for number, at in found.items() if _may_see(request, at))
        await self._reviews.mark_seen(who_of(request).user, mine, seen=asked.seen)
        return SeenMarks(ids=[str(number) for number in mine])

    async def _open_cameras(self, request: Request, site: str, camera: str) -> set[str]:
        """Give the cameras that the person may see, or the one that is asked for."""
        # Cameras of former descriptions, too: from what was kept, not from what is described.
        seen = await self._store.seen_labels(site)
        return {
            address
            for address, _ in seen
            if (not camera or address == camera) and _may_see(request, address)
        }

    async def picture(self, request: Request, site: str, sighting: str) -> Response:
        """Give the picture of a moment of a sighting (JPEG)."""
        found = await self._store.sighting_picture(site, number_of(sighting, "sighting"))
        if found is None or not found[1] or not _may_see(request, found[0]):
            raise ApiProblem(404, "unknown", "there is no such picture")
        return Response(found[1], media_type="image/jpeg", headers=STILL)


def seen_shape(kept: Kept, *, seen: bool = False) -> SeenShape:
    """Say it as pages read it; ``seen`` is whether the person has looked at it."""
    sighted = kept.sighted
    return SeenShape(
        id=str(kept.id),
        camera=sighted.camera,
        label=sighted.label,
        many=sighted.many,
        confidence=sighted.confidence,
        began_us=sighted.began_us,
        ended_us=sighted.ended_us or None,
        picture=kept.pictured,
        seen=seen,
        story=StoryShape.model_validate_json(sighted.story) if sighted.story else None,
    )


def _may_see(request: Request, camera: str) -> bool:
    """Tell whether a camera's pictures are open to the person.

    One that the description no longer has is open to those who have a right on its device.
    """
    live, grants = live_of(request), who_of(request).grants
    device, _, stream = camera.partition("/")
    return sees_stream(grants, live.description, device, stream) or grants.has_right(
        Right.VIEW, live.name, device
    )
