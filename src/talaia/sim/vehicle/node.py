"""The vehicle as ROS 2 topics: takes commands in one thread, lets the world go on in another.

Long, because what both threads share under one lock is read best side by side.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from typing import TYPE_CHECKING, Any

from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from std_msgs.msg import Bool, Float64MultiArray, String
from std_srvs.srv import SetBool

from talaia.sim.vehicle.autonomy.goal import Goal, choose_goal_velocity
from talaia.sim.vehicle.base import Base, Change, Ramp
from talaia.sim.vehicle.description.urdf import make_urdf
from talaia.sim.vehicle.drives.drivetrain import Drivetrain
from talaia.sim.vehicle.drives.kinematics import DriveKind, turn_of
from talaia.sim.vehicle.drives.steering_bytes import HASH, TYPE, read_steering
from talaia.sim.vehicle.publishers import RELIABLE, VehiclePublishers
from talaia.sim.vehicle.self_check import MotorHeat, check_vehicle
from talaia.sim.vehicle.sensors import Battery
from talaia.sim.vehicle.wander import Wander

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    import numpy.typing as npt
    from rclpy.node import Node

    from talaia.clock import Clock
    from talaia.sim.vehicle.actuation_log import ActuationLog
    from talaia.sim.vehicle.camera_process import CameraProcess
    from talaia.sim.vehicle.drives.jogged_arm import JoggedArm
    from talaia.sim.vehicle.drives.raw_listening import RawListening
    from talaia.sim.vehicle.world import Motion, World

try:  # not on PyPI; there where ROS itself is installed
    from ackermann_msgs.msg import AckermannDriveStamped
except ImportError:
    AckermannDriveStamped = None

__all__ = ["ARM_TOPIC", "STEERING_TOPIC", "TICK_S", "Inputs", "Loop"]

STEERING_TOPIC = "/ackermann_cmd"
"""Speed and angle of steered wheels."""
ARM_TOPIC = "/arm_velocity_controller/commands"
"""As controllers of ROS 2 take velocities of joints."""
TICK_S = 0.02
"""Control period: odometry and inertia are published as often."""
LATE_S = 0.25
"""A machine that was away for longer does not make the world catch up."""

Message = Any
"""ROS messages carry no types."""

logger = logging.getLogger(__name__)


class Inputs:
    """Subscriptions and the service, served by a thread of their own.

    Args:
        node: subscribes.
        base: decides what a command does; touched under ``lock`` only.
        lock: shared with `Loop`.
        log: is told of every change, at the moment it is accepted.
        clock: dates the commands.
        arm: is moved by velocities of its joints; None where there is none.
        listen: hears types whose package is not installed; None where nothing can.

    """

    def __init__(
        self,
        node: Node,
        *,
        base: Base,
        lock: threading.Lock,
        log: ActuationLog,
        clock: Clock,
        arm: JoggedArm | None = None,
        listen: RawListening | None = None,
    ) -> None:
        """Create the subscriptions."""
        self._base = base
        self._arm = arm
        self._lock = lock
        self._log = log
        self._clock = clock
        # Where somebody has put it, for `Loop`, which alone touches the world.
        self.placed: Goal | None = None
        # Tells the thread to end.
        self._ended = threading.Event()
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(node)
        node.create_subscription(Twist, "/cmd_vel", self._on_twist, RELIABLE)
        if base.steers and AckermannDriveStamped is not None:
            node.create_subscription(
                AckermannDriveStamped, STEERING_TOPIC, self._on_steering, RELIABLE
            )
        elif base.steers and listen is not None:
            listen(node, STEERING_TOPIC, (TYPE, HASH), self._on_steering_bytes)
        if arm is not None:
            node.create_subscription(Float64MultiArray, ARM_TOPIC, self._on_arm, RELIABLE)
        node.create_subscription(String, "/control", self._on_key, RELIABLE)
        node.create_subscription(Bool, "/stop", self._on_stop, RELIABLE)
        node.create_subscription(PoseStamped, "/goal_pose", self._on_goal, RELIABLE)
        node.create_subscription(
            PoseWithCovarianceStamped, "/set_pose", self._on_placement, RELIABLE
        )
        node.create_service(SetBool, "/wander", self._wander)
        self._thread = threading.Thread(target=self._run_executor, name="inputs", daemon=True)

    def start(self) -> None:
        """Begin to listen."""
        self._thread.start()

    def close(self) -> None:
        """Stop listening and end the thread."""
        self._ended.set()
        self._thread.join(timeout=5.0)
        self._executor.shutdown(timeout_sec=1.0)

    def _run_executor(self) -> None:
        while not self._ended.is_set():
            try:
                # How often it looks whether it is to end (s).
                self._executor.spin_once(timeout_sec=0.2)
            except ExternalShutdownException:
                return
            except Exception:
                # A wrong message must not leave the vehicle deaf to STOP.
                logger.exception("a ROS message or request could not be handled")

    def _apply_change(self, change: Callable[[], Change | None]) -> None:
        # Written under the lock, so that lines stand in the order of the changes.
        with self._lock:
            self._log.write_change(change())

    def _on_twist(self, message: Message) -> None:
        # Before the lock is waited for.
        now = self._clock.monotonic_ns()
        linear, turn = message.linear, message.angular.z
        self._apply_change(lambda: self._base.set_velocity(now, linear.x, turn, lateral=linear.y))

    def _on_steering(self, message: Message) -> None:
        now = self._clock.monotonic_ns()
        wanted = message.drive
        self._apply_change(
            lambda: self._base.steer_wheels(now, wanted.speed, wanted.steering_angle)
        )

    def _on_steering_bytes(self, raw: bytes) -> None:
        now = self._clock.monotonic_ns()
        wanted = read_steering(raw)
        self._apply_change(lambda: self._base.steer_wheels(now, wanted.speed, wanted.angle))

    def _on_arm(self, message: Message) -> None:
        now = self._clock.monotonic_ns()
        with self._lock:
            if self._arm is not None:
                self._arm.set_velocities(now, message.data)

    def _on_key(self, message: Message) -> None:
        now = self._clock.monotonic_ns()
        self._apply_change(lambda: self._base.press_key(now, message.data))

    def _on_stop(self, message: Message) -> None:
        with self._lock:
            if self._arm is not None:
                self._arm.latch_stop(engaged=message.data)
        self._apply_change(lambda: self._base.latch_stop(engaged=message.data))

    def _on_goal(self, message: Message) -> None:
        with self._lock:
            accepted = self._base.set_goal(_floor_pose(message.pose))
        if not accepted:
            logger.warning("a goal was refused: STOP is latched, or it cannot turn on the spot")

    def _on_placement(self, message: Message) -> None:
        self.placed = _floor_pose(message.pose.pose)

    def _wander(self, request: Message, response: Message) -> Message:
        with self._lock:
            accepted, change = self._base.switch_wandering(on=request.data)
            self._log.write_change(change)
        response.success = accepted
        if not accepted and not self._base.drives_itself:
            response.message = "refused: wandering turns on the spot, and steered wheels do not"
        elif not accepted:
            response.message = "refused: STOP is latched; release it first"
        else:
            response.message = "wandering" if request.data else "not wandering"
        return response


def _floor_pose(pose: Message) -> Goal:
    """Give the place on the floor of a pose; of its turn only the heading counts."""
    turned = pose.orientation
    yaw = 2.0 * math.atan2(turned.z, turned.w)
    return Goal(pose.position.x, pose.position.y, math.remainder(yaw, 2 * math.pi))


class Loop:
    """Lets the world go on with the machine's clock and reports it.

    Args:
        node: gives ROS time.
        world: goes on.
        base: decides the wanted velocity; touched under ``lock`` only.
        lock: shared with `Inputs`.
        log: is told of time-outs and of wandering's turns.
        clock: measures the control period.
        seed: for wandering.
        eye: is told where the vehicle is; None where there is no camera.
        inputs: says where somebody has put the vehicle.
        drive: which wheels it has.
        arm: is on its deck; touched under ``lock`` only.

    """

    def __init__(
        self,
        node: Node,
        *,
        world: World,
        base: Base,
        lock: threading.Lock,
        log: ActuationLog,
        clock: Clock,
        seed: int,
        eye: CameraProcess | None = None,
        inputs: Inputs | None = None,
        drive: DriveKind = DriveKind.DIFFERENTIAL,
        arm: JoggedArm | None = None,
    ) -> None:
        """Create the publishers."""
        self._drive, self._arm = drive, arm
        self._drivetrain = Drivetrain(drive)
        self._inputs = inputs
        self._node = node
        self._world = world
        self._base = base
        self._lock = lock
        self._log = log
        self._clock = clock
        self._reports = VehiclePublishers(node, world)
        self._ramp = Ramp()
        self._wander = Wander(seed)
        self._battery = Battery()
        self._heat = {motor: MotorHeat() for motor in self._drivetrain.motors}
        # Of the simulated time.
        self._checked_s = 0.0
        self._eye = eye
        # Time simulated so far (s).
        self._seconds = 0.0
        # What was published last; none before the first time.
        self._told_wandering: bool | None = None

    def run(self, ended: threading.Event, started: Callable[[], None]) -> None:
        """Go on until ``ended``; ``started`` is called after the first round."""
        tick = 0
        due = time.monotonic()
        before = due
        while not ended.is_set():
            now = time.monotonic()
            # Before the first round no time has been measured.
            self._run_period(tick, min(now - before, LATE_S) if tick else TICK_S)
            before = now
            if tick == 0:
                started()
            tick += 1
            due += TICK_S
            # Catching up would be a burst of rounds: it counts from now on.
            if time.monotonic() - due > LATE_S:
                due = time.monotonic()
            ended.wait(max(0.0, due - time.monotonic()))

    def _run_period(self, tick: int, seconds: float) -> None:
        # Only what `Inputs` changes, too: physics and publishing hold up no command.
        with self._lock:
            self._log.write_change(self._base.pass_time(self._clock.monotonic_ns()))
            wanted = self._base.wanted
            wandering, stopped = self._base.wandering, self._base.stopped
        self._place_vehicle()
        motion = self._move_body(seconds, wanted)
        joints = self._drivetrain.pass_time(seconds, motion, self._ramp.steering)
        with self._lock:
            if self._arm is not None:
                joints += self._arm.pass_time(self._clock.monotonic_ns(), seconds)
            if (goal := self._base.goal) is not None:
                velocity = choose_goal_velocity(motion, goal)
                self._log.write_change(self._base.set_goal_velocity(velocity))
        if self._eye is not None:
            self._eye.send_pose(motion)
        self._seconds += seconds
        self._battery.drain_battery(seconds, motion.speed, motion.turn)
        stamp = self._node.get_clock().now().to_msg()
        if tick == 0:
            self._reports.publish_description(
                stamp, make_urdf(self._drive, arm=self._arm is not None)
            )
        self._reports.publish_motion(stamp, motion)
        # The slower reports take turns, so that no round is much longer than another.
        if tick % 2 == 1:
            self._reports.publish_joints(stamp, joints)
        if tick % 5 == 0:
            self._look_around(stamp, wandering=wandering)
        if tick % 5 == 2:
            self._reports.publish_ranges(stamp, motion)
        if tick % 12 == 4:
            self._reports.publish_metrics(motion)
        if tick % 10 == 3:
            self._reports.publish_place(stamp, motion, self._seconds)
        if tick % 50 == 1:
            self._reports.publish_battery(stamp, self._battery)
        if tick % 50 == 22:
            self._check_health(stamp, motion, stopped=stopped)
        if tick % 50 == 8 or wandering != self._told_wandering:
            self._told_wandering = wandering
            self._reports.publish_wandering(on=wandering)

    def _move_body(self, seconds: float, wanted: Change) -> Motion:
        ramp = self._ramp
        ramp.follow_velocity(seconds, wanted.speed, wanted.turn, lateral=wanted.lateral)
        turn = ramp.turn
        if self._drive is DriveKind.ACKERMANN:
            ramp.turn_wheels(seconds, wanted.steering)
            # Only wheels that roll turn it: held by a wall it does not turn.
            turn = turn_of(self._world.current_motion().speed, ramp.steering)
        return self._world.step(seconds, ramp.speed, turn, lateral=ramp.lateral)

    def _place_vehicle(self) -> None:
        if self._inputs is None or (placed := self._inputs.placed) is None:
            return
        self._inputs.placed = None
        if all(map(math.isfinite, (placed.x, placed.y, placed.yaw))):
            self._world.place_vehicle(placed.x, placed.y, placed.yaw)

    def _check_health(self, stamp: object, motion: Motion, *, stopped: bool) -> None:
        seconds, self._checked_s = self._seconds - self._checked_s, self._seconds
        rates = dict(zip(self._heat, self._drivetrain.rates(motion), strict=True))
        for name, motor in self._heat.items():
            motor.pass_time(seconds, rates[name])
        found = check_vehicle(
            battery=self._battery,
            motors={name: (motor, rates[name]) for name, motor in self._heat.items()},
            camera=None if self._eye is None else not self._eye.lost,
            stopped=stopped,
        )
        self._reports.publish_health(stamp, found)

    def _look_around(self, stamp: object, *, wandering: bool) -> None:
        ranges: npt.NDArray[np.float32] = self._world.scan_lidar()
        self._reports.publish_scan(stamp, ranges)
        if wandering:
            # As often as this is called.
            speed, turn = self._wander.choose_velocity(5 * TICK_S, ranges)
            with self._lock:
                self._log.write_change(self._base.set_wander_velocity(speed, turn))
