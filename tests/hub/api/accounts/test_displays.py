"""Displays: screens that show chosen sites, know no person, and can do nothing else."""

from __future__ import annotations

import pytest
import websockets

from talaia.wire.browser import (
    Greeting,
    PageCommand,
    PageLease,
    PageStop,
    RequestError,
    SessionEnded,
    Subscribe,
    Subscribed,
    Values,
)
from talaia.wire.frames import LeaseOp, StopRequest

NOW = 1_700_000_000_000_000


async def made(hub, *sites: str) -> dict[str, str]:
    admin = await hub.client("admin")
    answer = await admin.post("/api/displays", json={"name": "Hall", "sites": [*sites] or ["agv"]})
    assert answer.status_code == 200, answer.text
    return answer.json()


async def opened(hub, token: str):
    """Open a screen as its page does: the token is in no address."""
    screen = await hub.client()
    answer = await screen.post("/api/displays/open", json={"token": token})
    assert answer.status_code == 204, answer.text
    return screen, answer


async def screen_socket(hub, token: str):
    headers = {"Cookie": f"talaia={token}", "Origin": hub.origin}
    return hub.peer(await hub.dial("/ws", headers))


async def test_a_display_shows_its_sites_and_is_told_apart_from_people(hub, gateway) -> None:
    token = (await made(hub))["token"]
    screen, answer = await opened(hub, token)
    cookie = answer.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    me = (await screen.get("/api/me")).json()
    assert (me["name"], me["role"], me["admin"]) == ("Hall", "display", False)
    assert [site["site"] for site in (await screen.get("/api/sites")).json()] == ["agv"]
    page = await screen_socket(hub, token)
    await page.hear(Greeting)
    await page.say(Subscribe(sub=1, site="agv", channels=["base/turn_rate"], every_ms=0))
    assert (await page.hear(Subscribed)).refused == []
    await gateway.samples(("base/turn_rate", NOW, 0.5))
    await page.hear(Values)


async def test_a_display_commands_drives_and_stops_nothing(hub, gateway) -> None:
    page = await screen_socket(hub, (await made(hub))["token"])
    for message in (
        PageCommand(site="agv", device="base", command="wander", id="c1"),
        PageLease(site="agv", device="base", op=LeaseOp.TAKE),
        PageStop(site="agv", device="base", id="s1"),
    ):
        await page.say(message)
        assert (await page.hear(RequestError)).code == "forbidden"
    assert not [each for each in gateway.heard if isinstance(each, StopRequest)]


async def test_a_display_asks_only_for_what_is_shown(hub, gateway) -> None:
    screen, _ = await opened(hub, (await made(hub))["token"])
    for method, path, status in (
        ("GET", "/api/people", 403),
        ("GET", "/api/displays", 403),
        ("GET", "/api/gateways", 403),
        ("GET", "/api/audit", 403),
        ("GET", "/api/me/tokens", 403),
        ("POST", "/api/me/password", 403),
        # One line of the policy for looking and for doing.
        ("POST", "/api/sites/agv/alarms/any/act", 403),
    ):
        assert (await screen.request(method, path, json={})).status_code == status, path


async def test_a_display_of_another_site_sees_nothing_but_what_is_public(hub, gateway) -> None:
    display = await made(hub)
    # Its site's description went away, and another came.
    displays = hub.hub.people.displays
    _, token = await displays.add_display("Elsewhere", ["house"])
    page = await screen_socket(hub, token)
    await page.say(Subscribe(sub=1, site="agv", channels=["base/turn_rate"], every_ms=0))
    assert (await page.hear(Subscribed)).refused == ["base/turn_rate"]
    assert display["token"] != token


async def test_a_revoked_display_is_dark_at_once_and_its_maker_may_go(hub, gateway) -> None:
    admin = await hub.client("admin")
    display = await made(hub)
    page = await screen_socket(hub, display["token"])
    await page.hear(Greeting)
    (listed,) = (await admin.get("/api/displays")).json()["displays"]
    assert (listed["name"], listed["sites"], listed["used_us"] > 0) == ("Hall", ["agv"], True)
    assert (await admin.delete(f"/api/displays/{display['id']}")).status_code == 204
    await page.hear(SessionEnded)
    with pytest.raises(websockets.InvalidStatus):
        await screen_socket(hub, display["token"])
    screen = await hub.client()
    answer = await screen.post("/api/displays/open", json={"token": display["token"]})
    assert answer.status_code == 401
    assert (await admin.delete(f"/api/displays/{display['id']}")).status_code == 404
    await hub.hub.audit.log.wait_written()
    rows = (await admin.get("/api/audit")).json()["rows"]
    kinds = [row["kind"] for row in rows]
    assert {"display made", "display revoked", "display refused"} <= set(kinds)
    assert display["token"] not in str(rows)


async def test_a_displays_token_signs_in_no_script_and_no_tool(hub, gateway) -> None:
    token = (await made(hub))["token"]
    client = await hub.client()
    client.headers["Authorization"] = f"Bearer {token}"
    assert (await client.get("/api/sites")).status_code == 401


async def test_only_an_admin_makes_displays_and_of_sites_that_are_there(hub, gateway) -> None:
    operator, admin = await hub.client("operator"), await hub.client("admin")
    asked = {"name": "Hall", "sites": ["agv"]}
    assert (await operator.post("/api/displays", json=asked)).status_code == 403
    answer = await admin.post("/api/displays", json={**asked, "sites": ["nowhere"]})
    assert "nowhere" in answer.json()["message"]
    assert (await admin.post("/api/displays", json={**asked, "sites": []})).status_code == 422
