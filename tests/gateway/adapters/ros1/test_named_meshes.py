"""Meshes of a real ROS 1 robot: named by what rospy publishes, found by rospack's path."""

from __future__ import annotations

from pathlib import Path

import pytest
from gateway.assets.package_folders import make_ros1_package
from tapped_hub import newest_list, whole

from talaia.wire.frames import AssetRequest, AssetState, TapSubscription

from .test_taps import (  # noqa: F401 - fixtures
    TEXT,
    TappedRobot,
    bench,
    port,
    robot,
    ros1_home,
    schemas,
)

pytestmark = pytest.mark.robot

TOPIC, HAND, OTHER = "/robot_description", "package://arm/hand.stl", "package://arm/other.stl"
MESH = b"solid hand\n" * 20_000


async def test_mesh_that_the_description_names_goes_to_a_hub_that_asks(
    robot: TappedRobot,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    files = {"hand.stl": MESH, "other.stl": b"other"}
    make_ros1_package(tmp_path / "src", "robot/arm_description", "arm", files)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    await robot.ask("opened", "open", topic=TOPIC, latched=True)
    await robot.publish(TOPIC, f'<robot><mesh filename="{HAND}"/></robot>')
    async with bench(robot, tmp_path / "data") as hub:
        assert hub.hellos[-1].takes == ["asset_request"]
        await hub.until(lambda: TOPIC in newest_list(hub), "the topic in the list")
        await hub.send(TapSubscription(types=[TEXT]))
        await hub.until(lambda: schemas(hub), "the schema")
        await hub.send(TapSubscription(topics={TOPIC: 0}))
        await hub.until(lambda: whole(hub, TOPIC), "the description")
        await hub.send(AssetRequest(uri=OTHER))
        refused = await hub.next(AssetState, lambda said: said.uri == OTHER)
        assert "does not name it" in refused.problem
        await hub.send(AssetRequest(uri=HAND, fetch=True))
        told = await hub.next(AssetState, lambda said: said.uri == HAND)
        assert (told.size, told.problem) == (len(MESH), "")
        await hub.until(lambda: MESH in hub.files.values(), "the file")
        assert [offer.digest for offer in hub.offers] == [told.digest]
