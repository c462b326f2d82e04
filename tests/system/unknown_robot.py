"""A robot that no code here knows: ten topics of eight packages' types, started as a script."""

from __future__ import annotations

import contextlib
import sys

import rclpy
from geometry_msgs.msg import PoseStamped, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.action import ActionServer
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import BatteryState, Image, JointState, MagneticField, RelativeHumidity
from std_msgs.msg import Float32MultiArray, String
from std_srvs.srv import Trigger
from test_msgs.action import Fibonacci
from test_msgs.msg import Arrays, BasicTypes, Nested
from test_msgs.srv import BasicTypes as Settings


class Rover(Node):
    """Publishes everything at 10 Hz, each number a different one."""

    def __init__(self) -> None:  # noqa: D107
        super().__init__("rover")
        best_effort = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
        make = self.create_publisher
        self.rows = [
            (make(Odometry, "/rover/odom", best_effort), self.odometry),
            (make(JointState, "/rover/joint_states", 10), self.joints),
            (make(BatteryState, "/rover/battery", 10), self.battery),
            (make(Image, "/rover/camera/image_raw", best_effort), self.image),
            (make(RelativeHumidity, "/humidity", 10), self.humidity),
            (make(MagneticField, "/compass", 10), MagneticField),
            (make(PoseStamped, "/arm/goal", 10), PoseStamped),
            (make(Float32MultiArray, "/pressures", 10), self.pressures),
            (make(String, "/mode", 10), lambda: String(data="idle")),
            (make(BasicTypes, "/plc/basic", 10), self.basic),
            (make(Arrays, "/plc/arrays", 10), Arrays),
            (make(Nested, "/plc/nested", 10), Nested),
        ]
        self.create_subscription(TwistStamped, "/rover/cmd_vel", lambda _: None, 10)
        self.create_service(Trigger, "/rover/home", lambda _, answer: answer)
        self.create_service(Settings, "/plc/set", lambda _, answer: answer)
        self.count = ActionServer(self, Fibonacci, "/count", lambda _: Fibonacci.Result())
        self.create_timer(0.1, self.publish)

    def publish(self) -> None:
        for publisher, message in self.rows:
            publisher.publish(message())

    def odometry(self) -> Odometry:
        message = Odometry()
        message.pose.pose.position.x = 2.5
        message.pose.pose.orientation.w = 1.0
        message.twist.twist.linear.x = 0.25
        return message

    def joints(self) -> JointState:
        return JointState(
            name=["wheel_left", "wheel_right"], position=[1.0, -1.0], velocity=[0.5, 0.6]
        )

    def battery(self) -> BatteryState:
        return BatteryState(percentage=0.5, voltage=12.0, temperature=float("nan"),
                            cell_voltage=[4.0, 4.1, 4.2], power_supply_status=2)  # fmt: skip

    def image(self) -> Image:
        return Image(height=8, width=8, encoding="rgb8", step=24, data=bytes(192))

    def humidity(self) -> RelativeHumidity:
        return RelativeHumidity(relative_humidity=0.42)

    def pressures(self) -> Float32MultiArray:
        return Float32MultiArray(data=[1.0, 2.0, 3.0])

    def basic(self) -> BasicTypes:
        return BasicTypes(bool_value=True, byte_value=b"\x07", int32_value=-3, float64_value=0.125)


def main() -> None:
    """Publish until told to end."""
    rclpy.init()
    node = Rover()
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    with contextlib.suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    import ros_wheels_bootstrapper  # noqa: F401

    main()
