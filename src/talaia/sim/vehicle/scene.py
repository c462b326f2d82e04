"""Puts shapes into a MuJoCo model: what stops a vehicle, and what a camera sees.

The two are kept apart. *Hulls* are plain boxes and cylinders: they collide and the lidar sees
them; every world has them. *Looks* are meshes with textures: only a world with a camera has them,
so that the same physics runs with and without pictures, and fast.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from talaia.sim.vehicle.mesh import rounded_box

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.sim.vehicle.textures import Picture

__all__ = ["HULL_GROUP", "LOOK_GROUP", "Finish", "FloorPose", "Hull", "SceneBuilder"]

LOOK_GROUP = 2
HULL_GROUP = 3

Vector = tuple[float, float, float]
Colour = tuple[float, float, float]
Model = Any
"""MuJoCo ships no types."""


@dataclass(frozen=True)
class Hull:
    """Something solid: a box of ``half`` sizes, or a cylinder (radius, radius, half height)."""

    round: bool
    centre: Vector
    half: Vector
    yaw: float


@dataclass(frozen=True)
class Finish:
    """How a surface looks.

    Attributes:
        picture: makes the texture, or None for a plain colour.
        colour: multiplies the texture, 0..1.
        repeat: how often the texture repeats in a metre; 0 stretches it once over each side.
        cube: the picture is six squares below each other, for round shapes.
        shine: specular strength, 0..1.
        glow: light of its own, 0..1.

    """

    picture: Callable[[np.random.Generator], Picture] | None = None
    colour: Colour = (1.0, 1.0, 1.0)
    repeat: float = 1.0
    cube: bool = False
    shine: float = 0.05
    glow: float = 0.0


class SceneBuilder:
    """The model under construction.

    Args:
        spec: the MuJoCo model to add to.
        rng: where textures take their noise from.
        finishes: surfaces by name.
        looks: whether to add what only a camera sees.

    """

    def __init__(
        self,
        spec: Model,
        rng: np.random.Generator,
        finishes: dict[str, Finish],
        *,
        looks: bool,
    ) -> None:
        """Start with nothing in it."""
        self.spec = spec
        self.rng = rng
        self.looks = looks
        # Read by the floors as well, which are darker around them.
        self.hulls: list[Hull] = []
        # A copy: walls and floors add their own.
        self._finishes = dict(finishes)
        # Those that are in the model already.
        self._materials: set[str] = set()
        # By size, rounding and repetition: equal boxes share one mesh.
        self._meshes: dict[tuple[float, ...], str] = {}

    def pose_at(self, x: float, y: float, yaw: float = 0.0) -> FloorPose:
        """Give a place on the floor to build at."""
        return FloorPose(self, x, y, yaw)

    def add_finish(self, name: str, finish: Finish) -> str:
        """Add a surface and give its name back."""
        self._finishes[name] = finish
        return name

    def add_hull(self, hull: Hull) -> None:
        """Add something solid."""
        self.hulls.append(hull)
        kind = mujoco.mjtGeom.mjGEOM_CYLINDER if hull.round else mujoco.mjtGeom.mjGEOM_BOX
        self.spec.worldbody.add_geom(
            type=kind,
            pos=hull.centre,
            size=(hull.half[0], hull.half[2], 0.0) if hull.round else hull.half,
            quat=_yaw_quaternion(hull.yaw),
            group=HULL_GROUP,
            # With the vehicle's 1 and 2 these meet it, and never each other.
            contype=2,
            conaffinity=1,
            friction=(0.2, 0.0, 0.0),
        )

    def box_mesh(self, size: Vector, radius: float, repeat: float) -> str:
        """Give the name of a box mesh with rounded edges, made once for each size."""
        key = (*size, radius, repeat)
        name = self._meshes.get(key)
        if name is None:
            name = f"mesh{len(self._meshes)}"
            self._meshes[key] = name
            vertices, normals, uv, faces = rounded_box(size, radius, repeat)
            mesh = self.spec.add_mesh(name=name)
            mesh.uservert = vertices.ravel()
            mesh.usernormal = normals.ravel()
            mesh.usertexcoord = uv.ravel()
            mesh.userface = faces.ravel()
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        return name

    def add_visual(self, finish: str, **geom: Model) -> None:
        """Add something only a camera sees."""
        if self.looks:
            self.spec.worldbody.add_geom(
                material=self.find_material(finish),
                group=LOOK_GROUP,
                contype=0,
                conaffinity=0,
                **geom,
            )

    def texture_repeat(self, finish: str) -> float:
        """Tell how often a surface's texture repeats in a metre."""
        return self._finishes[finish].repeat

    def find_material(self, name: str) -> str:
        """Add the MuJoCo material of a surface at its first use."""
        if name in self._materials:
            return name
        self._materials.add(name)
        finish = self._finishes[name]
        material = self.spec.add_material(
            name=name,
            rgba=(*finish.colour, 1.0),
            specular=finish.shine,
            shininess=0.4,
            emission=finish.glow,
        )
        if finish.picture is not None:
            # OpenGL counts texture rows from below.
            pixels = np.ascontiguousarray(finish.picture(self.rng)[::-1])
            kind = (
                mujoco.mjtTexture.mjTEXTURE_CUBE if finish.cube else mujoco.mjtTexture.mjTEXTURE_2D
            )
            texture = self.spec.add_texture(
                name=name, type=kind, width=pixels.shape[1], height=pixels.shape[0], nchannel=3
            )
            texture.data = pixels.tobytes()
            material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
        return name


@dataclass(frozen=True)
class FloorPose:
    """A spot and a direction on the floor; its own x is forward, y left, z up (metres)."""

    stage: SceneBuilder
    x: float
    y: float
    yaw: float

    def to_world(self, point: Vector) -> Vector:
        """Turn a point of this place into one of the house."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return (
            self.x + c * point[0] - s * point[1],
            self.y + s * point[0] + c * point[1],
            point[2],
        )

    def pose_on(self, x: float, y: float, yaw: float = 0.0) -> FloorPose:
        """Give a place relative to this one."""
        px, py, _ = self.to_world((x, y, 0.0))
        return FloorPose(self.stage, px, py, self.yaw + yaw)

    def add_solid(self, low: Vector, high: Vector) -> None:
        """Add a hull between two corners."""
        centre = self.to_world(
            ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2)
        )
        half = ((high[0] - low[0]) / 2, (high[1] - low[1]) / 2, (high[2] - low[2]) / 2)
        self.stage.add_hull(Hull(round=False, centre=centre, half=half, yaw=self.yaw))

    def add_post(self, x: float, y: float, radius: float, height: float) -> None:
        """Add an upright round hull that stands on the floor."""
        centre = self.to_world((x, y, height / 2))
        self.stage.add_hull(
            Hull(round=True, centre=centre, half=(radius, radius, height / 2), yaw=0.0)
        )

    def add_box(
        self, finish: str, low: Vector, high: Vector, radius: float = 0.01, *, solid: bool = False
    ) -> None:
        """Add a box with rounded edges between two corners."""
        if solid:
            self.add_solid(low, high)
        if not self.stage.looks:
            return
        size = (high[0] - low[0], high[1] - low[1], high[2] - low[2])
        centre = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2)
        # No more than the thinnest side has room for.
        radius = min(radius, *(side * 0.45 for side in size))
        self.stage.add_visual(
            finish,
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=self.stage.box_mesh(size, radius, self.stage.texture_repeat(finish)),
            pos=self.to_world(centre),
            quat=_yaw_quaternion(self.yaw),
        )

    def add_rod(
        self, finish: str, start: Vector, end: Vector, radius: float, *, blunt: bool = False
    ) -> None:
        """Add a capsule, or a cylinder if ``blunt``, from one point to another."""
        kind = mujoco.mjtGeom.mjGEOM_CYLINDER if blunt else mujoco.mjtGeom.mjGEOM_CAPSULE
        self.stage.add_visual(
            finish,
            type=kind,
            fromto=(*self.to_world(start), *self.to_world(end)),
            size=(radius, 0.0, 0.0),
        )

    def add_ball(self, finish: str, centre: Vector, half: Vector, tilt: float = 0.0) -> None:
        """Add an ellipsoid; ``tilt`` raises its front (rad)."""
        turn = np.zeros(4)
        mujoco.mju_mulQuat(
            turn, np.asarray(_yaw_quaternion(self.yaw)), np.asarray(_pitch_quaternion(-tilt))
        )
        self.stage.add_visual(
            finish,
            type=mujoco.mjtGeom.mjGEOM_ELLIPSOID,
            pos=self.to_world(centre),
            size=half,
            quat=tuple(turn),
        )


def _yaw_quaternion(yaw: float) -> tuple[float, float, float, float]:
    return (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2))


def _pitch_quaternion(pitch: float) -> tuple[float, float, float, float]:
    return (math.cos(pitch / 2), 0.0, math.sin(pitch / 2), 0.0)
