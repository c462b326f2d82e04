"""The robot's own services, topics and actions, for npm's @foxglove/ws-protocol and raw frames."""

from __future__ import annotations

import json
import struct

import pytest

from talaia.wire.frames import CommandPhase

from ..robot_commands import (
    ADD,
    SERVICES,
    TOPICS,
    answer,
    asked_of,
    begin_site,
    commands_sent,
)
from .foxglove_peer import NodeClient, client_of, services_of


@pytest.mark.parametrize("name", SERVICES)
async def test_npm_client_is_offered_by_the_robots_names_what_its_person_may_call(
    world, name
) -> None:
    await begin_site(world)
    async with await client_of(world, name, kind=NodeClient) as client:
        await client.call("subscribeConnectionGraph")
        graph = await client.hear("connectionGraphUpdate")
        served = {service["name"] for service in graph["advertisedServices"]}
        ours = {name for name in served if name.startswith(("/base/", "/power/"))}
        assert served - ours == SERVICES[name]
        heard = {topic["name"] for topic in graph["subscribedTopics"]}
        assert heard - {"/cmd_vel", "/base/drive"} == TOPICS[name]


async def test_npm_client_calls_and_publishes_by_the_robots_names(world) -> None:
    gateway = await begin_site(world)
    async with await client_of(world, "driver", kind=NodeClient) as client:
        said = await client.hear("advertiseServices")
        described = {service["name"]: service for service in said}
        assert described["/add_two_ints"]["type"] == ADD
        schema = json.loads(described["/add_two_ints"]["request"]["schema"])
        assert {name: of["type"] for name, of in schema["properties"].items()} == {
            "a": "integer",
            "b": "integer",
        }
        call = {"serviceId": described["/add_two_ints"]["id"], "callId": 5, "encoding": "json"}
        await client.call("sendServiceCallRequest", {**call, "data": '{"a": 3, "b": 4}'})
        asked, said = await asked_of(gateway)
        assert said == ("driver", "base", "add", {"a": 3, "b": 4})
        await answer(gateway, asked)
        response = await client.hear("serviceCallResponse")
        assert json.loads(response["data"]) == {"success": True, "message": "done"}
        await client.call("sendServiceCallRequest", {**call, "callId": 6, "data": '{"a": 3}'})
        failed = await client.hear("serviceCallFailure")
        assert (failed["callId"], failed["message"]) == (6, "base/add: the field b is missing")

        channel = {"topic": "/horn", "encoding": "json", "schemaName": "std_msgs/msg/String"}
        number = await client.call("advertise", channel)
        await client.call("sendMessage", number, 'bytes:{"data": "loud"}')
        asked, said = await asked_of(gateway)
        assert said == ("driver", "base", "horn", {"words": "loud"})
        await answer(gateway, asked, CommandPhase.REFUSED, "it rains")
        status = await client.hear("status", lambda said: "/horn" in said["message"])
        assert status["message"] == "/horn: refused: it rains"


async def test_message_in_cdr_is_read_by_its_type(world) -> None:
    gateway = await begin_site(world)
    client = await client_of(world, "driver")
    channels = [
        {
            "id": 1,
            "topic": "/goal_pose",
            "encoding": "cdr",
            "schemaName": "geometry_msgs/PoseStamped",
        }
    ]
    await client.say({"op": "advertise", "channels": channels})
    pose = struct.pack("<7d", 2.5, -1.0, 0, 0, 0, 0, 1)
    head = b"\x00\x01\x00\x00" + struct.pack("<iII4s", 7, 8, 4, b"map\0")
    await client.say(struct.pack("<BI", 1, 1) + head + pose)
    _, said = await asked_of(gateway)
    assert said == ("driver", "base", "goal", {"x": 2.5, "y": -1.0})
    await client.say(struct.pack("<BI", 1, 1) + b"\x00\x01\x00\x00")
    why = "not a geometry_msgs/msg/PoseStamped"
    await client.hear("status", lambda said: why in said["message"])
    await client.close()
    assert not await commands_sent(world, gateway)


async def test_guest_calls_and_publishes_nothing_of_the_robots(world) -> None:
    gateway = await begin_site(world)
    client = await client_of(world, "guest")
    await client.hear("advertise")
    for number in range(1, 30):
        await client.call(number, number, b'{"a": 1, "b": 2}')
    for number, topic in enumerate(("/horn", "/goal_pose")):
        channel = {"id": number, "topic": topic, "encoding": "json"}
        await client.say({"op": "advertise", "channels": [channel]})
        await client.say(struct.pack("<BI", 1, number) + b'{"data": "a"}')
    await client.hear("serviceCallFailure", lambda said: said["callId"] == 29)
    await client.hear(
        "status", lambda said: "nothing here listens to /goal_pose" in said["message"]
    )
    await client.close()
    assert not await commands_sent(world, gateway)


async def test_name_of_ours_stays_what_it_was(world) -> None:
    await begin_site(world)
    client = await client_of(world, "admin")
    services = await services_of(client)
    assert {"/base/add", "/base/light", "/power/cut", "/base/drive/stop"} <= services.keys()
    await client.close()
