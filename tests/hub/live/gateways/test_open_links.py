"""Gateways that are connected: known by their keys, sent away at once when a key is revoked."""

from __future__ import annotations

import pytest
import websockets

from talaia.clock import SystemClock
from talaia.hub.live.gateways.open_links import OpenLinks
from talaia.hub.live.sites import Sites
from talaia.hub.store.sites.site_registry import SiteRegistry
from talaia.wire import browser as page_wire
from talaia.wire.frames import Bye, Event, ReconnectRequest


async def online(admin) -> dict:
    listed = (await admin.get("/api/gateways")).json()["gateways"]
    return next(each for each in listed if each["online"])


async def test_revoked_gateway_is_gone_at_once_and_stays_out(hub, gateway) -> None:
    admin = await hub.client("admin")
    camera = await hub.camera()
    mine = await online(admin)
    assert (await admin.post(f"/api/gateways/{mine['id']}/revoke")).status_code == 204
    assert "revoked" in (await gateway.hear(Bye)).reason
    assert await gateway.closed() == 4409
    await camera.closed()
    for path in ("/gateway/link", "/gateway/media", "/gateway/files"):
        with pytest.raises(websockets.InvalidStatus) as refused:
            await hub.dial(path, {"Authorization": f"Bearer {hub.keys['agv']}"})
        assert refused.value.response.status_code == 401
    listed = (await admin.get("/api/gateways")).json()["gateways"]
    assert [(each["online"], each["revoked_us"] > 0) for each in listed] == [(False, True)]
    assert (await admin.post(f"/api/gateways/{mine['id']}/revoke")).status_code == 409


async def test_key_revoked_by_another_process_closes_the_link_within_a_second(hub, gateway) -> None:
    await SiteRegistry(hub.hub.core.database, SystemClock()).new_key("agv")
    assert await gateway.closed() == 4409


class Line:
    """A connection of a gateway, which remembers how it was sent away."""

    reason = ""

    def dismiss_gateway(self, reason: str) -> None:
        self.reason = reason


async def test_each_key_that_becomes_void_ends_its_links_whenever_these_were_opened(hub) -> None:
    registry = SiteRegistry(hub.hub.core.database, SystemClock())
    links = OpenLinks(Sites(), registry)
    keys = [await registry.gateway_of(await registry.new_key(f"site {at}")) for at in range(3)]
    early, kept, late = Line(), Line(), Line()
    with links.count_open(keys[0].id, early), links.count_open(keys[1].id, kept):
        await links.check_keys()
        assert (early.reason, kept.reason) == ("", "")
        # One that is linked, and one whose key was looked up and who is not in yet.
        await registry.new_key("site 0")
        await registry.new_key("site 2")
        await links.check_keys()
        assert "revoked" in early.reason
        with links.count_open(keys[2].id, late):
            await links.check_keys()
        assert "revoked" in late.reason
        assert not kept.reason
        await registry.new_key("site 1")
        await links.check_keys()
        assert "revoked" in kept.reason


async def test_asked_to_dial_again_the_link_is_closed_and_the_key_still_good(hub, gateway) -> None:
    admin = await hub.client("admin")
    mine = await online(admin)
    answer = await admin.post(f"/api/gateways/{mine['id']}/reconnect", json={})
    assert answer.status_code == 202
    assert "admin asked it to dial again" in (await gateway.hear(Bye)).reason
    await gateway.closed()
    again = await hub.gateway()
    await again.hello()
    assert (await online(admin))["id"] == mine["id"]


async def test_reconnect_to_a_device_is_asked_of_the_gateway_and_its_outcome_is_told(
    hub, gateway
) -> None:
    admin, page = await hub.client("admin"), await hub.page("operator")
    mine = await online(admin)
    path = f"/api/gateways/{mine['id']}/reconnect"
    assert (await admin.post(path, json={"device": "base"})).status_code == 202
    assert await gateway.hear(ReconnectRequest) == ReconnectRequest(device="base", who="admin")
    await gateway.say(
        Event(kind="device reconnected", device="base", who="admin", message="3 of 3 are there")
    )
    told = await page.hear(page_wire.EventUpdate, lambda news: news.kind == "device reconnected")
    assert (told.device, told.who, told.message) == ("base", "admin", "3 of 3 are there")
    await hub.hub.audit.log.wait_written()
    rows = (await admin.get("/api/audit", params={"device": "base"})).json()["rows"]
    assert [row["kind"] for row in rows] == ["device reconnected", "device reconnect asked"]


async def test_reconnect_wants_a_gateway_that_is_there_and_a_device_that_it_has(
    hub, gateway
) -> None:
    admin = await hub.client("admin")
    path = f"/api/gateways/{(await online(admin))['id']}/reconnect"
    assert (await admin.post(path, json={"device": "cellar"})).status_code == 404
    assert (await admin.post("/api/gateways/999/reconnect", json={})).status_code == 404
    await gateway.close()
    page = await hub.page("operator")
    await page.hear(page_wire.SiteUpdate, lambda news: not news.online)
    assert (await admin.post(path, json={})).status_code == 409


async def test_operator_neither_revokes_nor_reconnects(hub, gateway) -> None:
    admin, operator = await hub.client("admin"), await hub.client("operator")
    mine = await online(admin)
    for word, body in (("revoke", None), ("reconnect", {})):
        answer = await operator.post(f"/api/gateways/{mine['id']}/{word}", json=body)
        assert answer.status_code == 403
    assert (await online(admin))["id"] == mine["id"]


async def test_changed_description_is_in_the_audit_log(hub, gateway) -> None:
    await gateway.close()
    again = await hub.gateway()
    await again.hello(again.description.replace("House vehicle", "House <b>vehicle</b>"))
    await hub.hub.audit.log.wait_written()
    admin = await hub.client("admin")
    rows = (await admin.get("/api/audit", params={"kind": "description changed"})).json()["rows"]
    assert [(row["site"], row["good"]) for row in rows] == [("agv", True)]
