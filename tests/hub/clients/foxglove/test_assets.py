"""Meshes from the hub's folder: what npm's client is sent, and that nothing else is ever read."""

from __future__ import annotations

from dataclasses import replace

import pytest

from talaia.hub.clients.foxglove.asset_requests import AssetFolder, AssetRefused

from .foxglove_peer import NodeClient, client_of

MESH = b"solid base\nendsolid base\n"


@pytest.fixture
def assets(tmp_path):
    folder = tmp_path / "assets"
    (folder / "agv" / "base" / "my meshes").mkdir(parents=True)
    (folder / "moon" / "rover").mkdir(parents=True)
    (folder / "agv" / "base" / "my meshes" / "body.STL").write_bytes(MESH)
    (folder / "agv" / "base" / "keys.pem").write_text("secret")
    (folder / "agv" / "base" / ".hidden.stl").write_text("secret")
    (folder / "moon" / "rover" / "body.stl").write_text("secret")
    (folder / "out.stl").write_text("secret")
    (tmp_path / "far.stl").write_text("secret")
    (folder / "agv" / "base" / "link.stl").symlink_to(tmp_path / "far.stl")
    (folder / "agv" / "linked").symlink_to(folder / "moon" / "rover")
    return folder


@pytest.fixture
def settings(settings, assets):
    return replace(settings, assets=assets)


BODY = "package://base/my%20meshes/body.STL"
REFUSED = [
    "",
    "package://",
    "package://base",
    "package://base/",
    "package://base/none.stl",
    "package://base/keys.pem",
    "package://base/.hidden.stl",
    "package://base/link.stl",
    "package://linked/body.stl",
    "package://../moon/rover/body.stl",
    "package://base/../../out.stl",
    "package://base/..%2F..%2Fout.stl",
    "package://%2e%2e/out.stl",
    "package://base/my%20meshes/%2e%2e/%2e%2e/%2e%2e/out.stl",
    "package://base//body.stl",
    "package:///base/my%20meshes/body.STL",
    "package://base/..\\..\\out.stl",
    "package://base/body.stl\0",
    "package://C:/out.stl",
    "file:///etc/passwd",
    "http://127.0.0.1/body.stl",
]


@pytest.mark.parametrize("uri", REFUSED)
def test_what_is_no_file_of_the_site_is_refused(assets, uri) -> None:
    with pytest.raises(AssetRefused):
        AssetFolder(assets).read_file("agv", uri)


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


async def test_site_without_a_folder_has_no_assets(world) -> None:
    for site, offered in (("agv", True), ("moon", True), ("nowhere", False)):
        assert AssetFolder(world.hub.settings.assets).has_site(site) is offered
    client = await client_of(world, "guest")
    info = await client.hear("serverInfo")
    assert "assets" not in info["capabilities"]
    await client.close()


@pytest.mark.parametrize("site", ["..", ".", "", "agv/base", "none"])
def test_what_is_no_sites_name_leads_to_no_folder(assets, site) -> None:
    for uri in ("package://far.stl", "package://out.stl", "package://my%20meshes/body.STL"):
        with pytest.raises(AssetRefused):
            AssetFolder(assets).read_file(site, uri)
