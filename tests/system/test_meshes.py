"""Meshes of a real robot: from the folders of its packages to who may see it, by real processes."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from patience import until_answered
from ports import free_port
from shared_trust import usual_trust

from ..gateway.assets.package_folders import make_ament_package, make_ros1_package
from ..hub.clients.foxglove.foxglove_peer import NodeClient
from .conftest import need_ros2
from .faults.proxy import Proxy
from .faults.weather import Way
from .stack import PASSWORD, SITE, finish
from .test_taps import DESCRIPTION, Taps, TapStack, channels_of, messages

pytestmark = [pytest.mark.robot, pytest.mark.asyncio(loop_scope="module")]

TOPIC = "/tap/robot_description"
# Large enough to be told from beats on the line.
MESH, OTHER = b"solid hand\n" * 40_000, b"solid foot\n" * 40_000
HAND, FOOT, SKIN = "package://arm/hand.dae", "package://leg/foot.stl", "package://arm/skin.png"
SHAPE = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
LINK = f'<link name="hand">{SHAPE.format(HAND)}{SHAPE.format(FOOT)}</link>'
URDF = f'<robot name="arm">{LINK}</robot>'


class MeshStack(TapStack):
    """Its gateway has a workspace of ROS 2 sourced, and the package path of ROS 1."""


class Meshes(Taps):
    """The stack with what the tests do with it."""

    def __init__(self, stack: MeshStack, line: Proxy, share: Path) -> None:  # noqa: D107
        super().__init__(stack, line)
        self.stack, self.share = stack, share
        self.address_of_hub = stack.address

    @contextlib.contextmanager
    def client(self) -> Iterator[httpx.Client]:
        headers = {"Origin": self.address_of_hub}
        with httpx.Client(
            base_url=self.address_of_hub, headers=headers, verify=usual_trust(), timeout=60
        ) as client:
            who = {"name": "boss", "password": PASSWORD}
            assert client.post("/api/login", json=who).status_code == 200
            yield client


def get(client: httpx.Client, uri: str) -> httpx.Response:
    return client.get(f"/api/sites/{SITE}/assets", params={"uri": uri})


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Meshes]:
    need_ros2()
    folder = tmp_path_factory.mktemp("meshes")
    files = {"hand.dae": b"<init_from>skin.png</init_from>" + MESH, "skin.png": b"skin"}
    share = make_ament_package(folder / "prefix", "arm", {**files, "secret.stl": b"secret"})
    make_ros1_package(folder / "src", "robot/leg_description", "leg", {"foot.stl": OTHER})
    MeshStack.chosen = free_port()
    MeshStack.more = {
        "AMENT_PREFIX_PATH": str(folder / "prefix"),
        "ROS_PACKAGE_PATH": str(folder / "src"),
    }
    line = Proxy(MeshStack.chosen)
    (folder / "stack").mkdir()
    stack = MeshStack(folder / "stack", DESCRIPTION, people={"boss": "admin"}, link_port=line.port)
    try:
        finish(stack.ready())
        yield Meshes(stack, line, share)
    finally:
        stack.close()
        line.close()


async def test_meshes_that_the_description_names_come_once_and_nothing_else_does(
    meshes: Meshes,
) -> None:
    robot = meshes.robot
    robot.open(TOPIC, latched=True)
    await robot.publish(TOPIC, URDF)
    with meshes.client() as client:
        # Nobody has heard the description yet: nothing is named.
        assert "does not name it" in get(client, HAND).json()["message"]
        async with NodeClient() as foxglove:
            await foxglove.connect(meshes.address("view"), coding="hex")
            channel = (await channels_of(foxglove, TOPIC))[TOPIC]
            subscription = await foxglove.call("subscribe", channel["id"])
            await messages(foxglove, subscription, 1)
            before = meshes.line.passed[Way.UP]
            answer = get(client, HAND)
            assert answer.status_code == 200, answer.text
            assert answer.content == (meshes.share / "hand.dae").read_bytes()
            assert get(client, FOOT).content == OTHER
            assert get(client, SKIN).content == b"skin"
            sent = meshes.line.passed[Way.UP] - before
            assert len(MESH) + len(OTHER) < sent < 1.2 * (len(MESH) + len(OTHER))
            # Foxglove's own client and another look at the page: from the hub's copy.
            await foxglove.call("fetchAsset", FOOT, 7)
            said = await foxglove.hear("fetchAssetResponse")
            assert bytes.fromhex(said["data"]) == OTHER
            assert get(client, HAND).content == answer.content
            assert meshes.line.passed[Way.UP] - before - sent < len(MESH) / 4
            for uri in ("package://arm/secret.stl", "package://arm/../arm/secret.stl"):
                refused = get(client, uri)
                assert refused.status_code == 404
                assert refused.content != b"secret"
            # The robot is built anew, and says its description anew.
            (meshes.share / "hand.dae").write_bytes(MESH[::-1])
            await robot.publish(TOPIC, URDF)

            async def is_new() -> bool:
                return get(client, HAND).content == MESH[::-1]

            await until_answered(is_new)


async def test_model_is_drawn_while_the_robot_is_away_and_after_both_began_anew(
    meshes: Meshes,
) -> None:
    with meshes.client() as client:
        known = get(client, FOOT)
        assert known.content == OTHER
        meshes.stack.gateway.kill()

        async def is_away() -> bool:
            return client.get("/api/sites").json()[0]["online"] is False

        await until_answered(is_away)
        assert get(client, FOOT).content == OTHER
    meshes.stack.hub.kill()
    meshes.stack.start_hub()
    await meshes.stack.hub.says("ready")
    with meshes.client() as client:
        assert get(client, FOOT).content == OTHER
