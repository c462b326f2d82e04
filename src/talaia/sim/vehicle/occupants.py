"""Who lives in the house: a person and a dog, modelled from simple shapes."""

from __future__ import annotations

from talaia.sim.vehicle.scene import Finish, FloorPose
from talaia.sim.vehicle.textures import draw_fur

__all__ = ["FINISHES", "add_dog", "add_person"]

FINISHES: dict[str, Finish] = {
    "skin": Finish(colour=(0.86, 0.66, 0.54), shine=0.1),
    "hair": Finish(lambda r: draw_fur(r, (0.25, 0.15, 0.09)), cube=True, shine=0.1),
    "shirt": Finish(colour=(0.76, 0.25, 0.22), shine=0.0),
    "jeans": Finish(colour=(0.22, 0.31, 0.48), shine=0.0),
    "shoe": Finish(colour=(0.92, 0.92, 0.90), shine=0.2),
    "eye": Finish(colour=(0.05, 0.04, 0.04), shine=0.9),
    "lip": Finish(colour=(0.70, 0.34, 0.32), shine=0.2),
    "fur": Finish(lambda r: draw_fur(r, (0.72, 0.50, 0.27)), cube=True, shine=0.0),
    "pale fur": Finish(lambda r: draw_fur(r, (0.90, 0.80, 0.64)), cube=True, shine=0.0),
    "dark fur": Finish(lambda r: draw_fur(r, (0.45, 0.28, 0.14)), cube=True, shine=0.0),
    "collar": Finish(colour=(0.10, 0.35, 0.75), shine=0.3),
    "tongue": Finish(colour=(0.88, 0.45, 0.46), shine=0.3),
}


def add_person(at: FloorPose) -> None:
    """A person of 1.7 m who stands and waves."""
    at.add_post(0.03, 0, 0.24, 1.2)
    for side in (-1, 1):
        at.add_ball("shoe", (0.055, side * 0.10, 0.045), (0.135, 0.052, 0.048))
        at.add_rod("jeans", (-0.01, side * 0.10, 0.10), (0.0, side * 0.095, 0.50), 0.062)
        at.add_rod("jeans", (0.0, side * 0.095, 0.50), (0.0, side * 0.085, 0.86), 0.082)
    at.add_ball("jeans", (0, 0, 0.92), (0.125, 0.175, 0.13))
    at.add_ball("shirt", (0, 0, 1.08), (0.115, 0.165, 0.20))
    at.add_ball("shirt", (0, 0, 1.27), (0.125, 0.195, 0.17))
    at.add_rod("shirt", (-0.01, -0.17, 1.36), (-0.01, 0.17, 1.36), 0.062)
    at.add_rod("skin", (0, 0, 1.38), (0.01, 0, 1.49), 0.05)
    _add_head(at)
    # One arm hangs, the other waves.
    at.add_rod("shirt", (-0.01, -0.21, 1.35), (0.0, -0.26, 1.10), 0.048)
    at.add_rod("skin", (0.0, -0.26, 1.10), (0.07, -0.26, 0.88), 0.037)
    at.add_ball("skin", (0.09, -0.26, 0.82), (0.04, 0.025, 0.065))
    at.add_rod("shirt", (-0.01, 0.21, 1.35), (0.06, 0.40, 1.22), 0.048)
    at.add_rod("skin", (0.06, 0.40, 1.22), (0.14, 0.46, 1.46), 0.036)
    at.add_ball("skin", (0.16, 0.47, 1.54), (0.026, 0.045, 0.055))
    for finger in range(4):
        y = 0.437 + finger * 0.022
        at.add_rod("skin", (0.165, y, 1.57), (0.175, y + 0.006 * (finger - 1), 1.635), 0.009)


def _add_head(at: FloorPose) -> None:
    at.add_ball("skin", (0.02, 0, 1.60), (0.095, 0.078, 0.118))
    at.add_ball("hair", (-0.012, 0, 1.645), (0.105, 0.088, 0.095))
    at.add_ball("hair", (-0.05, 0, 1.57), (0.07, 0.088, 0.14))
    at.add_ball("skin", (0.118, 0, 1.59), (0.018, 0.014, 0.022))
    at.add_rod("lip", (0.101, -0.022, 1.545), (0.101, 0.022, 1.545), 0.007)
    for side in (-1, 1):
        at.add_ball("shoe", (0.098, side * 0.033, 1.617), (0.012, 0.016, 0.010))
        at.add_ball("eye", (0.108, side * 0.033, 1.617), (0.006, 0.008, 0.008))
        at.add_rod("hair", (0.105, side * 0.018, 1.640), (0.098, side * 0.048, 1.642), 0.005)


def add_dog(at: FloorPose) -> None:
    """A dog of the size of a retriever, standing, 0.6 m high at the head."""
    at.add_solid((-0.36, -0.13, 0.0), (0.48, 0.13, 0.62))
    at.add_ball("fur", (-0.02, 0, 0.40), (0.30, 0.115, 0.125))
    at.add_ball("fur", (0.17, 0, 0.40), (0.15, 0.125, 0.150))
    at.add_ball("pale fur", (0.18, 0, 0.345), (0.13, 0.095, 0.105))
    at.add_ball("fur", (-0.21, 0, 0.40), (0.13, 0.115, 0.125))
    at.add_rod("fur", (0.22, 0, 0.45), (0.33, 0, 0.58), 0.078)
    at.add_rod("collar", (0.256, 0, 0.508), (0.274, 0, 0.53), 0.086, blunt=True)
    for side in (-1, 1):
        y = side * 0.085
        at.add_rod("fur", (0.19, y, 0.36), (0.185, y, 0.18), 0.046)
        at.add_rod("fur", (0.185, y, 0.18), (0.195, y, 0.04), 0.032)
        at.add_ball("pale fur", (0.215, y, 0.028), (0.055, 0.036, 0.028))
        at.add_rod("fur", (-0.22, y, 0.37), (-0.19, y, 0.23), 0.065)
        at.add_rod("fur", (-0.19, y, 0.23), (-0.26, y, 0.14), 0.036)
        at.add_rod("fur", (-0.26, y, 0.14), (-0.245, y, 0.04), 0.029)
        at.add_ball("pale fur", (-0.225, y, 0.028), (0.055, 0.036, 0.028))
        # Ears hang, eyes look ahead.
        at.pose_on(0.335, side * 0.088, side * 0.25).add_ball(
            "dark fur", (-0.01, 0, 0.595), (0.042, 0.018, 0.085), -0.25
        )
        at.add_ball("eye", (0.428, side * 0.043, 0.645), (0.013, 0.013, 0.014))
        at.add_ball("dark fur", (0.415, side * 0.043, 0.668), (0.02, 0.018, 0.009))
    at.add_ball("fur", (0.36, 0, 0.635), (0.095, 0.085, 0.085))
    at.add_rod("pale fur", (0.42, 0, 0.605), (0.505, 0, 0.590), 0.046)
    at.add_rod("pale fur", (0.40, 0, 0.575), (0.48, 0, 0.560), 0.034)
    at.add_ball("eye", (0.547, 0, 0.612), (0.018, 0.022, 0.016))
    at.add_ball("tongue", (0.50, 0, 0.535), (0.035, 0.02, 0.008), -0.5)
    for start, end, radius in (
        ((-0.31, 0, 0.44), (-0.40, 0, 0.56), 0.036),
        ((-0.40, 0, 0.56), (-0.42, 0.01, 0.68), 0.030),
        ((-0.42, 0.01, 0.68), (-0.39, 0.02, 0.76), 0.022),
    ):
        at.add_rod("fur", start, end, radius)
