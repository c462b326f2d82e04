"""A robot with meshes in a real Chromium: seen in its colours, and what is missing is said once."""

from __future__ import annotations

import io
import struct

import numpy as np
import pytest
from patience import until_answered
from playwright.async_api import expect

from ..chromium import sign_in
from ..mesh_gateway import MeshGateway

pytestmark = [pytest.mark.browser, pytest.mark.timeout(90)]

BODY, SKIN, NONE = (
    f"package://arm/{name}" for name in ("meshes/body.stl", "paint/skin.png", "none.stl")
)
PANEL = "package://arm/meshes/panel.dae"
RED = "1 0 0 1"
URDF = f"""<robot name="arm"><material name="red"><color rgba="{RED}"/></material>
<link name="base"><visual><geometry><mesh filename="{BODY}"/></geometry><material name="red"/>
</visual></link>
<link name="panel"><visual><geometry><mesh filename="{PANEL}"/></geometry></visual></link>
<link name="lost"><visual><geometry><mesh filename="{NONE}"/></geometry></visual></link>
<link name="lost2"><visual><geometry><mesh filename="{NONE}"/></geometry></visual></link>
<joint name="a" type="fixed"><parent link="base"/><child link="panel"/>
<origin xyz="0 0 1.2"/></joint>
<joint name="b" type="fixed"><parent link="base"/><child link="lost"/></joint>
<joint name="c" type="fixed"><parent link="base"/><child link="lost2"/></joint></robot>"""


def stl_box(size: float) -> bytes:
    """Write a cube on the floor as a binary STL."""
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (0, 2)]) * size / 2
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    rows = b""
    for a, b, c, d in faces:
        for three in ((a, b, c), (a, c, d)):
            at = corners[three[0]]
            normal = np.cross(corners[three[1]] - at, corners[three[2]] - at)
            normal = normal / np.linalg.norm(normal)
            rows += struct.pack("<12fH", *normal, *(v for one in three for v in corners[one]), 0)
    return bytes(80) + struct.pack("<I", len(rows) // 50) + rows


def collada_panel() -> bytes:
    """Write a level square that a picture in another folder of the package paints."""
    return b"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_images><image id="i"><init_from>../paint/skin.png</init_from></image></library_images>
<library_effects><effect id="e"><profile_COMMON>
<newparam sid="s"><surface type="2D"><init_from>i</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
<technique sid="c"><lambert><diffuse><texture texture="t" texcoord="UV"/></diffuse></lambert>
</technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">-1 -1 0 1 -1 0 1 1 0 -1 1 0</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<source id="n"><float_array id="na" count="3">0 0 1</float_array><technique_common>
<accessor source="#na" count="1" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<source id="u"><float_array id="ua" count="8">0 0 1 0 1 1 0 1</float_array><technique_common>
<accessor source="#ua" count="4" stride="2"><param name="S" type="float"/>
<param name="T" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="2" material="mm"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="NORMAL" source="#n" offset="1"/>
<input semantic="TEXCOORD" source="#u" offset="2" set="0"/>
<p>0 0 0 1 0 1 2 0 2 0 0 0 2 0 2 3 0 3</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node id="o"><instance_geometry url="#g">
<bind_material><technique_common><instance_material symbol="mm" target="#m">
<bind_vertex_input semantic="UV" input_semantic="TEXCOORD" input_set="0"/></instance_material>
</technique_common></bind_material></instance_geometry></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#w"/></scene></COLLADA>"""


def blue_picture() -> bytes:
    from PIL import Image

    file = io.BytesIO()
    Image.new("RGB", (8, 8), (20, 60, 230)).save(file, "png")
    return file.getvalue()


async def colour_share(page, colour: str) -> float:
    """Give the share of the scene's picture in which one of red, green and blue is by far most."""
    from PIL import Image

    data = await page.locator("t-scene canvas").screenshot()
    pixels = np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)
    at = ["red", "green", "blue"].index(colour)
    others = np.delete(pixels, at, axis=2).max(axis=2)
    return float((pixels[:, :, at] > others + 60).mean())


async def test_robot_is_drawn_by_meshes_and_pictures_that_only_its_gateway_has(space, hub) -> None:
    files = {BODY: stl_box(1.0), PANEL: collada_panel(), SKIN: blue_picture()}
    robot = MeshGateway(hub, files)
    await robot.open()
    page = await sign_in(space, hub, "operator", to="/sites/agv/scene")
    await robot.publish_model(URDF)
    await until_answered(lambda: is_seen(page, "red", 0.005))
    await until_answered(lambda: is_seen(page, "blue", 0.005))
    said = page.get_by_text(f"{NONE}: it is not there")
    await expect(said).to_have_count(1)
    assert sum(uri == BODY for uri, _ in robot.asked) == 2
    # Looked at again, nothing of it crosses the line again.
    pieces = robot.pieces
    await page.reload()
    await until_answered(lambda: is_seen(page, "blue", 0.005))
    assert robot.pieces == pieces
    await robot.close()


async def is_seen(page, colour: str, share: float) -> bool:
    return await page.locator("t-scene canvas").count() > 0 and (
        await colour_share(page, colour) > share
    )
