"""The vehicle's form as URDF, as `/robot_description` gives it. Pure.

The same parts as its camera's world has (`sim.vehicle.vehicle`), and the frames that its messages
name. It needs no meshes: boxes and cylinders are in the text itself.
"""

from __future__ import annotations

import math

from talaia.sim.vehicle.drives.jogged_arm import ARM_JOINTS
from talaia.sim.vehicle.drives.kinematics import (
    MAX_STEERING,
    STEERING_RATE,
    TRACK,
    WHEEL_RADIUS,
    WHEELBASE,
    DriveKind,
)
from talaia.sim.vehicle.vehicle import CAMERA_AT, CAMERA_DOWN

__all__ = ["make_urdf"]

_LIDAR_AT = 0.19
_CAMERA_LINK_AT = (0.035, 0.0, 0.375)


def _cylinder(radius: float, length: float, xyz: str, material: str, *, rpy: str = "0 0 0") -> str:
    return f"""    <visual>
      <origin xyz="{xyz}" rpy="{rpy}"/>
      <geometry><cylinder radius="{radius}" length="{length}"/></geometry>
      <material name="{material}"/>
    </visual>
"""


def _joint(
    name: str,
    kind: str,
    child: str,
    xyz: str,
    *,
    rpy: str = "0 0 0",
    more: str = "",
    parent: str = "base_link",
) -> str:
    return f"""  <joint name="{name}" type="{kind}">
    <parent link="{parent}"/>
    <child link="{child}"/>
    <origin xyz="{xyz}" rpy="{rpy}"/>{more}
  </joint>
"""


def _limit(low: float, high: float, speed: float) -> str:
    return f'<limit lower="{low}" upper="{high}" effort="2" velocity="{speed}"/>'


def _wheel(name: str) -> str:
    return (
        f'  <link name="{name}_link">\n'
        + _cylinder(WHEEL_RADIUS, 0.02, "0 0 0", "tyre", rpy=f"{math.pi / 2:.6f} 0 0")
        # So that one sees it turn.
        + """    <visual>
      <geometry><box size="0.05 0.021 0.008"/></geometry>
      <material name="hub"/>
    </visual>
  </link>
"""
    )


def _rolling(name: str, xyz: str, *, parent: str = "base_link") -> str:
    more = '\n    <axis xyz="0 1 0"/>'
    return _wheel(name) + _joint(
        f"{name}_joint", "continuous", f"{name}_link", xyz, more=more, parent=parent
    )


def _wheels(drive: DriveKind) -> str:
    sides = (("left", TRACK / 2), ("right", -TRACK / 2))
    ends = (("front", WHEELBASE / 2), ("rear", -WHEELBASE / 2))
    if drive is DriveKind.HOLONOMIC:
        return "".join(
            _rolling(f"mecanum_{end}_{side}", f"{x} {y} {WHEEL_RADIUS}")
            for end, x in ends
            for side, y in sides
        )
    # The frame of a base with steered wheels lies between its rear ones, as odometry counts there.
    rear = "".join(_rolling(f"wheel_{side}", f"0 {y} {WHEEL_RADIUS}") for side, y in sides)
    if drive is DriveKind.DIFFERENTIAL:
        return rear
    limit = _limit(-MAX_STEERING, MAX_STEERING, STEERING_RATE)
    front = "".join(
        f'  <link name="steering_{side}_link"/>\n'
        + _joint(
            f"steering_{side}_joint",
            "revolute",
            f"steering_{side}_link",
            f"{WHEELBASE} {y} {WHEEL_RADIUS}",
            more=f'\n    <axis xyz="0 0 1"/>\n    {limit}',
        )
        + _rolling(f"wheel_front_{side}", "0 0 0", parent=f"steering_{side}_link")
        for side, y in sides
    )
    return rear + front


def _arm() -> str:
    """Make the arm: each joint at the end of the link before it."""
    text, parent, at = "", "base_link", "-0.07 0 0.151"
    for joint, axis, length in zip(
        ARM_JOINTS, ("0 0 1", "0 1 0", "0 1 0"), (0.03, 0.14, 0.12), strict=True
    ):
        link = joint.name.replace("_joint", "_link")
        limit = _limit(joint.low, joint.high, joint.max_speed)
        form = _cylinder(0.018, length, f"0 0 {length / 2}", "hub")
        text += f'  <link name="{link}">\n{form}  </link>\n'
        text += _joint(
            joint.name,
            "revolute",
            link,
            at,
            more=f'\n    <axis xyz="{axis}"/>\n    {limit}',
            parent=parent,
        )
        parent, at = link, f"0 0 {length}"
    return text


def _optical_joint() -> str:
    """Make the joint to the frame of the pictures: x right, y down, z ahead (REP-103)."""
    roll = -math.pi / 2 - CAMERA_DOWN
    x, y, z = (at - mast for at, mast in zip(CAMERA_AT, _CAMERA_LINK_AT, strict=True))
    return _joint(
        "camera_optical_joint",
        "fixed",
        "camera_optical_frame",
        f"{x:.6f} {y:.6f} {z:.6f}",
        rpy=f"{roll:.9f} 0 {-math.pi / 2:.9f}",
        parent="camera_link",
    )


def make_urdf(drive: DriveKind = DriveKind.DIFFERENTIAL, *, arm: bool = False) -> str:
    """Give the form of a vehicle with these wheels; the frame of its base is ``base_link``."""
    decks = "".join(
        _cylinder(0.13, 0.012, f"0 0 {height}", "deck") for height in (0.045, 0.095, 0.145)
    )
    mast = _cylinder(0.012, 0.20, "0 0 0.28", "deck")
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
  <link name="camera_optical_frame"/>
{_wheels(drive)}{_arm() if arm else ""}\
{_joint("scan_joint", "fixed", "base_scan", f"0 0 {_LIDAR_AT}")}\
{_joint("imu_joint", "fixed", "imu_link", "0 0 0.05")}\
{_joint("camera_joint", "fixed", "camera_link", " ".join(map(str, _CAMERA_LINK_AT)))}\
{_optical_joint()}\
</robot>
"""
