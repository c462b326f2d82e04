"""A guarded route serves nobody whom its guards do not let in, and reads nothing of theirs."""

import httpx
import pytest
from fastapi import APIRouter, FastAPI
from pydantic import BaseModel

from talaia.hub.api.guarded_routes import GuardedRoute, add_guarded, set_guards
from talaia.hub.api.problems import ApiProblem, answer_problems


class Order(BaseModel):
    """What is asked for."""

    count: int


def served(*guards) -> httpx.AsyncClient:
    app = FastAPI()
    answer_problems(app)
    if guards:
        set_guards(app, *guards)
    router = APIRouter(route_class=GuardedRoute)

    async def order(order: Order) -> int:
        return order.count

    router.post("/order")(order)
    add_guarded(app, router)
    transport = httpx.ASGITransport(app, raise_app_exceptions=False)
    return httpx.AsyncClient(transport=transport, base_url="http://hub")


async def test_guards_are_asked_in_their_order_before_a_body_is_read() -> None:
    asked = []

    async def first(request) -> None:
        asked.append(("first", request.scope["route"].path))

    async def second(_request) -> None:
        asked.append("second")
        raise ApiProblem(403, "forbidden", "not you")

    async with served(first, second) as client:
        answer = await client.post("/order", content=b"no JSON")
    assert (answer.status_code, answer.json()["message"]) == (403, "not you")
    assert asked == [("first", "/order"), "second"]


async def test_whoever_the_guards_let_in_is_served() -> None:
    async def pass_by(_request) -> None: ...

    async with served(pass_by) as client:
        assert (await client.post("/order", json={"count": 3})).json() == 3
        assert (await client.post("/order", json={})).status_code == 422


async def test_without_guards_nobody_is_served() -> None:
    async with served() as client:
        assert (await client.post("/order", json={"count": 3})).status_code == 500


def test_route_that_would_ask_no_guard_is_not_served() -> None:
    router = APIRouter()
    router.get("/open")(lambda: "secret")
    with pytest.raises(TypeError, match="/open"):
        add_guarded(FastAPI(), router)
