"""The twin as ROS 2 topics, all below its own name."""

from __future__ import annotations

import logging
import math
import threading
import time
from typing import TYPE_CHECKING, Any

from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64, UInt8, UInt32
from std_srvs.srv import Trigger

from talaia.model.site import DriveMessage
from talaia.model.twins.twin_topics import base_frame, velocity_topic
from talaia.sim.twin.follower import VehicleState
from talaia.sim.vehicle.base import Ramp

if TYPE_CHECKING:
    from collections.abc import Callable

    from rclpy.node import Node

    from talaia.clock import Clock
    from talaia.model.site import Drive
    from talaia.sim.twin.follower import TwinFollower
    from talaia.sim.vehicle.world import Motion, World

__all__ = ["TwinNode"]

TICK_S = 0.02
"""As the vehicle's own control period."""
LATE_S = 0.25
"""A machine that was away for longer does not make the twin catch up."""
SELDOM = 25
"""Mode and resets are published each so many periods, and at once when the mode changes."""
# Whoever publishes odometry and velocities, reliably or not, is heard.
BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
logger = logging.getLogger(__name__)

Message = Any
"""ROS messages carry no types."""


class TwinNode:
    """Hears robot and gateway in one thread, lets the twin go on in the caller's.

    Args:
        node: subscribes and publishes.
        name: of the twin's device in the description.
        drive: of the real device.
        odometry: topic of where the real one is.
        world: the twin's body.
        follower: decides; touched under a lock only.
        clock: dates what is heard.

    """

    def __init__(
        self,
        node: Node,
        *,
        name: str,
        drive: Drive,
        odometry: str,
        world: World,
        follower: TwinFollower,
        clock: Clock,
    ) -> None:
        """Create subscriptions and publishers."""
        self._node, self._world, self._follower, self._clock = node, world, follower, clock
        self._lock = threading.Lock()
        self._ramp = Ramp()
        # Of the robot's odometry: in which the twin's pose is given as well.
        self._frame = "odom"
        self._told_mode = -1
        self._ended = threading.Event()
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(node)
        stamped = drive.message is DriveMessage.TWIST_STAMPED
        node.create_subscription(Odometry, odometry, self._on_odometry, BEST_EFFORT)
        node.create_subscription(
            TwistStamped if stamped else Twist,
            drive.topic,
            lambda message: self._on_command(message.twist if stamped else message),
            BEST_EFFORT,
        )
        node.create_subscription(Twist, velocity_topic(name), self._on_driven, RELIABLE)
        node.create_service(Trigger, f"/{name}/follow", self._on_follow)
        self._odometry = node.create_publisher(Odometry, f"/{name}/odom", RELIABLE)
        self._errors = [
            node.create_publisher(Float64, f"/{name}/{what}_error", RELIABLE)
            for what in ("pose", "heading", "speed")
        ]
        self._mode = node.create_publisher(UInt8, f"/{name}/mode", RELIABLE)
        self._resets = node.create_publisher(UInt32, f"/{name}/resets", RELIABLE)
        self._message = Odometry(child_frame_id=base_frame(name))
        self._thread = threading.Thread(target=self._run_executor, name="inputs", daemon=True)

    def run(self, ended: threading.Event, started: Callable[[], None]) -> None:
        """Go on until ``ended``; ``started`` is called after the first period."""
        self._thread.start()
        tick, before = 0, time.monotonic()
        due = before
        while not ended.is_set():
            now = time.monotonic()
            self._run_period(tick, min(now - before, LATE_S))
            before = now
            if tick == 0:
                started()
            tick += 1
            # Catching up would be a burst of periods: it counts from now on.
            due = max(due + TICK_S, time.monotonic() - LATE_S)
            ended.wait(max(0.0, due - time.monotonic()))

    def close(self) -> None:
        """Stop listening and end the thread."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join(timeout=5.0)
        self._executor.shutdown(timeout_sec=1.0)

    def _run_period(self, tick: int, seconds: float) -> None:
        now = self._clock.monotonic_ns()
        with self._lock:
            wanted = self._follower.wanted_velocity(now)
        self._ramp.follow_velocity(seconds, *wanted)
        state = _state_of(self._world.step(seconds, self._ramp.speed, self._ramp.turn))
        with self._lock:
            # Before it is corrected: what the model got wrong in this period is part of it.
            difference = self._follower.difference(state)
            correction = self._follower.correct_twin(state, seconds, now)
            mode, resets = self._follower.mode, self._follower.resets
        if any(correction):
            self._world.move_vehicle(*correction)
        self._publish_odometry(self._world.current_motion())
        # Ten times a second are enough for people, alarms and detectors.
        if difference is not None and tick % 5 == 0:
            for publisher, value in zip(self._errors, difference, strict=True):
                publisher.publish(Float64(data=value))
        if tick % SELDOM == 0 or mode != self._told_mode:
            self._told_mode = int(mode)
            self._mode.publish(UInt8(data=int(mode)))
            self._resets.publish(UInt32(data=resets))

    def _publish_odometry(self, motion: Motion) -> None:
        message = self._message
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.header.frame_id = self._frame
        pose, twist = message.pose.pose, message.twist.twist
        pose.position.x, pose.position.y = motion.x, motion.y
        pose.orientation.z, pose.orientation.w = math.sin(motion.yaw / 2), math.cos(motion.yaw / 2)
        twist.linear.x, twist.linear.y, twist.angular.z = motion.speed, motion.slip, motion.turn
        self._odometry.publish(message)

    def _run_executor(self) -> None:
        while not self._ended.is_set():
            try:
                # How often it looks whether it is to end (s).
                self._executor.spin_once(timeout_sec=0.2)
            except ExternalShutdownException:
                return
            except Exception:
                # A wrong message must not leave the twin deaf.
                logger.exception("a ROS message or request could not be handled")

    def _on_odometry(self, message: Message) -> None:
        now = self._clock.monotonic_ns()
        pose, twist = message.pose.pose, message.twist.twist
        turned = pose.orientation
        # The heading of a quaternion, whatever the rest of its turn is.
        yaw = math.atan2(
            2.0 * (turned.w * turned.z + turned.x * turned.y),
            1.0 - 2.0 * (turned.y**2 + turned.z**2),
        )
        state = VehicleState(pose.position.x, pose.position.y, yaw, twist.linear.x, twist.angular.z)
        self._frame = message.header.frame_id or self._frame
        with self._lock:
            self._follower.hear_robot(state, now)

    def _on_command(self, twist: Message) -> None:
        now = self._clock.monotonic_ns()
        with self._lock:
            self._follower.hear_command(twist.linear.x, twist.angular.z, now)

    def _on_driven(self, twist: Message) -> None:
        now = self._clock.monotonic_ns()
        with self._lock:
            self._follower.drive_alone(twist.linear.x, twist.angular.z, now)

    def _on_follow(self, _request: Message, response: Message) -> Message:
        with self._lock:
            self._follower.follow_robot()
        response.success, response.message = True, "following the robot"
        return response


def _state_of(motion: Motion) -> VehicleState:
    return VehicleState(motion.x, motion.y, motion.yaw, motion.speed, motion.turn)
