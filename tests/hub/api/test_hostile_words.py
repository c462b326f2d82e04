"""Hostile words wherever words are taken: in filters, in names, in headers, in what is logged."""

from __future__ import annotations

import base64
import json
import logging
import secrets
from urllib.parse import quote

import pytest
from sqlalchemy import select

from talaia.hub.auth.tokens import hash_token, new_token
from talaia.hub.policy import AccessNeed, need_of_route
from talaia.hub.store.tables import audit, users

from ..everyone.routes import RECIPES
from ..everyone.story import everything, listen, settle
from ..everyone.world import NOW, PASSWORD
from ..kept_description import kept_description
from .clients import prometheus_server

INJECTIONS = [
    "' OR 1=1 --",
    '" OR ""="',
    "'; DROP TABLE users; --",
    "1; SELECT pg_sleep(5)",
    "%00",
    "\\",
    "{{7*7}}",
    "../../etc/passwd",
    "\u202e\u0000",
]


def _parameters(operation: dict) -> list[dict]:
    return [each for each in operation.get("parameters", []) if each["in"] in {"query", "path"}]


@pytest.fixture(scope="module")
def described(shared_world) -> dict:
    """Every route, as the reference describes it."""
    return kept_description(shared_world.hub.hub.app)["paths"]


@pytest.mark.asyncio(loop_scope="module")
@pytest.mark.parametrize("words", INJECTIONS)
async def test_no_filter_and_no_name_in_a_path_becomes_sql(
    unhurried, shared_world, described, words
) -> None:
    # Nothing is changed by asking, so one world does for all of these words.
    world = shared_world
    client = await world.admin()
    by_token = await prometheus_server.token(world.hub, prometheus_server.EVERYWHERE)
    asking = {}
    for path, methods in described.items():
        if "get" in methods:
            recipe = RECIPES["GET", path]
            asking[path] = await recipe.make(world, client, recipe.objects[0])
    # Now everybody and everything is there that is asked about.
    before = await world.state()
    asked = 0
    for path, right in asking.items():
        operation = described[path]["get"]
        # A session is nobody to what serves clients of other tools.
        serves_clients = need_of_route("GET", path) is AccessNeed.CLIENT
        for parameter in _parameters(operation):
            name = parameter["name"]
            params = {**right.params, **({name: words} if parameter["in"] == "path" else {})}
            query = {**right.query, **({name: words} if parameter["in"] == "query" else {})}
            target = path
            for each, value in params.items():
                target = target.replace(f"{{{each}}}", quote(value, safe=""))
            headers = by_token if serves_clients else {}
            answer = await client.get(target, params=query, headers=headers)
            asked += 1
            # What is shut to everybody is refused before anything is looked at.
            allowed = {200, 404, 422} | ({400, 403} & set(right.done))
            assert answer.status_code in allowed, (path, name, answer.text)
            if answer.status_code == 200 and path == "/api/audit":
                assert answer.json()["rows"] == [], name
    assert asked >= 10
    after = await world.state()
    for table in ("users", "roles", "permissions", "role_permissions", "gateways", "sites"):
        assert after[table] == before[table]


async def test_name_with_line_breaks_forges_no_row_and_no_line(world, caplog) -> None:
    caplog.set_level(logging.INFO)
    client = await world.client("nobody")
    forged = "eve\n2026-01-01 INFO talaia: admin signed in\r\n\x1b[2J\u2028admin"
    answer = await client.post("/api/login", json={"name": forged, "password": "wrong password"})
    assert answer.status_code == 401
    await world.hub.hub.audit.log.wait_written()
    async with world.hub.hub.core.database.read() as connection:
        rows = (await connection.execute(select(audit.c.kind, audit.c.who))).all()
    failed = [row.who for row in rows if row.kind == "login failed"]
    assert len(failed) == 1
    assert not any(ord(character) < 32 or character == "\u2028" for character in failed[0])
    assert not any("admin signed in" in line and "eve" not in line for line in caplog.messages)


async def test_no_secret_is_written_into_the_audit_log_or_the_log(world, caplog) -> None:
    caplog.set_level(logging.DEBUG)
    listeners = [await listen(world, actor) for actor in ("operator", "driver")]
    await settle(listeners)
    await everything(world, listeners)
    await (await world.client("nobody")).post(
        "/api/login", json={"name": "admin", "password": "a wrong password of the admin"}
    )
    await world.hub.hub.audit.log.wait_written()
    async with world.hub.hub.core.database.read() as connection:
        rows = (await connection.execute(select(audit))).all()
    written = json.dumps([list(map(str, row)) for row in rows]) + "\n".join(
        record.getMessage() for record in caplog.records if record.name.startswith("talaia")
    )
    hidden = [
        PASSWORD,
        "a wrong password of the admin",
        world.token,
        *world.hub.keys.values(),
        *world.hub._cookies.values(),
    ]
    assert "login failed" in written
    assert len(hidden) >= 7
    for secret in hidden:
        assert secret not in written
        assert hash_token(secret) not in written


@pytest.mark.parametrize(
    "more",
    [{"role": "admin"}, {"admin": True}, {"permissions": [{"right": "admin"}]}, {"id": 1}],
    ids=lambda more: next(iter(more)),
)
async def test_nobody_gives_themselves_more_than_they_were_asked_for(world, more) -> None:
    async def roles() -> list:
        async with world.hub.hub.core.database.read() as connection:
            return (await connection.execute(select(users.c.name, users.c.role_id))).all()

    client, before = await world.client("driver"), await roles()
    bodies = {
        "/api/me/password": {"old": PASSWORD, "new": "another password of these tests"},
        "/api/me/factor": {"password": PASSWORD},
        "/api/login": {"name": "driver", "password": PASSWORD},
    }
    for path, body in bodies.items():
        assert (await client.post(path, json={**body, **more})).status_code == 422
    me = (await client.get("/api/me")).json()
    assert (me["role"], me["admin"]) == ("driver", False)
    assert await roles() == before


async def test_token_has_no_more_than_its_person(world) -> None:
    client = await world.client("driver")
    for right, device in (("use", "power"), ("use", "*"), ("admin", "base")):
        asked = {"right": right, "site": "agv", "device": device}
        body = {"name": "more", "ends_us": NOW * 2, "permissions": [asked]}
        answer = await client.post("/api/me/tokens", json=body)
        assert answer.status_code in {403, 422}
    assert (await client.get("/api/me/tokens")).json() == {"tokens": []}


async def test_pages_of_a_debugger_or_of_the_api_are_not_there(world) -> None:
    client = await world.client("nobody")
    for path in ("/docs", "/redoc", "/openapi.json", "/debug", "/.git/config", "/api/"):
        answer = await client.get(path)
        assert "swagger" not in answer.text.lower()
        assert "openapi" not in answer.text.lower()
        assert "server" not in answer.headers
        assert "x-powered-by" not in answer.headers


def test_tokens_hold_256_bits_of_the_systems_randomness(monkeypatch) -> None:
    taken = []
    real = secrets.token_bytes
    monkeypatch.setattr(secrets, "token_bytes", lambda n=None: taken.append(n) or real(n))
    made = {new_token() for _ in range(1000)}
    assert len(made) == 1000
    for token in made:
        assert len(base64.urlsafe_b64decode(token + "=" * (-len(token) % 4))) >= 32
    assert all(count is None or count >= 32 for count in taken)


async def test_session_that_a_browser_brings_is_not_taken_over(world) -> None:
    brought = new_token()
    client = await world.client("nobody")
    client.cookies.set("talaia", brought)
    await client.post("/api/login", json={"name": "driver", "password": PASSWORD})
    given = {cookie.value for cookie in client.cookies.jar if cookie.name == "talaia"}
    assert given - {brought}
    other = await world.client("nobody")
    other.cookies.set("talaia", brought)
    assert (await other.get("/api/me")).status_code == 401
