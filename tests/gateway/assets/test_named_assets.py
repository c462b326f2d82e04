"""What a description names, what its meshes name, and that nothing else may be handed out."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st
from rosbags.typesys import Stores, get_typestore

from talaia.gateway.assets.named_assets import (
    CompanionScanner,
    NamedAssets,
    find_named,
    is_description,
)
from talaia.wire.asset_uris import AssetUri, parse_asset_uri

URDF = """<robot name="arm"><link name="hand"><visual><geometry>
<mesh filename="package://arm/meshes/hand.dae" scale="1 1 1"/></geometry></visual>
<collision><geometry><mesh scale='1 1 1' filename = 'package://arm/meshes/h%20and.stl'/></geometry>
</collision></link><!-- filename="https://elsewhere.example/a.stl" -->
<material name="m"><texture filename="file:///opt/robot/a&amp;b.png"/></material></robot>"""
NAMED = {
    AssetUri("arm", ("meshes", "hand.dae")),
    AssetUri("arm", ("meshes", "h and.stl")),
    AssetUri("", ("opt", "robot", "a&b.png")),
}
HAND = AssetUri("arm", ("meshes", "hand.dae"))
COLLADA = b"""<library_images><image><init_from>paint.png</init_from></image>
<image><init_from>../paint/Skin%20Tone.JPG</init_from></image>
<image><init_from>../../../etc/shadow.png</init_from></image>
<image><init_from>package://leg/foot.png</init_from></image></library_images>
<p>0.1 0.2.png.3 12.5</p>"""


def found_in(mesh: AssetUri, data: bytes, block: int = 64 * 1024) -> frozenset[AssetUri]:
    scanner = CompanionScanner(mesh)
    for at in range(0, len(data), block):
        scanner.scan_block(data[at : at + block])
    return scanner.names()


def test_files_that_a_description_names_are_found_in_both_serializations() -> None:
    for kind in (Stores.ROS2_HUMBLE, Stores.ROS1_NOETIC):
        store = get_typestore(kind)
        write = "serialize_ros1" if kind is Stores.ROS1_NOETIC else "serialize_cdr"
        message = store.types["std_msgs/msg/String"](data=URDF)
        raw = bytes(getattr(store, write)(message, "std_msgs/msg/String"))
        assert find_named(raw) == NAMED


def test_only_a_text_that_is_called_so_is_a_description() -> None:
    assert is_description("/arm/robot_description", "std_msgs/msg/String")
    assert is_description("/robot_description", "std_msgs/String")
    for topic, kind in (
        ("/my_robot_description", "std_msgs/msg/String"),
        ("/robot_description", "sensor_msgs/msg/Image"),
        ("/robot_description/other", "std_msgs/msg/String"),
    ):
        assert not is_description(topic, kind)


@pytest.mark.parametrize("block", [1, 7, 64, 64 * 1024])
def test_mesh_names_pictures_of_its_own_package_alone(block) -> None:
    assert found_in(HAND, COLLADA, block) == {
        AssetUri("arm", ("meshes", "paint.png")),
        AssetUri("arm", ("paint", "Skin Tone.JPG")),
        # Above the package's folder there is nothing: it begins there again.
        AssetUri("arm", ("etc", "shadow.png")),
    }


def test_kinds_that_name_no_other_file_are_not_looked_through() -> None:
    assert not found_in(AssetUri("arm", ("a.stl",)), COLLADA)


def test_materials_of_a_mesh_name_pictures_in_their_turn() -> None:
    named = NamedAssets()
    mesh, material, picture = (AssetUri("arm", (name,)) for name in ("a.obj", "a.mtl", "a.png"))
    named.replace_named("/robot_description", frozenset({mesh}))
    assert (named.allows(mesh), named.allows(material)) == (True, False)
    named.add_companions(mesh, found_in(mesh, b"mtllib a.mtl\nv 0 0 0\n"))
    named.add_companions(material, found_in(material, b"newmtl m\nmap_Kd a.png\n"))
    assert named.allows(material)
    assert named.allows(picture)
    # Another description: with the mesh goes what belonged to it.
    named.replace_named("/robot_description", frozenset({HAND}))
    assert not any(map(named.allows, (mesh, material, picture)))


def test_two_robots_of_a_site_name_files_each() -> None:
    named = NamedAssets()
    other = AssetUri("leg", ("foot.stl",))
    named.replace_named("/left/robot_description", frozenset({HAND}))
    named.replace_named("/right/robot_description", frozenset({other}))
    assert named.allows(HAND)
    assert named.allows(other)


@given(st.binary(max_size=3000), st.integers(1, 100))
def test_no_text_is_too_strange_to_be_looked_through(data, block) -> None:
    find_named(data)
    for name in found_in(HAND, data, block):
        assert name.package == "arm"
        assert ".." not in name.parts


def test_long_line_without_a_space_takes_no_time() -> None:
    text = b"a" * 2_000_000
    assert not found_in(AssetUri("arm", ("a.gltf",)), text + b".png"[:3])
    assert len(found_in(AssetUri("arm", ("a.gltf",)), b'"' + text + b'"b.bin"')) == 1


def test_names_of_one_description_are_bounded() -> None:
    many = "".join(f'<mesh filename="package://arm/{number}.stl"/>' for number in range(5_000))
    assert len(find_named(many.encode())) == 2_000
    assert parse_asset_uri("package://arm/0.stl") in find_named(many.encode())
