"""The site description as the HTTP API says it, by the hub's own words for it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

from seen_side import CLASSES

from talaia.hub.api.sites.site_views import describe_site
from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.model.units.conversion import shown_units

if TYPE_CHECKING:
    from world import World

    from talaia.hub.live.sites import LiveSite


# Stored unit to shown unit, as the account page has chosen.
CHOSEN: dict[str, str] = {}


def site_json(world: World, permissions: list[dict[str, Any]]) -> dict[str, Any]:
    """Say the site as the hub does to somebody with these permissions."""
    live = SimpleNamespace(
        description=world.site,
        online=world.online,
        presence=SimpleNamespace(
            since_us=int(world.since * 1e6), last_seen_us=int(world.since * 1e6)
        ),
        edition="1",
    )
    held = frozenset(Permission(Right(p["right"]), p["site"], p["device"]) for p in permissions)
    made = describe_site(cast("LiveSite", live), Grants(held), shown_units(CHOSEN))
    site = made.model_dump(mode="json")
    # The made-up world looks at every picture.
    for stream in (one for device in site["devices"] for one in device["streams"]):
        stream["detect"] = stream["detect"] or {"classes": CLASSES, "confidence": 0.5}
    return site
