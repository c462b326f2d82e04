"""The vehicle's body: a round base of two decks with two wheels, a lidar and a camera on a mast."""

from __future__ import annotations

import math
from typing import Any

import mujoco

from talaia.sim.vehicle.scene import HULL_GROUP, Finish, SceneBuilder

__all__ = [
    "BODY",
    "CAMERA",
    "CAMERA_AT",
    "CAMERA_DOWN",
    "CAMERA_FIELD",
    "LIDAR_HEIGHT",
    "RADIUS",
    "add_vehicle",
    "set_friction",
]

BODY = "vehicle"
CAMERA = "front"
CAMERA_FIELD = 56.0
"""Vertical field of view of the camera (degrees)."""
CAMERA_AT = (0.07, 0.0, 0.37)
CAMERA_DOWN = math.radians(1)
"""So far below the horizon it looks (rad)."""
RADIUS = 0.14
"""The base is round, so that turning on the spot never hits anything (m)."""
LIDAR_HEIGHT = 0.19
MASS = 1.8
OWN_GROUP = 1
"""The vehicle's own parts, which its camera does not draw."""


def add_vehicle(stage: SceneBuilder) -> None:
    """Add the vehicle at the origin: three planar joints, a force-bounded motor for each."""
    spec = stage.spec
    body = spec.worldbody.add_body(name=BODY)
    for name, kind, axis in (
        ("x", mujoco.mjtJoint.mjJNT_SLIDE, (1, 0, 0)),
        ("y", mujoco.mjtJoint.mjJNT_SLIDE, (0, 1, 0)),
        ("yaw", mujoco.mjtJoint.mjJNT_HINGE, (0, 0, 1)),
    ):
        body.add_joint(name=name, type=kind, axis=axis)
    # The decks, and the mast with the camera above them.
    for radius, low, high in ((RADIUS, 0.01, 0.21), (0.03, 0.21, 0.40)):
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            pos=(0, 0, (low + high) / 2),
            size=(radius, (high - low) / 2, 0),
            group=HULL_GROUP,
            contype=1,
            conaffinity=2,
            friction=(0.2, 0.0, 0.0),
            # All of its mass is the body's, below.
            mass=0.0,
        )
    body.explicitinertial = True
    body.mass = MASS
    body.inertia = (0.02, 0.02, 0.02)
    site = body.add_site(name="hub", pos=(0, 0, 0))
    # Forward and turning motors, and the grip of the wheels that keeps it from sliding sideways.
    for name, gear, gain, limit in (
        ("forward", (1, 0, 0, 0, 0, 0), 400.0, 20.0),
        ("grip", (0, 1, 0, 0, 0, 0), 400.0, 40.0),
        ("turn", (0, 0, 0, 0, 0, 1), 6.0, 2.0),
    ):
        motor = spec.add_actuator(
            name=name, target=site.name, trntype=mujoco.mjtTrn.mjTRN_SITE, gear=gear
        )
        motor.set_to_velocity(kv=gain)
        motor.forcerange = (-limit, limit)
    body.add_camera(
        name=CAMERA,
        pos=CAMERA_AT,
        fovy=CAMERA_FIELD,
        # Looks along x with z up, and a little down.
        xyaxes=(0, -1, 0, math.sin(CAMERA_DOWN), 0, math.cos(CAMERA_DOWN)),
    )
    if stage.looks:
        _add_visuals(stage, body)


def set_friction(model: Any, friction: float, track_width: float) -> None:  # noqa: ANN401 - MuJoCo ships no types
    """Give the wheels of a compiled vehicle rolling friction.

    Args:
        model: begins with the vehicle's three joints.
        friction: of both wheels together (N per m/s).
        track_width: distance between the wheels (m).

    """
    # A turn rolls each wheel at half the track width from the middle, one on either side, so that
    # the torque of their friction is a quarter of its square.
    model.dof_damping[:3] = (friction, friction, friction * track_width**2 / 4)


def _add_visuals(stage: SceneBuilder, body: object) -> None:
    stage.add_finish("vehicle", Finish(colour=(0.12, 0.12, 0.13), shine=0.3))
    stage.add_finish("tyre", Finish(colour=(0.05, 0.05, 0.05), shine=0.1))
    stage.add_finish("lidar", Finish(colour=(0.20, 0.22, 0.26), shine=0.7))
    parts = (
        ("vehicle", (0, 0, 0.045), (0.13, 0.006)),
        ("vehicle", (0, 0, 0.095), (0.13, 0.006)),
        ("vehicle", (0, 0, 0.145), (0.13, 0.006)),
        ("lidar", (0, 0, 0.18), (0.045, 0.022)),
        ("vehicle", (0, 0, 0.28), (0.012, 0.10)),
    )
    for finish, position, (radius, half) in parts:
        body.add_geom(  # type: ignore[attr-defined]
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            pos=position,
            size=(radius, half, 0),
            material=stage.find_material(finish),
            group=OWN_GROUP,
            contype=0,
            conaffinity=0,
            mass=0.0,
        )
    for side in (-1, 1):
        body.add_geom(  # type: ignore[attr-defined]
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            fromto=(0, side * 0.115, 0.033, 0, side * 0.135, 0.033),
            size=(0.033, 0, 0),
            material=stage.find_material("tyre"),
            group=OWN_GROUP,
            contype=0,
            conaffinity=0,
            mass=0.0,
        )
    body.add_geom(  # type: ignore[attr-defined]
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=(0.035, 0, 0.375),
        size=(0.02, 0.045, 0.015),
        material=stage.find_material("vehicle"),
        group=OWN_GROUP,
        contype=0,
        conaffinity=0,
        mass=0.0,
    )
