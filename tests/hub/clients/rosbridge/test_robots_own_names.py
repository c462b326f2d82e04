"""The robot's own services, topics and actions, for roslibpy and for a page with npm's roslib."""

from __future__ import annotations

import asyncio

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
from ..tokens import open_protocol, token_of
from .page_with_roslib import connected_page, serve_page
from .rosbridge_peer import RawClient, RoslibpyClient, address_of

PAGE = """
function call(name, serviceType, args) {
  const service = new ROSLIB.Service({ros, name, serviceType});
  return new Promise((good, bad) => service.callService(args, good, (why) => bad(Error(why))));
}
function publish(name, messageType, message) {
  new ROSLIB.Topic({ros, name, messageType}).publish(message);
}
function services() {
  return new Promise((good, bad) => ros.getServices(good, bad));
}
function details(type) {
  return new Promise((good, bad) => ros.getServiceRequestDetails(type, good, bad));
}
"""


async def roslibpy_client(world, name):
    await open_protocol(world.hub, "rosbridge")
    return await RoslibpyClient().connect(world.hub, "agv", await token_of(world.hub, name))


@pytest.mark.parametrize("name", SERVICES)
async def test_roslibpy_finds_by_the_robots_names_what_its_person_may_call(world, name) -> None:
    await begin_site(world)
    async with await roslibpy_client(world, name) as client:
        await client.say("get_services")
        found = await client.hear("found")
        ours = {service for service in found if service.startswith("/talaia/")}
        assert set(found) - ours == SERVICES[name]
        await client.say("get_topics")
        topics = {topic for topic in await client.hear("found") if "talaia" not in topic}
        assert topics - {"/cmd_vel"} == TOPICS[name]
        await client.say("get_service_type", "/add_two_ints")
        assert await client.hear("found") == (ADD if SERVICES[name] else "")


async def test_roslibpy_calls_publishes_and_sends_goals_by_the_robots_names(world) -> None:
    gateway = await begin_site(world)
    async with await roslibpy_client(world, "driver") as client:
        await client.say("call", "/add_two_ints", ADD, {"a": 3, "b": 4})
        asked, said = await asked_of(gateway)
        assert said == ("driver", "base", "add", {"a": 3, "b": 4})
        await answer(gateway, asked)
        assert await client.hear("called") == {"success": True, "message": "done"}

        await client.say("publish", "/horn", "std_msgs/String", {"data": "loud"})
        asked, said = await asked_of(gateway)
        assert said == ("driver", "base", "horn", {"words": "loud"})
        await answer(gateway, asked)

        await client.say("goal", "/count", "test_msgs/action/Fibonacci", {"order": 7})
        await client.hear("sent")
        asked, said = await asked_of(gateway)
        assert said == ("driver", "base", "count", {"order": 7})
        await answer(gateway, asked, CommandPhase.RUNNING, "half", progress=0.5)
        await client.hear("feedback", lambda found: found == {"progress": 0.5, "message": "half"})
        await answer(gateway, asked)
        found = await client.hear("result")
        assert (found["status"], found["values"]) == (4, {"success": True, "message": "done"})


async def test_page_of_the_robots_own_works_unchanged(chromium, world, tmp_path) -> None:
    gateway = await begin_site(world)
    with serve_page(tmp_path, PAGE) as origin:
        await open_protocol(world.hub, "rosbridge", origin)
        page = await connected_page(chromium, world, origin, "driver")
        assert set(SERVICES["driver"]) <= set(await page.evaluate("services()"))
        (found,) = (await page.evaluate(f"details('{ADD}')"))["typedefs"]
        assert (found["fieldnames"], found["fieldtypes"]) == (["a", "b"], ["int64", "int64"])
        words = ["/add_two_ints", "example_interfaces/AddTwoInts", {"a": 1, "b": 2}]
        called = asyncio.create_task(page.evaluate("(words) => call(...words)", words))
        asked, said = await asked_of(gateway)
        assert said == ("driver", "base", "add", {"a": 1, "b": 2})
        await answer(gateway, asked)
        assert await called == {"success": True, "message": "done"}
        pose = {
            "header": {"stamp": {"secs": 5, "nsecs": 6}, "frame_id": "map"},
            "pose": {"position": {"x": 2.5, "y": -1, "z": 0}, "orientation": {"w": 1}},
        }
        # What says nothing may be left out.
        pose["pose"]["orientation"] |= {"x": 0, "y": 0, "z": 0}
        words = ["/goal_pose", "geometry_msgs/PoseStamped", pose]
        await page.evaluate("(words) => publish(...words)", words)
        _, said = await asked_of(gateway)
        assert said == ("driver", "base", "goal", {"x": 2.5, "y": -1.0})
        # The guest has no such service, and nobody listens to it.
        guest = await connected_page(chromium, world, origin, "guest")
        for name in ("/add_two_ints", "/cut"):
            refused = f"call('{name}', '', {{}}).catch((why) => String(why))"
            assert f"there is no service {name}" in await guest.evaluate(refused)
        words = ["/horn", "std_msgs/String", {"data": "loud"}]
        await guest.evaluate("(words) => publish(...words)", words)
        # Answered after it.
        await guest.evaluate("services()")
    assert not await commands_sent(world, gateway)


async def test_what_no_command_makes_is_refused_in_words_and_moves_nothing(world) -> None:
    gateway = await begin_site(world)
    await open_protocol(world.hub, "rosbridge")
    token = await token_of(world.hub, "driver")
    client = await RawClient().connect(address_of(world.hub, "agv", token))
    for args, why in (
        ({"a": 1}, "the field b is missing"),
        ({"a": 1, "b": "2"}, "b: expected a whole number"),
        ({"a": 1, "b": 2, "c": 3}, "c cannot be set here"),
        ([1, 2], "not the fields of a message, by name"),
    ):
        found = await client.call("/add_two_ints", args)
        assert found["result"] is False
        assert why in found["values"], found
    found = await client.call("/light", {"data": False})
    assert "data can only be true here, not false" in found["values"]
    for topic, message, why in (
        ("/horn", {"data": 1}, "data: expected a text"),
        ("/goal_pose", {"pose": {}}, "header.frame_id can only be 'map'"),
        ("/cut", {}, "nothing here listens to /cut"),
    ):
        await client.say("publish", topic=topic, msg=message)
        await client.hear("status", lambda said, why=why: why in said["msg"])
    await client.say("advertise", topic="/horn", type="std_msgs/msg/Bool")
    await client.say("publish", topic="/horn", msg={"data": "a"})
    why = "/horn: it is of the type std_msgs/msg/String, not std_msgs/msg/Bool"
    await client.hear("status", lambda said: said["msg"] == why)
    await client.close()
    assert not await commands_sent(world, gateway)


async def test_nested_lists_are_refused_by_their_depth_and_the_client_goes_on(world) -> None:
    gateway = await begin_site(world)
    await open_protocol(world.hub, "rosbridge")
    token = await token_of(world.hub, "driver")
    client = await RawClient().connect(address_of(world.hub, "agv", token))
    # The decoder reads hundreds of levels; what compares them with a command's fields could not.
    for depth in (65, 300, 500, 900):
        nested = "[" * depth + "]" * depth
        said = f'{{"op":"call_service","id":"called","service":"/light","args":{{"a":{nested}}}}}'
        await client.socket.send(said)
        found = await client.hear("service_response", lambda said: said.get("id") == "called")
        assert "nested deeper than 64 levels" in found["values"]
    for message in (nested, "[" * 100_000):
        await client.socket.send(f'{{"op":"publish","topic":"/horn","msg":{{"data":{message}}}}}')
        await client.hear("status", lambda said: "nested" in said["msg"])
    assert (await client.call("/rosapi/topics"))["result"]
    await client.close()
    assert not await commands_sent(world, gateway)


async def test_published_message_that_the_gateway_refuses_is_told(world) -> None:
    gateway = await begin_site(world)
    async with await roslibpy_client(world, "driver") as client:
        await client.say("publish", "/horn", "std_msgs/String", {"data": "loud"})
        asked, _ = await asked_of(gateway)
        raw_token = await token_of(world.hub, "driver")
        raw = await RawClient().connect(address_of(world.hub, "agv", raw_token))
        await raw.say("publish", topic="/horn", msg={"data": "louder"})
        second, _ = await asked_of(gateway)
        await answer(gateway, asked)
        await answer(gateway, second, CommandPhase.REFUSED, "it rains")
        said = await raw.hear("status")
        assert said["msg"] == "/horn: refused: it rains"
        await raw.close()


async def test_messages_that_come_steadily_are_cut_to_a_few_commands_a_second(world) -> None:
    gateway = await begin_site(world)
    await open_protocol(world.hub, "rosbridge")
    token = await token_of(world.hub, "driver")
    client = await RawClient().connect(address_of(world.hub, "agv", token))
    for _ in range(300):
        await client.say("publish", topic="/horn", msg={"data": "a"})
    said = await client.hear("status")
    assert "at most 5 messages a second: each is a command" in said["msg"]
    # Answered after all of them.
    await client.call("/rosapi/topics")
    await client.close()
    assert len(await commands_sent(world, gateway)) < 300
