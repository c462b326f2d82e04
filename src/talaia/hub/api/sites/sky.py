"""Names of the sky, for those who want to point a telescope at them."""

from __future__ import annotations

import asyncio
import math
from typing import Annotated

from fastapi import APIRouter, Query

from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.schemas.observatory_schemas import SkyList, SkyObject
from talaia.hub.api.sites import sky_names

__all__ = ["SkyPages"]


class SkyPages:
    """The route of names; it knows nothing but what a catalogue says."""

    def make_router(self) -> APIRouter:
        """Give the route."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/sites/{site}/sky")(self.find)
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
