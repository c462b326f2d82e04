"""Every route × every kind of person × own and foreign objects, held against the policy table.

By turns they come to the hub that leads, and to another one before it.
"""

from __future__ import annotations

import pytest
from fastapi import APIRouter
from fastapi.routing import iter_route_contexts

from talaia.hub.api.sites.sites import SitePages
from talaia.hub.policy import ROUTES, AccessNeed, need_of_route

from .everyone.routes import ABOUT_PEOPLE, RECIPES, meets
from .everyone.world import ACTORS, OBJECTS, SESSIONLESS, holds

UNSAFE = {"POST", "PUT", "PATCH", "DELETE"}


def routes_of(app) -> set[tuple[str, str]]:
    """List what the application really serves."""
    return {
        (method, context.path)
        for context in iter_route_contexts(app.router.routes)
        for method in (context.methods or ())
        if method != "HEAD"
    }


async def differences(world, method: str, path: str) -> list[str]:
    """Ask a route as everyone, about everything; list what is not as its line says."""
    need, recipe = need_of_route(method, path), RECIPES[method, path]
    found = []
    for about in recipe.objects:
        # The script first: it ends with its person's password.
        for actor in sorted(ACTORS, key=lambda name: name != "token"):
            client = await world.kept_client(actor)
            ask = await recipe.make(world, client, about)
            target = path
            for name, value in ask.params.items():
                target = target.replace(f"{{{name}}}", value)
            before = await world.state()
            door = next(world.doors)
            # A script names no origin.
            headers = {"Origin": door.origin} if "Origin" in client.headers else {}
            answer = await client.request(
                method, door.origin + target, params=ask.query, json=ask.json, headers=headers
            )
            may = (recipe.meets or (lambda *who: meets(need, *who)))(actor, about)
            said = f"{actor} on {about or 'the hub'}: {answer.status_code}"
            if may and method != "GET" and path.startswith(ABOUT_PEOPLE):
                # It may have ended anyone's session. Whatever else is asked ends none.
                world.forget_clients()
            if may:
                if answer.status_code not in ask.done:
                    found.append(f"{said} instead of {ask.done}: {answer.text[:200]}")
                if method == "GET" and (changed := _changed(before, await world.state())):
                    found.append(f"{said}: asking changed {changed}")
                continue
            wanted = _refusals(actor, about, need)
            if answer.status_code not in wanted:
                found.append(f"{said} instead of {wanted}")
            if changed := _changed(before, await world.state()):
                found.append(f"{said}, and yet it changed {changed}")
    return found


def _changed(before: dict[str, list], after: dict[str, list]) -> list[str]:
    return [table for table in before if before[table] != after[table]]


def _refusals(actor: str, about: str, need: AccessNeed) -> tuple[int, ...]:
    if need is AccessNeed.CLIENT:
        # A session is nobody there; the token of these tests has no right to metrics.
        return (403,) if actor == "token" else (401,)
    if actor in SESSIONLESS:
        return (401,)
    persons = {AccessNeed.OWN, AccessNeed.ADMIN, AccessNeed.APPROVE, AccessNeed.ARM}
    if actor == "token" and need in persons:
        return (403,)
    # As if there were no such thing.
    if about == "foreign" or (about in OBJECTS and about and not holds(actor, "see", about)):
        return (404,)
    return (403,)


def test_every_route_is_tried_and_no_recipe_is_left_over(hub_parts) -> None:
    assert set(RECIPES) == routes_of(hub_parts.app) == set(ROUTES)


# They change with what everyone signs in, which the next route would trip over.
OF_ITS_OWN = [
    ("POST", "/api/me/factor/confirm"),
    ("POST", "/api/me/factor/remove"),
    ("POST", "/api/me/password"),
]


@pytest.mark.asyncio(loop_scope="module")
@pytest.mark.parametrize(
    ("method", "path"), sorted(RECIPES.keys() - set(OF_ITS_OWN)), ids=lambda each: each
)
async def test_route_does_for_everyone_what_its_line_says(shared_world, method, path) -> None:
    # What is changed is compared around each request, so one world does for all of these.
    assert await differences(shared_world, method, path) == []


@pytest.mark.parametrize(("method", "path"), OF_ITS_OWN, ids=lambda each: each)
async def test_route_about_signing_in_does_for_everyone_what_its_line_says(
    world, method, path
) -> None:
    assert await differences(world, method, path) == []


async def test_route_that_lets_anyone_in_is_found(world, monkeypatch) -> None:
    monkeypatch.setattr("talaia.hub.api.access.allows", lambda *_about: True)
    found = await differences(world, "GET", "/api/sites/{site}/events")
    assert {each.partition(":")[0] for each in found} == {
        "guest on moon",
        "driver on moon",
        "neighbour on moon",
        "keeper on moon",
        "token on moon",
    }


async def test_route_that_shuts_someone_out_is_found(world, monkeypatch) -> None:
    monkeypatch.setattr(
        "talaia.hub.api.access.need_of_route",
        lambda method, path: AccessNeed.NEVER if path == "/api/me" else need_of_route(method, path),
    )
    found = await differences(world, "GET", "/api/me")
    assert any(each.startswith("guest on the hub: 403") for each in found)


async def test_route_without_a_line_is_found_and_denied_to_everyone(
    hub_that_stores, monkeypatch
) -> None:
    listed = SitePages.make_router

    def forgetful(pages: SitePages) -> APIRouter:
        router = listed(pages)
        router.get("/api/forgotten")(lambda: "secret")
        return router

    monkeypatch.setattr(SitePages, "make_router", forgetful)
    async with hub_that_stores() as hub:
        await hub.populate()
        assert routes_of(hub.hub.app) - set(ROUTES) == {("GET", "/api/forgotten")}
        answer = await (await hub.client("admin")).get("/api/forgotten")
        assert answer.status_code == 403


def test_only_the_doors_themselves_are_open() -> None:
    opened = {route for route, need in ROUTES.items() if need is AccessNeed.OPEN}
    assert {path for method, path in opened if method in UNSAFE} <= {
        "/api/heads",
        "/api/login",
        # By a passkey, or by the provider that the start of the hub names.
        "/api/login/passkey",
        "/api/login/passkey/options",
        "/api/login/oidc",
        "/api/login/oidc/finish",
        "/api/setup",
        "/api/enrol",
        "/api/displays/open",
    }
    assert {path for method, path in opened if method not in UNSAFE} <= {
        "/api/health",
        "/api/ready",
        # What the button of the sign-in page says.
        "/api/login/oidc",
        "/{path:path}",
    }


@pytest.mark.parametrize(
    "under", ["/api/people", "/api/roles", "/api/gateways", "/api/audit"], ids=lambda each: each
)
def test_administration_is_for_admins(under) -> None:
    needs = {need for (_, path), need in ROUTES.items() if path.startswith(under)}
    assert needs <= {AccessNeed.ADMIN}
