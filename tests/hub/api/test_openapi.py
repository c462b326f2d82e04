"""The description of the HTTP API says of every route what it needs and all it may answer."""

import pytest

from talaia.hub.policy import BY_SCRIPT, ROUTES, AccessNeed

from ..kept_description import kept_description


@pytest.fixture
def said(hub_parts):
    return kept_description(hub_parts.app)


def operations(said):
    return {
        (method.upper(), path): operation
        for path, methods in said["paths"].items()
        for method, operation in methods.items()
    }


def test_every_route_but_the_pages_is_described_with_the_need_of_the_policy(said) -> None:
    found = {route: each["x-talaia-need"] for route, each in operations(said).items()}
    assert found == {
        route: need.name.lower() for route, need in ROUTES.items() if ":path}" not in route[1]
    }


def test_token_is_named_where_it_is_taken_and_nowhere_else(said) -> None:
    for route, each in operations(said).items():
        taken = {scheme for way in each["security"] for scheme in way}
        need = ROUTES[route]
        if need is AccessNeed.OPEN:
            assert not taken, route
        elif need is AccessNeed.CLIENT:
            assert taken == {"token"}, route
        else:
            assert taken == ({"session", "token"} if need in BY_SCRIPT else {"session"}), route


def test_every_refusal_has_the_one_form(said) -> None:
    for route, each in operations(said).items():
        refusals = {int(status): answer for status, answer in each["responses"].items()}
        if ROUTES[route] is not AccessNeed.OPEN:
            assert {401, 403, 429, 503} <= set(refusals), route
        for status, answer in refusals.items():
            if status >= 400:
                (kind,) = answer["content"]
                assert kind == "application/problem+json", (route, status)


async def test_description_is_for_admins_only(hub) -> None:
    assert (await (await hub.client()).get("/api/openapi.json")).status_code == 401
    assert (await (await hub.client("operator")).get("/api/openapi.json")).status_code == 403
    answer = await (await hub.client("admin")).get("/api/openapi.json")
    assert answer.json()["openapi"].startswith("3.1")
    for path in ("/openapi.json", "/docs", "/redoc"):
        assert "paths" not in (await (await hub.client()).get(path)).text
