"""What is seen of a robot of ROS 2 behind a rosbridge server, by the letter of its rosapi.

A robot of ROS 1 behind the real server is in `test_ros1_server`.
"""

from __future__ import annotations

import asyncio
import json
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING

import pytest
from websockets.asyncio.server import serve
from websockets.exceptions import ConnectionClosed

from talaia.cli.errors import CliError
from talaia.cli.probe import main
from talaia.gateway.adapters.rosbridge.probe import probe_bridge
from talaia.gateway.errors import AdapterLost
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.probe_report import FORMAT, Found

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

OVEN = "string state # of the oven\nfloat64 celsius\nfloat32[2] shelves\nuint8[] codes"
ANSWERS: dict[str, object] = {
    "/rosapi/topics": {
        "topics": ["/oven", "/camera/image_raw", "/set", "/rosout", "/client_count"],
        "types": [
            "oven_msgs/msg/Oven",
            "sensor_msgs/msg/Image",
            "std_msgs/msg/Float32",
            "rcl_interfaces/msg/Log",
            "std_msgs/msg/Int32",
        ],
    },
    "/rosapi/get_ros_version": {"version": 2, "distro": "jazzy"},
    "/rosapi/topics_and_raw_types": {
        "topics": ["/oven"],
        "types": ["oven_msgs/msg/Oven"],
        "typedefs_full_text": [OVEN],
    },
    "/rosapi/nodes": {"nodes": ["/kitchen", "/rosapi", "/rosbridge_websocket"]},
    "/rosapi/node_details /kitchen": {
        "publishing": ["/oven", "/camera/image_raw", "/rosout"],
        "subscribing": ["/set"],
        "services": ["/light"],
    },
    "/rosapi/node_details /rosapi": {
        "publishing": [],
        "subscribing": [],
        "services": ["/rosapi/topics"],
    },
    "/rosapi/node_details /rosbridge_websocket": {
        "publishing": ["/client_count", "/connected_clients"],
        "subscribing": ["/oven"],
        "services": [],
    },
    "/rosapi/services": {
        "services": ["/light", "/kitchen/get_parameters", "/rosapi/nodes", "/bake", "/gone"]
    },
    "/rosapi/service_type /light": {"type": "std_srvs/srv/SetBool"},
    "/rosapi/service_type /bake": {"type": "oven_msgs/srv/Bake"},
    "/rosapi/service_type /gone": {"type": ""},
    "/rosapi/service_type /kitchen/get_parameters": {"type": "rcl_interfaces/srv/GetParameters"},
    "/rosapi/service_request_details std_srvs/srv/SetBool": {
        "typedefs": [
            {
                "type": "std_srvs/SetBool_Request",
                "fieldnames": ["data"],
                "fieldtypes": ["boolean"],
                "fieldarraylen": [-1],
            }
        ]
    },
    "/rosapi/service_request_details oven_msgs/srv/Bake": {
        "typedefs": [
            {
                "type": "oven_msgs/Bake_Request",
                "fieldnames": ["at", "shelves", "recipe"],
                "fieldtypes": ["builtin_interfaces/Time", "int32", "oven_msgs/Recipe"],
                "fieldarraylen": [-1, 0, -1],
            },
            {
                "type": "oven_msgs/Recipe",
                "fieldnames": ["bread"],
                "fieldtypes": ["string"],
                "fieldarraylen": [-1],
            },
        ]
    },
    "/rosapi/action_servers": {"action_servers": ["/turn"]},
}


class Server:
    """Answers questions by ``ANSWERS``, and says a message to whoever subscribes."""

    def __init__(self, answers: dict[str, object]) -> None:  # noqa: D107
        self._answers = answers
        self.subscribed: list[dict] = []

    async def handle(self, client) -> None:
        with suppress(ConnectionClosed):
            async for data in client:
                said = json.loads(data)
                if said["op"] == "call_service":
                    await client.send(json.dumps(self.answer(said)))
                elif said["op"] == "subscribe":
                    self.subscribed.append(said)
                    message = {"state": "hot", "celsius": 187.5, "shelves": [1, 2], "codes": "AQID"}
                    published = {"op": "publish", "topic": said["topic"], "msg": message}
                    await client.send(json.dumps(published))

    def answer(self, said: dict) -> dict:
        key = " ".join([said["service"], *said["args"].values()])
        values = self._answers.get(key)
        good = values is not None
        if not good:
            values = f"Service {said['service']} does not exist"
        return {"op": "service_response", "id": said["id"], "values": values, "result": good}


@asynccontextmanager
async def server(answers: dict[str, object]) -> AsyncIterator[tuple[Server, str]]:
    one = Server(answers)
    async with serve(one.handle, "127.0.0.1", 0, compression=None) as listening:
        yield one, f"ws://127.0.0.1:{listening.sockets[0].getsockname()[1]}"


async def look(url: str, folder: Path) -> Found:
    asked = Found(FORMAT, protocol="rosbridge", where="", seconds=0.2, url=url)
    return await asyncio.to_thread(probe_bridge, asked, folder)


async def test_a_ros_2_robot_of_an_own_type_is_found_by_what_rosapi_tells(tmp_path: Path) -> None:
    async with server(ANSWERS) as (one, url):
        found = await look(url, tmp_path)
    assert found.ros == 2
    # Nobody hears a picture for a look, or what nobody publishes.
    assert [said["topic"] for said in one.subscribed] == ["/oven"]
    topics = {topic.topic: topic for topic in found.topics}
    assert list(topics) == ["/camera/image_raw", "/oven", "/set"]
    oven = topics["/oven"]
    assert (oven.publishers, oven.subscribers, oven.problem) == (1, 0, "")
    # Bytes come as base64, and count as the three that they are.
    assert [field.path for field in oven.fields] == [
        *("state", "celsius", "shelves[0]", "shelves[1]", "codes[0]", "codes[1]", "codes[2]")
    ]
    services = {service.service: service for service in found.services}
    assert set(services) == {"/light", "/bake", "/gone"}
    assert (services["/light"].problem, services["/gone"].problem) == ("", "it does not answer")
    assert [field.path for field in services["/bake"].fields] == ["recipe.bread"]
    assert services["/bake"].problem == "its request holds lists (shelves)"
    assert [action.problem for action in found.actions] == ["this rosapi tells no types of actions"]
    site = propose_description(found, "kitchen", "Kitchen", "UTC").site
    assert (site.connections["rosbridge"].url, site.connections["rosbridge"].ros) == (url, 2)
    commands = {
        command.target for device in site.devices.values() for command in device.commands.values()
    }
    # What listens is commanded by its topic, too.
    assert commands == {"/light", "/set"}


async def test_a_server_without_rosapi_is_told_with_what_to_start(tmp_path: Path) -> None:
    async with server({}) as (_, url):
        with pytest.raises(AdapterLost, match="Start rosapi beside it"):
            await look(url, tmp_path)
    with pytest.raises(AdapterLost, match="no rosbridge server answers"):
        await look(url, tmp_path)


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["--rosbridge", "http://robot:9090"], "expected ws://robot.local:9090"),
        (["--rosbridge", "ws://ana:secret@robot:9090"], "password"),
        (["--rosbridge", "robot", "--user", "ana"], "--user and --password-file are for"),
        (["--ros2", "--token-file", "x"], "are for --mqtt, --http and --rosbridge"),
    ],
)
def test_an_address_or_option_that_cannot_be_meant_is_refused(words, problem) -> None:
    with pytest.raises(CliError, match=problem):
        main(words)
