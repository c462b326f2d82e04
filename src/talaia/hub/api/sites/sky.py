"""Names and pieces of the sky, for those who want to point a telescope at them."""

from __future__ import annotations

import asyncio
import math
from typing import Annotated

from fastapi import APIRouter, Query

from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.schemas.observatory_schemas import (
    SkyFieldShape,
    SkyList,
    SkyObject,
    SkyOutline,
    SkyStar,
)
from talaia.hub.api.sites import sky_field, sky_names

__all__ = ["SkyPages"]


class SkyPages:
    """The routes of the sky; they know nothing but what catalogues say."""

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/sites/{site}/sky")(self.find)
        router.get("/api/sites/{site}/sky/field")(self.field)
        return router

    async def find(
        self, site: str, name: Annotated[str, Query(min_length=1, max_length=60)]
    ) -> SkyList:
        """Find what goes by a name: NGC, IC, Messier, or what people call it."""
        # Off the loop: it reads a file.
        found = await asyncio.to_thread(sky_names.look_up, name)
        return SkyList(
            available=sky_names.is_there(),
            objects=[
                SkyObject(
                    name=sky_object.name,
                    also=list(sky_object.also),
                    kind=sky_object.kind,
                    constellation=sky_object.constellation,
                    ra_deg=sky_object.ra_deg,
                    dec_deg=sky_object.dec_deg,
                    magnitude=None if math.isnan(sky_object.magnitude) else sky_object.magnitude,
                )
                for sky_object in found
            ],
        )

    async def field(
        self,
        site: str,
        ra: Annotated[float, Query(ge=0, lt=360)],
        dec: Annotated[float, Query(ge=-90, le=90)],
        radius: Annotated[float, Query(gt=0, le=sky_field.WIDEST)],
    ) -> SkyFieldShape:
        """Give the stars and objects within a radius of a place (°, J2000), for framing."""
        # Off the loop: it reads files.
        stars, objects = await asyncio.to_thread(sky_field.look_around, ra, dec, radius)
        return SkyFieldShape(
            available=sky_names.is_there(),
            stars=[
                SkyStar(ra_deg=star.ra_deg, dec_deg=star.dec_deg, magnitude=star.magnitude)
                for star in stars
            ],
            objects=[
                SkyOutline(
                    name=found.name,
                    also=list(found.also),
                    kind=found.kind,
                    ra_deg=found.ra_deg,
                    dec_deg=found.dec_deg,
                    major=found.major,
                    minor=found.minor,
                    angle=found.angle,
                )
                for found in objects
            ],
        )
