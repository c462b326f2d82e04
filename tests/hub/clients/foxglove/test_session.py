"""Foxglove clients at a real hub: npm's own as guest, operator and admin, and an adversary."""

from __future__ import annotations

import asyncio
import base64
import json
import struct

import pytest
import websockets

from talaia.hub.store.audit import AuditFilter
from talaia.wire import frames
from talaia.wire.frames import CommandPhase, LeaseOp

from ...everyone.world import NOW
from ..tokens import open_protocol, token_of
from .foxglove_peer import SDK, V1, NodeClient, client_of, services_of, topics_of

pytestmark = pytest.mark.asyncio(loop_scope="module")


# What each may see of the site, written by hand: see `everyone.world`.
SEEN = {
    "guest": {"/base/open"},
    "driver": {"/base/open", "/base/shut", "/base/words", "/base/eye", "/base/eye/video"},
    "operator": {
        f"/{device}/{name}"
        for device in ("base", "power", "camera")
        for name in ("open", "shut", "words", "eye", "eye/video")
    },
}
SEEN["admin"] = SEEN["operator"]
CALLED = {
    "guest": set(),
    "driver": {"/base/turn", "/base/drive/stop", "/turn"},
    "operator": {
        f"/{device}/{name}"
        for device in ("base", "power", "camera")
        for name in ("turn", "drive/stop")
    }
    | {"/turn"},
}
CALLED["admin"] = CALLED["operator"]


@pytest.mark.parametrize("subprotocol", [V1, SDK])
@pytest.mark.parametrize("name", SEEN)
async def test_npm_client_is_offered_what_its_person_may_see_and_nothing_else(
    shared_world, name, subprotocol
) -> None:
    async with await client_of(
        shared_world, name, kind=NodeClient, subprotocol=subprotocol
    ) as client:
        # The eye of the base is public where the base is, for its stream names no visibility.
        assert set(await topics_of(client)) == SEEN[name]
        if CALLED[name]:
            assert set(await services_of(client)) == CALLED[name]
        await client.call("subscribeConnectionGraph")
        graph = await client.hear("connectionGraphUpdate")
        assert {topic["name"] for topic in graph["publishedTopics"]} == SEEN[name]
        assert {service["name"] for service in graph["advertisedServices"]} == CALLED[name]


async def test_npm_client_gets_samples_and_calls_a_command(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    async with await client_of(shared_world, "operator", kind=NodeClient) as client:
        topics, services = await topics_of(client), await services_of(client)
        subscription = await client.call("subscribe", topics["/base/open"])
        await gateway.samples(("base/open", NOW + 1, 0.5), ("base/words", NOW + 1, "hidden"))
        message = await client.hear("message", lambda said: "0.5" in str(said["data"]))
        assert message["subscriptionId"] == subscription
        assert message["timestamp"] == str((NOW + 1) * 1000)
        assert json.loads(message["data"]) == {
            "timestamp": {"sec": NOW // 10**6, "nsec": 1000},
            "value": 0.5,
        }
        call = {"serviceId": services["/base/turn"], "callId": 5, "encoding": "json", "data": "{}"}
        await client.call("sendServiceCallRequest", call)
        asked = await gateway.hear(frames.CommandRequest)
        assert (asked.device, asked.command, asked.who) == ("base", "turn", "operator")
        done = frames.CommandState(
            id=asked.id, device="base", command="turn", phase=CommandPhase.SUCCEEDED, message="ok"
        )
        await gateway.say(done)
        response = await client.hear("serviceCallResponse")
        assert (response["callId"], json.loads(response["data"])) == (
            5,
            {"phase": "succeeded", "message": "ok"},
        )
        await client.call("getParameters", [], "all")
        values = await client.hear("parameterValues")
        assert {"name": "/site", "value": "agv"} in values["parameters"]


async def test_guest_hears_nothing_of_what_is_not_public_whatever_it_asks(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    client = await client_of(shared_world, "guest")
    topics = await topics_of(client)
    asked = [{"id": number, "channelId": number} for number in range(1, 60)]
    await client.say({"op": "subscribe", "subscriptions": asked})
    await client.say({"op": "subscribeConnectionGraph"})
    await client.say({"op": "getParameters", "parameterNames": []})
    for service in range(1, 20):
        await client.call(service, service, b"{}")
    await gateway.samples(
        ("base/open", NOW + 2, 1.5),
        ("base/shut", NOW + 2, 777.0),
        ("power/words", NOW + 2, "hidden-word"),
    )
    await client.hear("data", lambda frame: b"1.5" in frame)
    await client.hear("parameterValues")
    await client.hear("serviceCallFailure", lambda said: said["callId"] == 19)
    said = "".join(
        frame if isinstance(frame, str) else frame[13:].decode() for frame in client.frames
    )
    assert set(topics) == {"/base/open"}
    for word in ("777", "hidden", "power", "moon", "rover", "words", "shut", "/turn"):
        assert word not in said, word
    await client.close()


async def test_site_that_is_not_for_its_person_is_as_if_it_were_not_there(shared_world) -> None:
    for site in ("moon", "nowhere"):
        with pytest.raises(websockets.InvalidStatus) as refused:
            await client_of(shared_world, "guest", site=site)
        assert refused.value.response.status_code == 404


async def status_of(hub, path: str, headers=None, *, subprotocols=(SDK,)) -> int:
    """Give the status by which a socket is refused; 101 when it is not."""
    try:
        socket = await websockets.connect(
            f"ws://127.0.0.1:{hub.port}{path}",
            additional_headers=headers or {},
            subprotocols=subprotocols or None,
            proxy=None,
        )
    except websockets.InvalidStatus as error:
        return error.response.status_code
    await socket.close()
    return 101


async def test_only_a_good_token_opens_it_and_a_cookie_never_does(shared_world, caplog) -> None:
    hub = shared_world.hub
    await open_protocol(hub, "foxglove")
    token = await token_of(hub, "operator")
    path = "/clients/foxglove/agv"
    basic = "Basic " + base64.b64encode(f"anyone:{token}".encode()).decode()
    cookie = await hub.cookie("admin")
    tried = {
        "none": await status_of(hub, path),
        "wrong": await status_of(hub, f"{path}?token=tal_{'x' * 43}"),
        "not ours": await status_of(hub, f"{path}?token=hunter2"),
        "cookie": await status_of(hub, path, {"Cookie": cookie}),
        "cookie of a page": await status_of(hub, path, {"Cookie": cookie, "Origin": hub.origin}),
        "address": await status_of(hub, f"{path}?token={token}"),
        "bearer": await status_of(hub, path, {"Authorization": f"Bearer {token}"}),
        "basic": await status_of(hub, path, {"Authorization": basic}),
        "broken basic": await status_of(hub, path, {"Authorization": "Basic %%%"}),
        "no subprotocol": await status_of(hub, f"{path}?token={token}", subprotocols=()),
        "strange subprotocol": await status_of(
            hub, f"{path}?token={token}", subprotocols=("mqtt",)
        ),
    }
    assert tried == {
        "none": 401,
        "wrong": 401,
        "not ours": 401,
        "cookie": 401,
        "cookie of a page": 403,
        "address": 101,
        "bearer": 101,
        "basic": 101,
        "broken basic": 401,
        "no subprotocol": 400,
        "strange subprotocol": 400,
    }
    assert token not in caplog.text


async def test_only_pages_of_named_origins_are_let_in(shared_world) -> None:
    hub = shared_world.hub
    token = await token_of(hub, "operator")
    path = f"/clients/foxglove/agv?token={token}"
    await open_protocol(hub, "foxglove", "https://tools.example")
    tried = {
        origin: await status_of(hub, path, {"Origin": origin})
        for origin in ("https://tools.example", "https://evil.test", "null", hub.origin)
    }
    assert tried == {
        "https://tools.example": 101,
        "https://evil.test": 403,
        "null": 403,
        hub.origin: 403,
    }


async def test_shut_protocol_lets_nobody_in_and_ends_who_is_there(shared_world) -> None:
    hub = shared_world.hub
    client = await client_of(shared_world, "operator")
    await topics_of(client)
    assert hub.hub.client_protocols.protocols.count_connected("foxglove") >= 1
    admin = await shared_world.admin()
    asked = {"open": False, "origins": []}
    answer = await admin.put("/api/client-protocols/foxglove", json=asked)
    assert answer.status_code == 204
    assert await client.hear("closed") == 4401
    assert (
        await status_of(hub, f"/clients/foxglove/agv?token={await token_of(hub, 'operator')}")
        == 403
    )
    listed = (await admin.get("/api/client-protocols")).json()["protocols"]
    assert [row["open"] for row in listed if row["protocol"] == "foxglove"] == [False]
    records = await hub.hub.audit.log.find_records(AuditFilter(kind="client protocol shut"), 10)
    assert records


async def test_revoked_token_ends_its_connection(shared_world) -> None:
    client = await client_of(shared_world, "operator")
    await topics_of(client)
    tokens = shared_world.hub.hub.people.tokens
    person = (await shared_world.hub.people.find_by_name("operator")).id
    for token in await tokens.tokens_of(person):
        if token.name.startswith("of "):
            await tokens.revoke_token(person, token.id)
    assert await client.hear("closed") == 4401


async def test_nonsense_is_refused_and_what_is_unknown_is_passed_over(shared_world) -> None:
    client = await client_of(shared_world, "operator")
    await topics_of(client)
    await client.say({"op": "brewCoffee"})
    assert "brewCoffee" in (await client.hear("status"))["message"]
    await client.say({"op": "unsubscribe", "subscriptionIds": [99]})
    await client.say(struct.pack("<BI", 1, 77) + b"{}")
    assert "not advertised" in (await client.hear("status"))["message"]
    await client.say("{")
    assert await client.hear("closed") == 1002


async def test_giant_message_ends_the_connection(shared_world) -> None:
    client = await client_of(shared_world, "operator")
    await topics_of(client)
    await client.say("x" * (1024 * 1024 + 1))
    assert await client.hear("closed") == 1009


async def test_thousand_changes_of_subscriptions_leave_what_is_wanted(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    client = await client_of(shared_world, "operator")
    topics = await topics_of(client)
    numbers = list(topics.values())
    for turn in range(1000):
        channel = numbers[turn % len(numbers)]
        await client.say({"op": "subscribe", "subscriptions": [{"id": turn, "channelId": channel}]})
        await client.say({"op": "unsubscribe", "subscriptionIds": [turn]})
    last = {"id": 5000, "channelId": topics["/base/shut"]}
    await client.say({"op": "subscribe", "subscriptions": [last]})
    # Answered after all of them.
    await client.say({"op": "getParameters", "parameterNames": []})
    await client.hear("parameterValues")
    await gateway.samples(("base/shut", NOW + 3, 41.5))
    await client.hear("data", lambda frame: b"41.5" in frame and frame[1:5] == b"\x88\x13\0\0")
    (browser,) = [
        browser for browser in shared_world.hub.hub.core.browsers if browser.form == "object"
    ]
    assert shared_world.hub.hub.core.fanout.held(browser) == (1, 1)
    await client.close()


async def test_client_that_does_not_read_costs_a_bounded_outbox_and_delays_nobody(
    shared_world,
) -> None:
    gateway = shared_world.gateways["agv"]
    slow = await client_of(shared_world, "operator", max_queue=1)
    topics = await topics_of(slow)
    slow._reading.cancel()
    wanted = [{"id": number, "channelId": number} for number in topics.values()]
    await slow.say({"op": "subscribe", "subscriptions": wanted})
    quick = await client_of(shared_world, "operator")
    await topics_of(quick)
    await quick.say({"op": "subscribe", "subscriptions": wanted})
    for turn in range(15):
        text = f"{turn} " + "x" * 400
        rows = [("base/words", NOW + 10 + turn * 1000 + at, text) for at in range(1000)]
        await gateway.samples(*rows)
        await quick.hear("data", lambda frame, turn=turn: f'"{turn} xx'.encode() in frame)
    waiting = [
        browser.waiting
        for browser in shared_world.hub.hub.core.browsers
        if browser.form == "object"
    ]
    assert len(waiting) == 2
    assert max(waiting) < 8 * 1024 * 1024
    await quick.close()
    slow.socket.transport.abort()


TWIST = {"linear": {"x": 0.9, "y": 0, "z": 0}, "angular": {"x": 0, "y": 0, "z": 0.2}}
DRIVING = {"id": 1, "topic": "/v", "encoding": "json", "schemaName": "geometry_msgs/Twist"}


async def test_published_velocity_is_refused_until_an_admin_permits_it(shared_world) -> None:
    hub, gateway = shared_world.hub, shared_world.gateways["agv"]
    client = await client_of(shared_world, "driver")
    await topics_of(client)
    await client.say({"op": "advertise", "channels": [DRIVING]})
    said = struct.pack("<BI", 1, 1) + json.dumps(TWIST).encode()
    await client.say(said)
    assert "an admin may let your account" in (await client.hear("status"))["message"]
    admin = await shared_world.admin()
    person = (await hub.people.find_by_name("driver")).id
    asked = {"person": str(person), "site": "agv", "device": "base", "allowed": True}
    assert (await admin.put("/api/client-drivers", json=asked)).status_code == 204
    await client.say(said)
    lease = await gateway.hear(frames.LeaseRequest)
    assert (lease.op, lease.who) == (LeaseOp.TAKE, "driver")
    await gateway.say(frames.ControlTick(tick=41))
    await gateway.say(
        frames.LeaseState(
            device="base", session=lease.session, who="driver", epoch=9, remains_ms=3000
        )
    )
    await gateway.say(frames.ControlTick(tick=42))

    async def keep_driving() -> None:
        while True:
            await client.say(said)
            await asyncio.sleep(0.05)

    driving = asyncio.create_task(keep_driving())
    moved = await gateway.hear(frames.DriveFrame, lambda frame: frame.linear > 0)
    driving.cancel()
    # Half of the description's 1 m/s.
    assert (moved.linear, moved.angular, moved.epoch, moved.tick) == (0.5, 0.2, 9, 42)
    zero = await gateway.hear(frames.DriveFrame, lambda frame: frame.linear == 0)
    assert zero.seq > moved.seq
    await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.FREE)
    await client.close()
    asked["allowed"] = False
    assert (await admin.put("/api/client-drivers", json=asked)).status_code == 204


async def test_stop_is_a_service_for_whoever_may_look(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    client = await client_of(shared_world, "driver")
    services = await services_of(client)
    await client.call(services["/base/drive/stop"], 3, b"")
    stop = await gateway.hear(frames.StopRequest)
    assert (stop.device, stop.who) == ("base", "driver")
    await gateway.say(frames.StopState(device="base", latched=True, who="driver", id=stop.id))
    response = await client.hear("response")
    assert response[5:9] == struct.pack("<I", 3)
    await client.close()


@pytest.mark.parametrize("payload", [b"{", b"[]", b'{"a": [1]}', b"\xff", b'{"a": 1}'])
async def test_arguments_that_are_none_fail_the_call(shared_world, payload) -> None:
    client = await client_of(shared_world, "driver")
    services = await services_of(client)
    await client.call(services["/base/turn"], 3, payload)
    failure = await client.hear("serviceCallFailure")
    assert failure["callId"] == 3
    assert failure["message"]
    await client.close()
