"""Names that people and robots choose: carried as text, or refused; never run by anybody."""

from __future__ import annotations

import csv
import io

import pytest
import pytest_asyncio

from talaia.hub.auth import passwords
from talaia.wire.frames import Hello

from ..conftest import MemoryHistory, RunningHub, settings_in

PASSWORD = "a password for tests"  # noqa: S105
PAYLOADS = [
    "<script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "javascript:alert(1)",
    "{{7*7}} ${7*7} #{7*7} <%= 7*7 %>",
    "=cmd|' /C calc'!A0",
    "@SUM(1)",
    "'; DROP TABLE audit; --",
    "../../etc/passwd",
    "$(reboot) `reboot` ; reboot | reboot",
    "__proto__",
    "é 望楼 🤖",
]


def described(name: str, description: str) -> str:
    """Give the vehicle's description with a hostile name wherever people choose one."""
    shown = name.replace("'", "''")
    for said in ("House vehicle", "Vehicle base", "Speed", "Wander mode"):
        description = description.replace(f"name: {said}\n", f"name: '{shown}'\n", 1)
    return description


@pytest.mark.asyncio(loop_scope="module")
@pytest.mark.parametrize("payload", PAYLOADS)
async def test_hostile_names_of_a_description_are_carried_as_they_are(shared_hub, payload) -> None:
    hub = shared_hub
    gateway = await hub.gateway()
    await gateway.hello(described(payload, gateway.description))
    admin = await hub.client("admin")
    site = await admin.get("/api/sites/agv")
    assert site.headers["content-type"] == "application/json"
    assert site.headers["x-content-type-options"] == "nosniff"
    said = site.json()
    assert said["name"] == said["devices"][0]["name"] == payload
    assert said["devices"][0]["signals"][0]["name"] == payload
    assert (await admin.get("/api/sites")).json()[0]["name"] == payload


UNFIT = {
    "a device's id": ("  base:\n", "  'base<script>':\n"),
    "a signal's id": ("      speed:\n", "      '../speed':\n"),
    "the site's id": ("site: agv\n", "site: 'agv/../x'\n"),
    "a unit": ("unit: m/s\n", "unit: '<b>m/s</b>'\n"),
    "a name that cannot be seen": ("name: Vehicle base\n", 'name: "Vehicle\\u202ebase"\n'),
    "a name of two lines": ("name: Vehicle base\n", 'name: "Vehicle\\nbase"\n'),
    "a topic": ("topic: /odom,", "topic: '/odom; rm -rf /',"),
    "an object of Python's": ("zone: ", "zone: !!python/object/apply:os.system ['true'] #"),
}


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def unknowing_hub(tmp_path_factory):
    """A hub that knows no site: none is ever described to it as it should be."""
    settings = settings_in(tmp_path_factory.mktemp("unknowing"))
    async with RunningHub(settings, MemoryHistory()) as running:
        await running.populate()
        yield running


@pytest.mark.asyncio(loop_scope="module")
@pytest.mark.parametrize("what", UNFIT)
async def test_description_with_a_name_that_does_not_fit_is_refused(unknowing_hub, what) -> None:
    hub = unknowing_hub
    gateway = await hub.gateway()
    before, after = UNFIT[what]
    description = gateway.description.replace(before, after, 1)
    assert description != gateway.description
    await gateway.say(Hello(site="agv", boot="b", description=description, catalogue="c"))
    assert await gateway.closed() == 4400
    assert (await (await hub.client("admin")).get("/api/sites")).json() == []


# In two hubs: one lets nobody enrol more often from one address.
@pytest.mark.parametrize("payloads", [PAYLOADS[:6], PAYLOADS[6:]], ids=["first", "last"])
async def test_hostile_names_reach_the_audit_file_as_text(hub, payloads) -> None:
    nobody, admin = await hub.client(), await hub.client("admin")
    for payload in payloads:
        await nobody.post("/api/login", json={"name": payload, "password": "wrong password"})
        made = await admin.post("/api/gateways/codes", json={"site": "agv", "name": payload})
        enrolled = await nobody.post("/api/enrol", json={"code": made.json()["code"]})
        listed = (await admin.get("/api/gateways")).json()["gateways"]
        (mine,) = [each for each in listed if each["id"] == enrolled.json()["gateway"]]
        assert mine["name"] == payload
    answer = await admin.get("/api/audit/export")
    rows = list(csv.DictReader(io.StringIO(answer.text, newline="")))
    failed = [row["who"] for row in rows if row["kind"] == "login failed"]
    assert sorted(who.lstrip("'") for who in failed) == sorted(
        payload.lstrip("'") for payload in payloads
    )
    assert not any(who.startswith(tuple("=+-@\t\r")) for who in failed)


@pytest.mark.parametrize(
    "name",
    ["a\nb", "a\x00b", "a\u202eb", " a", "", "x" * 65, "a\ud800b".encode("utf-8", "replace")],
)
async def test_person_gets_no_name_that_cannot_be_seen(empty_hub, name) -> None:
    client = await empty_hub.client()
    said = name.decode() + "\x1b" if isinstance(name, bytes) else name
    asked = {"token": empty_hub.hub.people.setup_token, "name": said, "password": PASSWORD}
    assert (await client.post("/api/setup", json=asked)).status_code == 422


async def test_role_in_a_body_that_has_none_is_an_error_not_a_promotion(hub) -> None:
    nobody = await hub.client()
    asked = {"name": "guest", "password": PASSWORD, "role": "admin", "admin": True}
    assert (await nobody.post("/api/login", json=asked)).status_code == 422
    admin = await hub.client("admin")
    for more in ({"key": "x"}, {"expires_us": 2**53}, {"id": "1"}):
        answer = await admin.post("/api/gateways/codes", json={"site": "agv", **more})
        assert answer.status_code == 422


async def test_unknown_name_costs_the_hub_the_same_work_as_a_known_one(hub, monkeypatch) -> None:
    checked = []
    check = passwords.bcrypt.checkpw

    def counted(password: bytes, kept: bytes) -> bool:
        checked.append(kept.split(b"$")[2])
        return check(password, kept)

    monkeypatch.setattr(passwords.bcrypt, "checkpw", counted)
    nobody = await hub.client()
    answers = [
        await nobody.post("/api/login", json={"name": name, "password": "wrong password"})
        for name in ("operator", "nobody here")
    ]
    # One check each, at the same cost; and the same words.
    assert len(checked) == 2
    assert checked[0] == checked[1]
    assert answers[0].status_code == answers[1].status_code == 401
    assert answers[0].content == answers[1].content
    assert answers[0].headers.keys() == answers[1].headers.keys()
