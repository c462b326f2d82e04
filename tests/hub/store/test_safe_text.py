"""Texts that a database cannot keep, or that mean something to SQL, on each of the databases."""

import dataclasses

import pytest

from ..conftest import MemoryHistory, RunningHub

PASSWORD = "a password for tests"  # noqa: S105
HOSTILE = (
    "\0", "a\0b", "' OR 1=1 --", '"; DROP TABLE users; --', "%", "_", "\\", "${x}", "{{7*7}}",
    "😀", "\u202e", "\ufdfa" * 60, "x" * 200, "\r\nSet-Cookie: a=b", "--", "/*", "0x41",
)  # fmt: skip


@pytest.fixture
async def stored(settings, database_url):
    settings = dataclasses.replace(settings, database_url=database_url)
    async with RunningHub(settings, MemoryHistory()) as hub:
        await hub.populate()
        yield hub


async def test_no_text_brings_the_hub_to_its_knees(stored) -> None:
    admin, stranger = await stored.client("admin"), await stored.client()
    for text in HOSTILE:
        asked = [
            stranger.post("/api/login", json={"name": text, "password": text, "code": text[:64]}),
            stranger.post("/api/enrol", json={"code": text, "name": text[:100]}),
            admin.post("/api/people", json={"name": text, "password": PASSWORD, "role": text}),
            admin.post("/api/people", json={"name": text, "password": PASSWORD, "role": "guest"}),
            admin.post("/api/roles", json={"name": text, "permissions": []}),
            admin.post("/api/gateways/codes", json={"site": "agv", "name": text[:100]}),
            admin.get("/api/audit", params={"who": text, "kind": text, "site": text}),
            admin.get("/api/sites/agv/events", params={"limit": text}),
            admin.delete(f"/api/me/sessions/{text!r}"),
            admin.get("/api/me", headers={"User-Agent": "x" * 5000}),
        ]
        for each in asked:
            answer = await each
            assert answer.status_code < 500, (text, answer.request.url, answer.text)
    people = (await admin.get("/api/people")).json()["people"]
    assert {"guest", "operator", "admin"} <= {each["name"] for each in people}
    assert all(each["name"].isprintable() for each in people)
    await stored.hub.audit.log.wait_written()
    assert (await admin.get("/api/audit/verify")).json()["ok"]


async def test_address_with_a_nul_is_refused(hub) -> None:
    admin = await hub.client("admin")
    assert (await admin.get("/api/audit?who=a%00b")).status_code == 422
    assert (await admin.get("/api/devices?x=%00")).status_code == 422
    assert (await admin.get("/api/sites/a%00b")).status_code == 404
