"""Headers of proxies: believed from listed ones, and from nobody else."""

from __future__ import annotations

from dataclasses import replace
from ipaddress import ip_network

import httpx
import pytest
from shared_trust import usual_trust

from talaia.hub.api.server.proxies import Proxies

PASSWORD = "a password for tests"  # noqa: S105
SPOOFED = {
    "X-Forwarded-For": "203.0.113.9",
    "X-Forwarded-Proto": "https",
    "X-Forwarded-Host": "evil.test",
    "Forwarded": "for=203.0.113.9;host=evil.test;proto=https",
    "X-Real-IP": "203.0.113.9",
    "Remote-User": "admin",
    "X-Remote-User": "admin",
    "X-Forwarded-User": "admin",
}


async def addresses(hub, admin) -> set[str]:
    await hub.hub.audit.log.wait_written()
    rows = (await admin.get("/api/audit", params={"kind": "login"})).json()["rows"]
    return {row["address"] for row in rows}


async def test_headers_of_proxies_are_nothing_to_us(hub) -> None:
    nobody = await hub.client()
    assert (await nobody.get("/api/me", headers=SPOOFED)).status_code == 401
    wrong = {"name": "admin", "password": "wrong password"}
    answer = await nobody.post("/api/login", json=wrong, headers=SPOOFED)
    assert answer.status_code == 401
    assert "strict-transport-security" not in answer.headers
    assert "evil" not in answer.headers["content-security-policy"]
    assert await addresses(hub, await hub.client("admin")) == {"127.0.0.1"}


async def test_address_that_is_made_up_each_time_does_not_escape_the_throttle(hub) -> None:
    nobody = await hub.client()
    statuses = []
    for number in range(12):
        headers = {"X-Forwarded-For": f"203.0.113.{number}"}
        answer = await nobody.post("/api/enrol", json={"code": "x" * 14}, headers=headers)
        statuses.append(answer.status_code)
    assert statuses[-1] == 429


@pytest.fixture
def behind(settings, hub_that_stores):
    """Start a hub behind a proxy at 127.0.0.1."""
    running = hub_that_stores()
    running.__init__(replace(settings, proxies=(ip_network("127.0.0.1"),)), None)
    return running


async def test_behind_a_listed_proxy_pages_are_https_and_addresses_are_the_askers(behind) -> None:
    async with behind as running:
        await running.populate()
        origin = f"https://127.0.0.1:{running.port}"
        through = {
            "X-Forwarded-For": "198.51.100.7, 203.0.113.9",
            "X-Forwarded-Proto": "https",
            "Origin": origin,
        }
        async with httpx.AsyncClient(
            base_url=running.origin, headers=through, verify=usual_trust()
        ) as page:
            login = {"name": "admin", "password": PASSWORD}
            answer = await page.post("/api/login", json=login)
            assert answer.status_code == 200
            assert answer.headers["set-cookie"].startswith("__Host-")
            assert "strict-transport-security" in answer.headers
            cookie = answer.headers["set-cookie"].split(";")[0]
            made = await page.post(
                "/api/gateways/codes", json={"site": "agv"}, headers={"Cookie": cookie}
            )
            # The proxy's certificate is not ours to pin.
            assert made.json()["command"].startswith(f"talaia gateway enrol {origin} ")
            assert made.json()["fingerprint"] == ""
            await running.hub.audit.log.wait_written()
            audit = await page.get("/api/audit?kind=login", headers={"Cookie": cookie})
            assert [row["address"] for row in audit.json()["rows"]] == ["203.0.113.9"]


def scope(peer: str, *forwarded: str, proto: str = "https") -> dict:
    headers = [(b"x-forwarded-for", each.encode()) for each in forwarded]
    headers.append((b"x-forwarded-proto", proto.encode()))
    return {"type": "http", "client": (peer, 1), "scheme": "http", "headers": headers}


@pytest.mark.parametrize(
    ("peer", "forwarded", "client"),
    [
        ("10.0.0.5", ["203.0.113.9"], "203.0.113.9"),
        ("10.0.0.5", ["1.1.1.1, 203.0.113.9"], "203.0.113.9"),
        ("10.0.0.5", ["1.1.1.1", "203.0.113.9, 10.0.0.6"], "203.0.113.9"),
        ("10.0.0.5", ["203.0.113.9:4711"], "203.0.113.9"),
        ("10.0.0.5", ["[2001:db8::1]:443"], "2001:db8::1"),
        ("::ffff:10.0.0.5", ["203.0.113.9"], "203.0.113.9"),
        ("10.0.0.5", ["1.1.1.1, nonsense"], "10.0.0.5"),
        ("10.0.0.5", [], "10.0.0.5"),
        ("192.0.2.1", ["203.0.113.9"], "192.0.2.1"),
    ],
)
def test_asker_is_the_last_address_that_a_listed_proxy_vouches_for(peer, forwarded, client) -> None:
    seen = Proxies([ip_network("10.0.0.0/24")]).look_through(scope(peer, *forwarded))
    assert seen["client"][0] == client
    assert seen["scheme"] == ("http" if peer == "192.0.2.1" else "https")


def test_without_a_list_nobody_is_believed() -> None:
    asked = scope("127.0.0.1", "203.0.113.9")
    assert Proxies(()).look_through(asked) is asked
