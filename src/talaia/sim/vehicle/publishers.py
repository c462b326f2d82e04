"""What the vehicle publishes about itself, but for pictures."""

from __future__ import annotations

import array
import math
from typing import TYPE_CHECKING, Any

from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import (
    BatteryState,
    Imu,
    JointState,
    LaserScan,
    NavSatFix,
    NavSatStatus,
    Range,
    Temperature,
)
from std_msgs.msg import Bool, Float64, String

from talaia.sim.vehicle.description.floor_map import RESOLUTION
from talaia.sim.vehicle.sensors import Battery, on_earth, room_temperature
from talaia.sim.vehicle.world import LIDAR_RANGE, SONAR_FIELD, SONAR_RANGE, Motion, World

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from rclpy.node import Node

    from talaia.sim.vehicle.drives.drivetrain import JointReading
    from talaia.sim.vehicle.self_check import HealthStatus

try:  # a robot's own Python may lack it
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
except ImportError:
    DiagnosticArray = None
try:  # not on PyPI; there where ROS itself is installed
    from tf2_msgs.msg import TFMessage
except ImportError:
    TFMessage = None

__all__ = ["RELIABLE", "VehiclePublishers"]

RELIABLE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
"""Reliable writers serve reliable and best-effort readers alike."""
# Whoever comes later is told at once: it seldom changes.
LASTING = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)

Message = Any
"""ROS messages carry no types."""


class VehiclePublishers:
    """Publishers and their messages, made once and filled again. A method for each kind of news.

    Args:
        node: publishes.
        world: is measured.

    """

    def __init__(self, node: Node, world: World) -> None:
        """Create the publishers."""
        self._world = world
        self._node = node
        self._odometry = self._make_publisher(Odometry, "/odom")
        self._imu = self._make_publisher(Imu, "/imu")
        self._joints = self._make_publisher(JointState, "/joint_states")
        self._transform = self._make_publisher(TFMessage, "/tf") if TFMessage is not None else None
        self._scan = self._make_publisher(LaserScan, "/scan")
        self._battery = self._make_publisher(BatteryState, "/battery_state")
        self._fix = self._make_publisher(NavSatFix, "/fix")
        self._ranges = [self._make_publisher(Range, f"/ultrasonic{number}") for number in (1, 2, 3)]
        self._temperature = self._make_publisher(Temperature, "/temperature")
        self._speed = self._make_publisher(Float64, "/speed")
        self._wandering = node.create_publisher(Bool, "/wandering", LASTING)
        self._metric = self._make_publisher(String, "/metric")
        self._description = node.create_publisher(String, "/robot_description", LASTING)
        self._map = node.create_publisher(OccupancyGrid, "/map", LASTING)
        self._diagnostics = (
            self._make_publisher(DiagnosticArray, "/diagnostics")
            if DiagnosticArray is not None
            else None
        )
        # What the sonars measured last (m), said once more by `publish_metrics`.
        self._measured = {"ultrasonic1": 0.0, "ultrasonic2": 0.0, "ultrasonic3": 0.0}
        self._prepare_messages()

    def publish_description(self, stamp: Message, urdf: str) -> None:
        """Publish what is told once: the vehicle's form and the map of the house."""
        self._description.publish(String(data=urdf))
        found = self._world.floor_map
        grid = OccupancyGrid()
        grid.header.stamp = grid.info.map_load_time = stamp
        # Its odometry does not drift: the house stands still in it.
        grid.header.frame_id = "odom"
        grid.info.resolution = RESOLUTION
        grid.info.height, grid.info.width = found.cells.shape
        grid.info.origin.position.x, grid.info.origin.position.y = found.x, found.y
        grid.info.origin.orientation.w = 1.0
        grid.data = array.array("b", found.cells.tobytes())
        self._map.publish(grid)

    def publish_motion(self, stamp: Message, motion: Motion) -> None:
        """Publish odometry and inertia, and the transform where its package is installed."""
        noise = self._world.measuring_noise
        half = motion.yaw / 2
        odometry = self._odometry_message
        odometry.header.stamp = stamp
        pose = odometry.pose.pose
        pose.position.x, pose.position.y = motion.x, motion.y
        # A turn about z: the quaternion's other two parts stay 0.
        pose.orientation.z, pose.orientation.w = math.sin(half), math.cos(half)
        twist = odometry.twist.twist
        twist.linear.x, twist.linear.y, twist.angular.z = motion.speed, motion.slip, motion.turn
        self._odometry.publish(odometry)
        imu = self._imu_message
        imu.header.stamp = stamp
        imu.orientation.z, imu.orientation.w = pose.orientation.z, pose.orientation.w
        imu.angular_velocity.z = motion.turn + noise(0.002)
        imu.linear_acceleration.x = motion.acceleration + noise(0.02)
        # Towards the middle of the turn: speed times turn rate.
        imu.linear_acceleration.y = motion.speed * motion.turn + noise(0.02)
        # At rest it feels the floor that holds it up.
        imu.linear_acceleration.z = 9.81 + noise(0.02)
        self._imu.publish(imu)
        if self._transform is not None:
            transform = self._transform_message.transforms[0]
            transform.header.stamp = stamp
            transform.transform.translation.x = motion.x
            transform.transform.translation.y = motion.y
            transform.transform.rotation = pose.orientation
            self._transform.publish(self._transform_message)

    def publish_joints(self, stamp: Message, joints: Sequence[JointReading]) -> None:
        """Publish the angles and rates of wheels and arm."""
        message = self._joints_message
        message.header.stamp = stamp
        message.name = [joint.name for joint in joints]
        message.position = [joint.position for joint in joints]
        message.velocity = [joint.velocity for joint in joints]
        self._joints.publish(message)

    def publish_scan(self, stamp: Message, ranges: np.typing.NDArray[np.float32]) -> None:
        """Publish one turn of the lidar."""
        message = self._scan_message
        message.header.stamp = stamp
        # Given as an array it is taken whole; a list would be looked at number by number.
        message.ranges = array.array("f", ranges.tobytes())
        self._scan.publish(message)

    def publish_ranges(self, stamp: Message, motion: Motion) -> None:
        """Publish the ultrasonic ranges and the speed."""
        sonars = self._world.measure_sonars()
        for publisher, message, distance, name in zip(
            self._ranges, self._range_messages, sonars, self._measured, strict=True
        ):
            message.header.stamp = stamp
            message.range = distance
            self._measured[name] = distance
            publisher.publish(message)
        self._speed.publish(Float64(data=motion.speed))

    def publish_place(self, stamp: Message, motion: Motion, seconds: float) -> None:
        """Publish the position on Earth and the temperature there."""
        fix = self._fix_message
        fix.header.stamp = stamp
        fix.latitude, fix.longitude, fix.altitude = on_earth(motion.x, motion.y)
        self._fix.publish(fix)
        self._temperature_message.header.stamp = stamp
        measured = room_temperature(motion.x, motion.y, seconds) + self._world.measuring_noise(0.03)
        self._temperature_message.temperature = measured
        self._temperature.publish(self._temperature_message)

    def publish_metrics(self, motion: Motion) -> None:
        """Publish the CloudConnect sensors: a Python dictionary as text, as in the field."""
        values = {
            "speed1": motion.speed,
            **self._measured,
            "temperature1": self._temperature_message.temperature,
        }
        for name, value in values.items():
            text = str({"name": name, "magnitude": round(float(value), 3)})
            self._metric.publish(String(data=text))

    def publish_battery(self, stamp: Message, battery: Battery) -> None:
        """Publish charge, voltage and current."""
        message = self._battery_message
        message.header.stamp = stamp
        message.percentage = battery.charge
        message.charge = battery.charge * Battery.CAPACITY_AH
        message.voltage = battery.voltage
        # By its definition negative while the battery discharges.
        message.current = -battery.current
        self._battery.publish(message)

    def publish_health(self, stamp: Message, found: list[HealthStatus]) -> None:
        """Publish the vehicle's health as ROS's diagnostics, where their package is installed."""
        if self._diagnostics is None:
            return
        message = DiagnosticArray()
        message.header.stamp = stamp
        message.status = [
            DiagnosticStatus(
                # ROS 2 has a byte there, which Python has as bytes.
                level=bytes([one.level]),
                name=one.name,
                message=one.message,
                hardware_id=one.hardware,
                values=[KeyValue(key=key, value=value) for key, value in one.values.items()],
            )
            for one in found
        ]
        self._diagnostics.publish(message)

    def publish_wandering(self, *, on: bool) -> None:
        """Publish whether the vehicle drives about by itself."""
        self._wandering.publish(Bool(data=on))

    def _make_publisher(self, kind: Message, name: str) -> Message:
        return self._node.create_publisher(kind, name, RELIABLE)

    def _prepare_messages(self) -> None:
        """Make the messages with what never changes in them."""
        # Position and yaw are known; what a plane leaves no freedom for is certain.
        small = [0.0] * 36
        small[0] = small[7] = small[35] = 1e-5
        self._odometry_message = odometry = Odometry(child_frame_id="base_link")
        odometry.header.frame_id = "odom"
        odometry.pose.covariance = small
        odometry.twist.covariance = small
        self._imu_message = imu = Imu()
        imu.header.frame_id = "imu_link"
        # Squares of the noise in `publish_motion`.
        imu.angular_velocity_covariance = [4e-6, 0, 0, 0, 4e-6, 0, 0, 0, 4e-6]
        imu.linear_acceleration_covariance = [4e-4, 0, 0, 0, 4e-4, 0, 0, 0, 4e-4]
        self._joints_message = JointState()
        self._joints_message.header.frame_id = "base_link"
        if TFMessage is not None:
            base = TransformStamped(child_frame_id="base_link")
            base.header.frame_id = "odom"
            self._transform_message = TFMessage(transforms=[base])
        self._scan_message = scan = LaserScan()
        scan.header.frame_id = "base_scan"
        scan.angle_increment = 2 * math.pi / 360
        scan.angle_max = 2 * math.pi - scan.angle_increment
        scan.scan_time = 0.1
        scan.range_min, scan.range_max = LIDAR_RANGE
        self._range_messages = []
        for side in ("left", "front", "right"):
            reading = Range(radiation_type=Range.ULTRASOUND, field_of_view=SONAR_FIELD)
            reading.header.frame_id = f"ultrasonic_{side}"
            reading.min_range, reading.max_range = SONAR_RANGE
            self._range_messages.append(reading)
        # The square of the noise in `publish_place`.
        self._temperature_message = Temperature(variance=0.0009)
        self._temperature_message.header.frame_id = "base_link"
        self._fix_message = fix = NavSatFix()
        fix.header.frame_id = "base_link"
        fix.status.status = NavSatStatus.STATUS_FIX
        fix.status.service = NavSatStatus.SERVICE_GPS
        fix.position_covariance = [0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.04]
        fix.position_covariance_type = NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
        self._battery_message = battery = BatteryState(present=True)
        battery.header.frame_id = "base_link"
        battery.capacity = battery.design_capacity = Battery.CAPACITY_AH
        # By its definition: not measured.
        battery.temperature = math.nan
        battery.power_supply_status = BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
        battery.power_supply_technology = BatteryState.POWER_SUPPLY_TECHNOLOGY_LIPO
