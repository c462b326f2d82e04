"""What gives rights away asks for the password, and the factor, anew."""

from __future__ import annotations

from contextlib import asynccontextmanager

import pyotp
import pytest

from talaia.clock import SECOND, SystemClock
from talaia.hub.auth.fresh_confirmations import FreshConfirmations
from talaia.hub.policy import CONFIRMED, ROUTES

from ...conftest import PASSWORD, RunningHub

HOUR_US = 3_600_000_000
PERSON = {"name": "ada", "password": "three unrelated words", "role": "guest"}
ROLE = {"name": "night", "permissions": [{"right": "view", "site": "agv", "device": "*"}]}


def token_asked() -> dict:
    ends_us = SystemClock().wall_ns() // 1000 + HOUR_US
    permissions = [{"right": "view", "site": "agv", "device": "base"}]
    return {"name": "script", "ends_us": ends_us, "permissions": permissions}


@asynccontextmanager
async def restarted(settings, history, name: str, prepare=None):
    """Give who signed in before a restart: their session goes on, and nothing is confirmed."""
    async with RunningHub(settings, history) as first:
        await first.populate()
        client = await first.client(name)
        told = None if prepare is None else await prepare(client)
        cookies = client.cookies
    async with RunningHub(settings, history) as hub:
        client = await hub.client()
        client.cookies = cookies
        yield client, told


async def code_of(answer) -> tuple[int, str]:
    return answer.status_code, answer.json()["code"] if answer.status_code >= 400 else ""


async def test_session_that_is_not_fresh_gives_no_rights_away_until_the_password_comes(
    settings, history
) -> None:
    async with restarted(settings, history, "admin") as (admin, _):
        await refuses_until_confirmed(admin)


async def refuses_until_confirmed(admin) -> None:
    people = {
        each["name"]: each["id"] for each in (await admin.get("/api/people")).json()["people"]
    }
    roles = {each["name"]: each["id"] for each in (await admin.get("/api/roles")).json()["roles"]}
    asked = (
        ("POST", "/api/me/tokens", token_asked()),
        ("POST", "/api/people", PERSON),
        ("PATCH", f"/api/people/{people['guest']}", {"role": "admin"}),
        ("PATCH", f"/api/people/{people['guest']}", {"password": "three unrelated words"}),
        ("DELETE", f"/api/people/{people['guest']}/factor", None),
        ("POST", "/api/roles", ROLE),
        ("PUT", f"/api/roles/{roles['guest']}", {**ROLE, "name": "guest"}),
    )
    for method, path, body in asked:
        answer = await admin.request(method, path, json=body)
        assert await code_of(answer) == (403, "confirm"), (method, path)
    wrong = await admin.post("/api/me/confirm", json={"password": "not it at all"})
    assert await code_of(wrong) == (403, "wrong")
    assert await code_of(await admin.post("/api/people", json=PERSON)) == (403, "confirm")
    assert (await admin.post("/api/me/confirm", json={"password": PASSWORD})).status_code == 204
    assert (await admin.post("/api/people", json=PERSON)).status_code == 200
    assert (await admin.post("/api/me/tokens", json=token_asked())).status_code == 200
    rows = (await admin.get("/api/audit", params={"limit": 100})).json()["rows"]
    kinds = [row["kind"] for row in rows if row["who"] == "admin"]
    assert {"confirmation refused", "confirmed"} <= set(kinds)


async def codes_of_factor(client) -> list[str]:
    """Set a second factor; give two codes, of which the first is used."""
    offer = (await client.post("/api/me/factor", json={"password": PASSWORD})).json()
    totp, now_s = pyotp.TOTP(offer["secret"]), SystemClock().wall_ns() // SECOND
    codes = [totp.at(now_s - 30), totp.at(now_s)]
    answer = await client.post("/api/me/factor/confirm", json={"code": codes[0]})
    assert answer.status_code == 200
    return codes


async def test_who_has_a_factor_confirms_with_it_too_and_no_password_is_changed_without(
    settings, history
) -> None:
    async with restarted(settings, history, "operator", codes_of_factor) as (client, codes):
        changed = {"old": PASSWORD, "new": "quite another password"}
        refused = await client.post("/api/me/password", json=changed)
        assert await code_of(refused) == (403, "confirm")
        without = await client.post("/api/me/confirm", json={"password": PASSWORD})
        assert await code_of(without) == (403, "factor")
        given = {"password": PASSWORD, "code": codes[1]}
        assert (await client.post("/api/me/confirm", json=given)).status_code == 204
        assert (await client.post("/api/me/password", json=changed)).status_code == 204


async def test_token_does_none_of_it_and_cannot_confirm(hub) -> None:
    operator = await hub.client("operator")
    made = (await operator.post("/api/me/tokens", json=token_asked())).json()
    script = await hub.client()
    script.headers["Authorization"] = f"Bearer {made['token']}"
    for path, body in (
        ("/api/me/confirm", {"password": PASSWORD}),
        ("/api/me/tokens", token_asked()),
        ("/api/people", PERSON),
        ("/api/roles", ROLE),
    ):
        assert await code_of(await script.post(path, json=body)) == (403, "forbidden"), path


@pytest.mark.pure
def test_confirmation_counts_for_its_session_and_its_time() -> None:
    fresh = FreshConfirmations(300 * SECOND)
    fresh.confirm("one", 0)
    assert fresh.is_fresh("one", 300 * SECOND)
    assert not fresh.is_fresh("other", 0)
    assert not fresh.is_fresh("one", 301 * SECOND)
    # One that has ended does not come back with a clock that stands still.
    assert not fresh.is_fresh("one", 300 * SECOND)


@pytest.mark.pure
def test_each_route_that_must_be_confirmed_is_one() -> None:
    assert set(ROUTES) >= CONFIRMED
