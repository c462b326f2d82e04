"""In which units you see values: your own choice, before the site's."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.api.access import who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.account_schemas import UnitChoice, UnitChoiceAsk, UnitChoiceList
from talaia.hub.auth.permissions import sees_signal
from talaia.model.units.conversion import shown_units, units_like
from talaia.model.units.unit import unit_of

if TYPE_CHECKING:
    from talaia.hub.auth.permissions import Grants
    from talaia.hub.ports import DescribedSites
    from talaia.hub.store.accounts.shown_units import ShownUnits

__all__ = ["UnitChoicePages"]

# What the pages themselves write beside descriptions: positions, and how fast one drives.
_OWN_UNITS = ("m", "m/s")


class UnitChoicePages:
    """The routes of one's units."""

    def __init__(self, sites: DescribedSites, shown: ShownUnits) -> None:
        """Keep choices in ``shown``; ``sites`` tell what there is to choose."""
        self._sites = sites
        self._shown = shown

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/me/units")(self.choices)
        router.put("/api/me/units", status_code=204)(self.choose)
        return router

    async def choices(self, request: Request) -> UnitChoiceList:
        """List the units of the values that you may see, and what each can be shown in."""
        who = who_of(request)
        chosen = await self._shown.choice_of(who)
        places = self._units_seen(who.grants)
        # One that was chosen at a site that is gone now can be taken back.
        for unit in (*_OWN_UNITS, *chosen):
            places.setdefault(unit, [])
        return await asyncio.to_thread(_list_choices, places, chosen)

    async def choose(self, asked: UnitChoiceAsk, request: Request) -> None:
        """Say in which units you want to see values, from now on; nothing stored is changed."""
        known = await asyncio.to_thread(shown_units, asked.shown)
        for stored, shown in asked.shown.items():
            # As stored, whatever the site prefers.
            if stored != shown and stored not in known:
                raise ApiProblem(422, "invalid", f"{stored} cannot be shown in {shown}")
        await self._shown.choose(who_of(request).user, asked.shown)

    def _units_seen(self, grants: Grants) -> dict[str, list[str]]:
        """Give the units of the signals that somebody may see, with the sites that have them."""
        found: dict[str, list[str]] = {}
        for live in self._sites:
            site = live.description
            units = {
                signal.unit
                for device_id, device in site.devices.items()
                for signal_id, signal in device.signals.items()
                if signal.unit and sees_signal(grants, site, device_id, signal_id)
            }
            for unit in sorted(units):
                found.setdefault(unit, []).append(site.name)
        return found


def _list_choices(places: dict[str, list[str]], chosen: dict[str, str]) -> UnitChoiceList:
    """List what there is to choose; in a thread, since a rare unit may take a library's import."""
    return UnitChoiceList(
        units=[
            UnitChoice(
                unit=unit,
                name=unit_of(unit).name,
                sites=sites,
                shown=chosen.get(unit, ""),
                choices=choices,
            )
            for unit, sites in places.items()
            if (choices := units_like(unit))
        ]
    )
