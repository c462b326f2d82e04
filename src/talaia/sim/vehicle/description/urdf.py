"""The vehicle's form as URDF, as `/robot_description` gives it. Pure.

The same parts as its camera's world has (`sim.vehicle.vehicle`), and the frames that its messages
name. It needs no meshes: boxes and cylinders are in the text itself.
"""

from __future__ import annotations

import math

__all__ = ["ROBOT_DESCRIPTION"]

_LIDAR_AT = 0.19
_WHEEL_AT, _WHEEL_RADIUS = 0.08, 0.033


def _cylinder(radius: float, length: float, xyz: str, material: str, *, rpy: str = "0 0 0") -> str:
    return f"""    <visual>
      <origin xyz="{xyz}" rpy="{rpy}"/>
      <geometry><cylinder radius="{radius}" length="{length}"/></geometry>
      <material name="{material}"/>
    </visual>
"""


def _joint(name: str, kind: str, child: str, xyz: str, *, more: str = "") -> str:
    return f"""  <joint name="{name}" type="{kind}">
    <parent link="base_link"/>
    <child link="{child}"/>
    <origin xyz="{xyz}" rpy="0 0 0"/>{more}
  </joint>
"""


def _make_urdf() -> str:
    decks = "".join(
        _cylinder(0.13, 0.012, f"0 0 {height}", "deck") for height in (0.045, 0.095, 0.145)
    )
    mast = _cylinder(0.012, 0.20, "0 0 0.28", "deck")
    wheels = "".join(
        f'  <link name="wheel_{side}_link">\n'
        + _cylinder(_WHEEL_RADIUS, 0.02, "0 0 0", "tyre", rpy=f"{math.pi / 2:.6f} 0 0")
        # So that one sees it turn.
        + """    <visual>
      <geometry><box size="0.05 0.021 0.008"/></geometry>
      <material name="hub"/>
    </visual>
"""
        + "  </link>\n"
        for side in ("left", "right")
    )
    joints = "".join(
        _joint(
            f"wheel_{side}_joint",
            "continuous",
            f"wheel_{side}_link",
            f"0 {sign * _WHEEL_AT} {_WHEEL_RADIUS}",
            more='\n    <axis xyz="0 1 0"/>',
        )
        for side, sign in (("left", 1), ("right", -1))
    )
    return f"""<?xml version="1.0"?>
<robot name="house_vehicle">
  <material name="deck"><color rgba="0.12 0.12 0.13 1"/></material>
  <material name="tyre"><color rgba="0.05 0.05 0.05 1"/></material>
  <material name="hub"><color rgba="0.75 0.75 0.78 1"/></material>
  <material name="lidar"><color rgba="0.20 0.22 0.26 1"/></material>
  <link name="base_link">
{decks}{mast}  </link>
  <link name="base_scan">
{_cylinder(0.045, 0.044, "0 0 -0.01", "lidar")}  </link>
  <link name="imu_link"/>
  <link name="camera_link">
    <visual>
      <geometry><box size="0.04 0.09 0.03"/></geometry>
      <material name="deck"/>
    </visual>
  </link>
{wheels}{joints}\
{_joint("scan_joint", "fixed", "base_scan", f"0 0 {_LIDAR_AT}")}\
{_joint("imu_joint", "fixed", "imu_link", "0 0 0.05")}\
{_joint("camera_joint", "fixed", "camera_link", "0.035 0 0.375")}\
</robot>
"""


ROBOT_DESCRIPTION = _make_urdf()
"""Of the vehicle; the frame of its base is ``base_link``."""
