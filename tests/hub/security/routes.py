"""How each route is tried: about which objects, with which words, and what it answers when done."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.policy import Need

from .world import NOW, PASSWORD, SESSIONLESS, holds

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    import httpx

    from .world import World


class Ask(NamedTuple):
    """One request."""

    params: Mapping[str, str] = {}
    query: Mapping[str, object] = {}
    json: object = None
    # What the route answers to those who may.
    done: tuple[int, ...] = (200,)


class Recipe(NamedTuple):
    """How to ask a route, about each of these objects."""

    make: Callable[[World, httpx.AsyncClient, str], Awaitable[Ask]]
    objects: tuple[str, ...] = ("",)
    # Takes the place of the policy's line where the line leaves the object to the route.
    meets: Callable[[str, str], bool] | None = None


def plain(**ask: object) -> Callable[[World, httpx.AsyncClient, str], Awaitable[Ask]]:
    """Ask the same of everyone."""

    async def make(_world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
        return Ask(**ask)

    return make


def of_site(**ask: object) -> Recipe:
    """Ask about both sites."""

    async def make(_world: World, _client: httpx.AsyncClient, about: str) -> Ask:
        return Ask(params={"site": about}, **ask)

    return Recipe(make, ("agv", "moon"))


async def _history(_world: World, _client: httpx.AsyncClient, about: str) -> Ask:
    channel = {"agv": "base/open", "moon": "rover/open"}[about]
    return Ask({"site": about}, {"channel": channel, "from_us": NOW, "to_us": NOW + 1})


async def _code(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    made = await (await world.admin()).post("/api/gateways/codes", json={"site": "farm"})
    return Ask({"code": made.json()["id"]}, done=(204,))


async def _enrol(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    made = await (await world.admin()).post("/api/gateways/codes", json={"site": "farm"})
    return Ask(json={"code": made.json()["code"], "name": "a new gateway"})


async def _gateway(world: World, site: str) -> str:
    known = (await (await world.admin()).get("/api/gateways")).json()["gateways"]
    return next(each["id"] for each in known if each["site"] == site and not each["revoked_us"])


async def _revoke(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    await world.hub.hub._registry.new_key("farm")
    return Ask({"gateway": await _gateway(world, "farm")}, done=(204,))


async def _reconnect(world: World, _client: httpx.AsyncClient, _about: str) -> Ask:
    return Ask({"gateway": await _gateway(world, "agv")}, json={"device": "base"}, done=(202,))


RECIPES: Mapping[tuple[str, str], Recipe] = {
    ("GET", "/api/health"): Recipe(plain()),
    ("POST", "/api/login"): Recipe(plain(json={"name": "guest", "password": PASSWORD})),
    # There are people: the link is used up for everyone, and that is no matter of rights.
    ("POST", "/api/setup"): Recipe(
        plain(json={"token": "t", "name": "eve", "password": PASSWORD}, done=(403, 429))
    ),
    ("POST", "/api/logout"): Recipe(plain(done=(204,))),
    ("GET", "/api/me"): Recipe(plain()),
    ("GET", "/api/sites"): Recipe(plain()),
    ("GET", "/api/sites/{site}"): of_site(),
    ("GET", "/api/sites/{site}/history"): Recipe(_history, ("agv", "moon")),
    ("GET", "/api/sites/{site}/events"): of_site(),
    ("GET", "/api/gateways"): Recipe(plain()),
    ("POST", "/api/gateways/codes"): Recipe(plain(json={"site": "farm"})),
    ("DELETE", "/api/gateways/codes/{code}"): Recipe(_code),
    ("POST", "/api/gateways/{gateway}/revoke"): Recipe(_revoke),
    ("POST", "/api/gateways/{gateway}/reconnect"): Recipe(_reconnect),
    ("POST", "/api/enrol"): Recipe(_enrol),
    ("GET", "/api/audit"): Recipe(plain()),
    ("GET", "/api/audit/export"): Recipe(plain()),
    ("GET", "/api/audit/verify"): Recipe(plain()),
    # The pages themselves; 503 where they are not built.
    ("GET", "/{path:path}"): Recipe(plain(params={"path:path": "home"}, done=(200, 503))),
}


def meets(need: Need, actor: str, about: str) -> bool:
    """Tell, from the table written by hand, whether somebody meets a need about an object."""
    if need is Need.OPEN:
        return True
    if actor in SESSIONLESS or need in {Need.NEVER, Need.GATEWAY}:
        return False
    if need is Need.SESSION:
        return True
    return holds(actor, need.name.lower(), about)
