"""What admins decide at the main hub, the others go by as well."""

from __future__ import annotations

from functools import partial

import httpx
import pytest
from patience import until_answered
from shared_trust import usual_trust

from talaia.wire.browser import SessionEnded

from ..clients.tokens import token_of
from .two_shards import AGV


@pytest.fixture
async def page(shards):
    """A page of the hub of ``east``, of somebody who signed in at the main one."""
    await shards.gateway(AGV)
    cookie = await shards.main.cookie("operator")
    headers = {"Cookie": cookie, "Origin": shards.east.origin}
    return shards.east.peer(await shards.east.dial("/ws", headers))


async def test_who_signs_out_is_out_at_every_hub(shards, page) -> None:
    cookie = await shards.main.cookie("operator")
    headers = {"Cookie": cookie, "Origin": shards.main.origin}
    async with httpx.AsyncClient(base_url=shards.main.origin, verify=usual_trust()) as client:
        assert (await client.post("/api/logout", headers=headers)).is_success
    await page.hear(SessionEnded)
    assert await page.closed() == 4401
    async with httpx.AsyncClient(base_url=shards.east.origin, verify=usual_trust()) as client:
        answer = await client.get("/api/sites", headers={"Cookie": cookie})
    assert answer.status_code == 401


async def test_whose_role_changes_has_other_rights_at_every_hub(shards, page) -> None:
    admin = await shards.main.client("admin")
    people = (await admin.get("/api/people")).json()["people"]
    person = next(one["id"] for one in people if one["name"] == "operator")
    answer = await admin.patch(f"/api/people/{person}", json={"role": "guest"})
    assert answer.is_success, answer.text
    assert await page.closed()


async def test_a_gateway_whose_key_is_revoked_is_out_wherever_it_is(shards) -> None:
    gateway = await shards.gateway(AGV)
    admin = await shards.east.client("admin")
    (listed,) = [
        one
        for one in (await admin.get("/api/gateways")).json()["gateways"]
        if not one["revoked_us"]
    ]
    admin = await shards.main.client("admin")
    assert (await admin.post(f"/api/gateways/{listed['id']}/revoke")).status_code == 204
    await gateway.closed()


async def test_a_protocol_that_is_opened_and_shut_is_so_at_every_hub(shards) -> None:
    token = await token_of(shards.main, "operator")
    admin = await shards.main.client("admin")

    async def answers(code: str) -> bool:
        async with httpx.AsyncClient(base_url=shards.east.origin, verify=usual_trust()) as client:
            answer = await client.get("/metrics", headers={"Authorization": f"Bearer {token}"})
        return answer.json()["code"] == code

    # An operator has no right to metrics, and is told so once they are open.
    for is_open, code in ((True, "forbidden"), (False, "shut")):
        asked = {"open": is_open, "origins": []}
        put = await admin.put("/api/client-protocols/metrics", json=asked)
        assert put.status_code == 204, put.text
        await until_answered(partial(answers, code))
