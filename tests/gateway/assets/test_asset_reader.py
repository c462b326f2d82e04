"""Files of packages: read, and nothing beside them, whatever is named and wherever links lead."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from talaia.gateway.assets.asset_reader import AssetReader
from talaia.gateway.assets.package_index import PackageIndex
from talaia.gateway.errors import AssetUnavailable
from talaia.wire.asset_uris import AssetUri, parse_asset_uri
from talaia.wire.frames import MAX_ASSET

from .package_folders import make_ament_package

HAND = AssetUri("arm", ("meshes", "hand.stl"))
MESH = b"solid hand\nendsolid hand\n"
SECRET = b"secret"


@pytest.fixture
def world(tmp_path):
    """A package among what is nobody's matter."""
    share = make_ament_package(
        tmp_path / "prefix", "arm", {"meshes/hand.stl": MESH, "config/keys.pem": SECRET}
    )
    make_ament_package(tmp_path / "prefix", "leg", {"foot.stl": SECRET})
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "far.stl").write_bytes(SECRET)
    (share / "meshes" / "link.stl").symlink_to(tmp_path / "outside" / "far.stl")
    (share / "meshes" / "key.stl").symlink_to(share / "config" / "keys.pem")
    (share / "linked").symlink_to(tmp_path / "outside")
    (share / "other").symlink_to(tmp_path / "prefix" / "share" / "leg")
    (share / "round.stl").symlink_to(share / "round.stl")
    (share / "folder.stl").mkdir()
    os.mkfifo(share / "pipe.stl")
    return share


def reader_of(tmp_path, beside: Path | None = None) -> AssetReader:
    return AssetReader(PackageIndex([tmp_path / "prefix"]), beside)


def test_mesh_is_told_of_by_its_content_and_read(world, tmp_path) -> None:
    reader = reader_of(tmp_path)
    found = reader.examine(HAND)
    assert (found.size, found.digest) == (len(MESH), hashlib.sha256(MESH).hexdigest())
    assert reader.read_whole(HAND) == MESH
    (world / "meshes" / "hand.stl").write_bytes(MESH * 2)
    assert reader.examine(HAND).digest == hashlib.sha256(MESH * 2).hexdigest()


REFUSED = [
    "package://arm/meshes/none.stl",
    "package://arm/config/keys.pem",
    "package://arm/meshes/link.stl",
    "package://arm/meshes/key.stl",
    "package://arm/linked/far.stl",
    "package://arm/other/foot.stl",
    "package://arm/round.stl",
    "package://arm/folder.stl",
    "package://arm/pipe.stl",
    "package://arm/meshes/hand.stl/x.stl",
    "package://none/hand.stl",
    "package://ament_index/resource_index/packages/arm.stl",
    "file:///dev/zero.stl",
    "package://arm/" + "a" * 300 + ".stl",
]


@pytest.mark.parametrize("uri", REFUSED)
def test_what_is_no_mesh_of_the_package_is_refused(world, tmp_path, uri) -> None:
    name = parse_asset_uri(uri)
    assert name is not None
    reader = reader_of(tmp_path)
    for read in (reader.examine, reader.read_whole):
        with pytest.raises((AssetUnavailable, OSError)):
            read(name)


def test_file_by_its_place_is_read_only_within_a_package(world, tmp_path) -> None:
    reader = reader_of(tmp_path)
    inside = parse_asset_uri((world / "meshes" / "hand.stl").as_uri())
    outside = parse_asset_uri((tmp_path / "outside" / "far.stl").as_uri())
    assert reader.read_whole(inside) == MESH
    with pytest.raises(AssetUnavailable, match="--meshes-from"):
        reader.examine(outside)


def test_links_of_a_workspace_are_followed_only_where_the_gateway_is_told_so(
    world, tmp_path
) -> None:
    link = parse_asset_uri("package://arm/meshes/link.stl")
    with pytest.raises(AssetUnavailable, match="--meshes-from"):
        reader_of(tmp_path).examine(link)
    told = reader_of(tmp_path, beside=tmp_path / "outside")
    assert told.read_whole(link) == SECRET
    with pytest.raises(AssetUnavailable):
        told.examine(parse_asset_uri("package://arm/other/foot.stl"))


def test_file_that_is_too_large_is_refused_without_being_read(world, tmp_path) -> None:
    with (world / "meshes" / "hand.stl").open("r+b") as file:
        file.truncate(MAX_ASSET + 1)
    with pytest.raises(AssetUnavailable, match="over"):
        reader_of(tmp_path).examine(HAND)
    with pytest.raises(AssetUnavailable, match="over"):
        reader_of(tmp_path).read_whole(HAND)


NAMES = (
    "meshes hand.stl link.stl key.stl linked far.stl other foot.stl config keys.pem outside prefix "
    "share arm leg .. %2e%2e . %2F / "
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.sampled_from(["package://arm/", "package://", "file:///"]),
    st.lists(st.sampled_from(NAMES.split(" ")), max_size=6),
)
def test_nothing_secret_is_read_by_any_name(world, tmp_path, begin, parts) -> None:
    name = parse_asset_uri(begin + "/".join(parts))
    if name is None:
        return
    try:
        data = reader_of(tmp_path).read_whole(name)
    except (AssetUnavailable, OSError):
        return
    # Of another package only by that package's own name.
    assert data == MESH or name == AssetUri("leg", ("foot.stl",))
