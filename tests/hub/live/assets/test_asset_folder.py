"""The folder that the hub's owner fills: each site's own files, and nothing beside them."""

from __future__ import annotations

import pytest

from talaia.hub.errors import AssetRefused
from talaia.hub.live.assets.asset_folder import AssetFolder

MESH = b"solid base\nendsolid base\n"
BODY = "package://base/my%20meshes/body.STL"


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


def test_file_of_a_site_is_read(assets) -> None:
    assert AssetFolder(assets).read_file("agv", BODY) == MESH
    for site, has in (("agv", True), ("moon", True), ("nowhere", False)):
        assert AssetFolder(assets).has_site(site) is has
    assert not AssetFolder(None).has_site("agv")


@pytest.mark.parametrize("site", ["..", ".", "", "agv/base", "none"])
def test_what_is_no_sites_name_leads_to_no_folder(assets, site) -> None:
    for uri in ("package://far.stl", "package://out.stl", "package://my%20meshes/body.STL"):
        with pytest.raises(AssetRefused):
            AssetFolder(assets).read_file(site, uri)
