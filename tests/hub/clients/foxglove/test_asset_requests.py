"""Meshes from the hub's folder: what npm's client is sent, and that nothing else is ever read."""

from __future__ import annotations

from dataclasses import replace

import pytest

from .foxglove_peer import NodeClient, client_of

MESH = b"solid base\nendsolid base\n"


@pytest.fixture
def assets(tmp_path):
    folder = tmp_path / "assets"
    (folder / "agv" / "base" / "my meshes").mkdir(parents=True)
    (folder / "moon" / "rover").mkdir(parents=True)
    (folder / "agv" / "base" / "my meshes" / "body.STL").write_bytes(MESH)
    (folder / "moon" / "rover" / "body.stl").write_text("secret")
    return folder


@pytest.fixture
def settings(settings, assets):
    return replace(settings, assets=assets)


BODY = "package://base/my%20meshes/body.STL"


async def test_npm_client_gets_a_mesh_of_what_its_person_may_view_and_the_hubs_time(world) -> None:
    # What each gets: a guest sees a public signal, which is no right to view.
    for name, allowed in (("guest", False), ("driver", True), ("admin", True)):
        async with await client_of(world, name, kind=NodeClient) as client:
            now_s = world.hub.hub.core.clock.wall_ns() / 1e9
            told = await client.hear("time")
            assert abs(int(told["timestamp"]) / 1e9 - now_s) < 60
            await client.call("fetchAsset", BODY, 7)
            said = await client.hear("fetchAssetResponse")
            assert said["requestId"] == 7
            if allowed:
                assert said["data"].encode() == MESH
            else:
                assert said["error"] == "there is no such file"
            await client.call("fetchAsset", "package://../moon/rover/body.stl", 8)
            assert "error" in await client.hear("fetchAssetResponse")


async def test_who_may_view_nothing_is_offered_no_assets(world) -> None:
    client = await client_of(world, "guest")
    info = await client.hear("serverInfo")
    assert "assets" not in info["capabilities"]
    await client.close()
