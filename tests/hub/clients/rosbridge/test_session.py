"""Rosbridge clients at a real hub: roslibpy and roslib, as guest, operator, admin; an adversary."""

from __future__ import annotations

import asyncio
import json
import struct

import cbor2
import pytest
import websockets
from patience import PATIENCE_S

from talaia.wire import frames
from talaia.wire.frames import CommandPhase, LeaseOp

from ...everyone.world import NOW
from ..tokens import open_protocol, token_of
from .rosbridge_peer import RawClient, RoslibpyClient, address_of

pytestmark = pytest.mark.asyncio(loop_scope="module")


async def raw_client(world, name, *, site="agv", **options):
    await open_protocol(world.hub, "rosbridge")
    token = await token_of(world.hub, name)
    return await RawClient().connect(address_of(world.hub, site, token), **options)


async def roslibpy_client(world, name):
    await open_protocol(world.hub, "rosbridge")
    return await RoslibpyClient().connect(world.hub, "agv", await token_of(world.hub, name))


# What each may see of the site, written by hand: see `everyone.world`.
DEVICES = ("base", "power", "camera")
SEEN = {
    "guest": {"/talaia/base/open"},
    "driver": {f"/talaia/base/{name}" for name in ("open", "shut", "words", "drive")} | {"/v"},
    "operator": {
        f"/talaia/{device}/{name}"
        for device in DEVICES
        for name in ("open", "shut", "words", "drive")
    }
    | {"/v"},
}
SEEN["admin"] = SEEN["operator"]
CALLED = {
    "guest": set(),
    "driver": {"/talaia/base/turn", "/talaia/base/drive/stop", "/turn"},
    "operator": {
        f"/talaia/{device}/{name}" for device in DEVICES for name in ("turn", "drive/stop")
    }
    | {"/turn"},
}
CALLED["admin"] = CALLED["operator"]


@pytest.mark.parametrize("name", SEEN)
async def test_rosapi_lists_what_its_person_may_see_and_nothing_else(shared_world, name) -> None:
    client = await raw_client(shared_world, name)
    topics = (await client.call("/rosapi/topics"))["values"]
    assert set(topics["topics"]) == SEEN[name]
    services = (await client.call("/rosapi/services"))["values"]
    assert set(services["services"]) == CALLED[name]
    devices = {topic.split("/")[2] for topic in SEEN[name] if topic.startswith("/talaia/")}
    nodes = (await client.call("/rosapi/nodes"))["values"]["nodes"]
    assert set(nodes) == {"/talaia", *(f"/talaia/{device}" for device in devices)}
    await client.close()


async def test_roslibpy_lists_subscribes_calls_and_reads_parameters(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    async with await roslibpy_client(shared_world, "operator") as client:
        await client.say("get_topics")
        assert set(await client.hear("found")) == SEEN["operator"]
        await client.say("get_topic_type", "/talaia/base/words")
        assert await client.hear("found") == "std_msgs/msg/String"
        await client.say("get_param", "/site")
        assert await client.hear("found") == "agv"
        await client.say("get_message_details", "geometry_msgs/Twist")
        assert "geometry_msgs/msg/Vector3" in json.dumps(await client.hear("found"))
        await client.say("subscribe", "/talaia/base/open", "std_msgs/Float64")
        await client.say("subscribe", "/talaia/base/words", "std_msgs/String")
        # Answered after both.
        await client.say("get_nodes")
        await client.hear("found")
        await gateway.samples(("base/open", NOW + 1, 0.5), ("base/words", NOW + 1, "hello"))
        await client.hear("message", lambda said: said == ["/talaia/base/open", {"data": 0.5}])
        await client.hear("message", lambda said: said == ["/talaia/base/words", {"data": "hello"}])
        await client.say("call", "/talaia/base/turn", "std_srvs/Trigger", {})
        asked = await gateway.hear(frames.CommandRequest)
        assert (asked.device, asked.command, asked.who) == ("base", "turn", "operator")
        await end_command(gateway, asked, CommandPhase.SUCCEEDED, "ok")
        assert await client.hear("called") == {"success": True, "message": "ok"}
        await client.say("call", "/talaia/base/turn", "std_srvs/Trigger", {})
        await end_command(
            gateway, await gateway.hear(frames.CommandRequest), CommandPhase.FAILED, "jammed"
        )
        assert "jammed" in await client.hear("failed")


async def end_command(gateway, asked, phase, message) -> None:
    await gateway.say(
        frames.CommandState(
            id=asked.id, device=asked.device, command=asked.command, phase=phase, message=message
        )
    )


async def test_guest_hears_nothing_of_what_is_not_public_whatever_it_asks(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    client = await raw_client(shared_world, "guest")
    for topic in (*SEEN["admin"], "/a", "/b", "/scan"):
        await client.say("subscribe", topic=topic, type="std_msgs/Float64")
        await client.say("subscribe", topic=topic)
    for service in CALLED["admin"]:
        answer = await client.call(service)
        assert (answer["result"], answer["values"]) == (False, f"there is no service {service}")
    await client.say("publish", topic="/talaia/power/drive", msg={})
    await gateway.samples(
        ("base/open", NOW + 2, 1.5),
        ("base/shut", NOW + 2, 777.0),
        ("power/words", NOW + 2, "hidden-word"),
    )
    await client.hear("publish", lambda said: said["msg"] == {"data": 1.5})
    # What is only told back is what it asked itself.
    said = [frame for frame in client.frames if '"publish"' in frame]
    assert {json.loads(frame)["topic"] for frame in said} == {"/talaia/base/open"}
    assert "777" not in "".join(client.frames)
    assert "hidden" not in "".join(client.frames)
    await client.close()


async def test_site_that_is_not_for_its_person_is_as_if_it_were_not_there(shared_world) -> None:
    for site in ("moon", "nowhere"):
        with pytest.raises(websockets.InvalidStatus) as refused:
            await raw_client(shared_world, "guest", site=site)
        assert refused.value.response.status_code == 404


async def status_of(hub, path: str, headers=None) -> int:
    try:
        socket = await websockets.connect(
            f"ws://127.0.0.1:{hub.port}{path}", additional_headers=headers or {}, proxy=None
        )
    except websockets.InvalidStatus as error:
        return error.response.status_code
    await socket.close()
    return 101


async def test_only_a_good_token_opens_it_and_only_from_named_origins(shared_world) -> None:
    hub = shared_world.hub
    token = await token_of(hub, "operator")
    path = "/clients/rosbridge/agv"
    await open_protocol(hub, "rosbridge", "https://tools.example")
    cookie = {"Cookie": await hub.cookie("admin")}
    tried = [
        await status_of(hub, path),
        await status_of(hub, f"{path}?token=tal_{'x' * 43}"),
        await status_of(hub, path, cookie),
        await status_of(hub, f"{path}?token={token}", {"Origin": "https://evil.test"}),
        await status_of(hub, f"{path}?token={token}", {"Origin": "null"}),
        await status_of(hub, f"{path}?token={token}", {"Origin": "https://tools.example"}),
        await status_of(hub, path, {"Authorization": f"Bearer {token}"}),
    ]
    assert tried == [401, 401, 401, 403, 403, 101, 101]
    await open_protocol(hub, "rosbridge", is_open=False)
    assert await status_of(hub, f"{path}?token={token}") == 403


async def test_cbor_raw_is_the_serialized_message_with_its_time(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    client = await raw_client(shared_world, "operator")
    await client.say(
        "subscribe", topic="talaia/base/open", type="std_msgs/Float64", compression="cbor-raw"
    )
    await client.call("/rosapi/get_time")
    await gateway.samples(("base/open", NOW + 60, 4.5))
    expected = struct.pack("<Id", 0x100, 4.5)
    frame = await client.hear("binary", lambda frame: expected in frame)
    assert cbor2.loads(frame) == {
        "op": "publish",
        "topic": "talaia/base/open",
        "msg": {"secs": NOW // 10**6, "nsecs": 60_000, "bytes": expected},
    }
    await client.close()


TWIST = {"linear": {"x": 0.9, "y": 0, "z": 0}, "angular": {"x": 0, "y": 0, "z": 0.2}}


async def test_published_velocity_is_refused_until_an_admin_permits_it(shared_world) -> None:
    hub, gateway = shared_world.hub, shared_world.gateways["agv"]
    async with await roslibpy_client(shared_world, "driver") as client:
        raw = await raw_client(shared_world, "driver")
        await raw.say("publish", topic="/v", msg=TWIST)
        assert "an admin may let your account" in (await raw.hear("status"))["msg"]
        await raw.close()
        admin = await shared_world.admin()
        person = (await hub.people.find_by_name("driver")).id
        asked = {"person": str(person), "site": "agv", "device": "base", "allowed": True}
        assert (await admin.put("/api/client-drivers", json=asked)).status_code == 204

        async def keep_driving() -> None:
            while True:
                await client.say("publish", "/v", "geometry_msgs/Twist", TWIST)
                await asyncio.sleep(0.05)

        # Again and again, as such programs do: the first may come while the link is just lost.
        driving = asyncio.create_task(keep_driving())
        lease = await gateway.hear(frames.LeaseRequest)
        assert (lease.op, lease.who) == (LeaseOp.TAKE, "driver")
        await gateway.say(
            frames.LeaseState(
                device="base", session=lease.session, who="driver", epoch=9, remains_ms=3000
            )
        )
        await gateway.say(frames.ControlTick(tick=42))
        moved = await gateway.hear(frames.DriveFrame, lambda frame: frame.linear > 0)
        driving.cancel()
        # Half of the description's 1 m/s.
        assert (moved.linear, moved.angular) == (0.5, 0.2)
        zero = await gateway.hear(frames.DriveFrame, lambda frame: frame.linear == 0)
        assert zero.seq > moved.seq
        await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.FREE)
        asked["allowed"] = False
        assert (await admin.put("/api/client-drivers", json=asked)).status_code == 204


async def test_stop_is_a_service_for_whoever_may_look(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    client = await raw_client(shared_world, "driver")
    await client.say("call_service", service="/talaia/base/drive/stop", id="s")
    stop = await gateway.hear(frames.StopRequest)
    await gateway.say(frames.StopState(device="base", latched=True, who="driver", id=stop.id))
    assert (await client.hear("service_response"))["result"] is True
    await client.close()


async def test_nonsense_is_named_and_giant_messages_end_the_connection(shared_world) -> None:
    client = await raw_client(shared_world, "operator")
    for text, about in (("{", "no JSON"), ('{"op":"brew"}', "brew"), ("[]", "unknown operation")):
        await client.socket.send(text)
        assert about in (await client.hear("status"))["msg"]
    await client.socket.send(b"\x00")
    await client.hear("status")
    await client.say("advertise_service", service="/mine", type="a/B")
    await client.hear("status")
    await client.say("subscribe", topic="/talaia/base/open", type="std_msgs/String")
    assert "is of the type" in (await client.hear("status"))["msg"]
    await client.socket.send(" " * (1024 * 1024 + 1))
    assert await client.hear("closed") == 1009


async def test_call_is_answered_within_the_time_that_its_client_gives_it(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    client = await raw_client(shared_world, "operator")
    # What is no time gives all the time there is.
    answers = {}
    for timeout in (0, -1, None, 0.05):
        await client.say(
            "call_service", service="/talaia/base/turn", id=f"t{timeout}", timeout=timeout
        )
        answers[timeout] = await gateway.hear(frames.CommandRequest)
    late = await client.hear("service_response")
    assert (late["id"], late["result"]) == ("t0.05", False)
    assert "no answer within 0.05 s" in late["values"]
    # What comes of it afterwards is no second answer.
    for timeout in (0.05, 0, -1, None):
        await end_command(gateway, answers[timeout], CommandPhase.SUCCEEDED, "ok")
    for timeout in (0, -1, None):
        said = await client.hear("service_response")
        assert (said["id"], said["result"]) == (f"t{timeout}", True)
    await client.close()


async def test_fragments_that_never_end_end_the_connection(shared_world) -> None:
    client = await raw_client(shared_world, "operator")
    for number in range(3):
        await client.say("fragment", id="endless", data="x" * 500_000, num=number, total=1_000_000)
    assert await client.hear("closed") == 1009


async def test_fragmented_call_is_answered_in_fragments_that_make_the_answer(shared_world) -> None:
    client = await raw_client(shared_world, "operator")
    call = json.dumps(
        {"op": "call_service", "service": "/rosapi/topics", "id": "f", "fragment_size": 256}
    )
    for number, data in enumerate((call[:20], call[20:])):
        await client.say("fragment", id="call", data=data, num=number, total=2)
    first = await client.hear("fragment", lambda said: said["num"] == 0)
    parts = [first["data"]]
    for number in range(1, first["total"]):
        said = await client.hear("fragment", lambda said, number=number: said["num"] == number)
        parts.append(said["data"])
    assert set(json.loads("".join(parts))["values"]["topics"]) == SEEN["operator"]
    await client.close()


async def test_thousand_subscriptions_with_throttle_leave_one_at_the_hub(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    client = await raw_client(shared_world, "operator")
    for turn in range(1000):
        await client.say(
            "subscribe",
            topic="/talaia/base/shut",
            id=f"s{turn}",
            type="std_msgs/Float64",
            throttle_rate=0,
        )
    for turn in range(999):
        await client.say("unsubscribe", topic="/talaia/base/shut", id=f"s{turn}")
    await client.call("/rosapi/get_time")
    await gateway.samples(("base/shut", NOW + 3, 41.5))
    await client.hear("publish", lambda said: said["msg"]["data"] == 41.5)
    (browser,) = [
        browser for browser in shared_world.hub.hub.core.browsers if browser.form == "object"
    ]
    assert shared_world.hub.hub.core.fanout.held(browser) == (1, 1)
    for turn in range(2100):
        await client.say("subscribe", topic=f"/n{turn}", type="a/B")
    assert "at most" in (await client.hear("status"))["msg"]
    await client.close()


async def test_throttled_topic_ends_with_its_newest_value(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    client = await raw_client(shared_world, "operator")
    await client.say(
        "subscribe", topic="/talaia/base/shut", type="std_msgs/Float64", throttle_rate=200
    )
    await client.call("/rosapi/get_time")
    await gateway.samples(*(("base/shut", NOW + 100 + at, 1000.0 + at) for at in range(50)))
    await client.hear("publish", lambda said: said["msg"]["data"] == 1049.0)
    assert len([frame for frame in client.frames if '"publish"' in frame]) < 10
    await client.close()


async def test_client_that_does_not_read_costs_a_bounded_outbox_and_delays_nobody(
    shared_world,
) -> None:
    gateway = shared_world.gateways["agv"]
    slow = await raw_client(shared_world, "operator", max_queue=1)
    await slow.say("subscribe", topic="/talaia/base/words", type="std_msgs/String")
    await slow.call("/rosapi/get_time")
    slow._reading.cancel()
    quick = await raw_client(shared_world, "operator")
    await quick.say("subscribe", topic="/talaia/base/words", type="std_msgs/String")
    await quick.call("/rosapi/get_time")
    for turn in range(40):
        text = f"{turn} " + "x" * 400
        rows = [("base/words", NOW + 10 + turn * 1000 + at, text) for at in range(1000)]
        await gateway.samples(*rows)
        async with asyncio.timeout(PATIENCE_S):
            await quick.hear(
                "publish", lambda said, turn=turn: said["msg"]["data"].startswith(f"{turn} ")
            )
    waiting = [
        browser.waiting
        for browser in shared_world.hub.hub.core.browsers
        if browser.form == "object"
    ]
    assert max(waiting) < 8 * 1024 * 1024
    await quick.close()
    slow.socket.transport.abort()
