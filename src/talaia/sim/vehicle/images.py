"""The camera's process: draws and publishes pictures, and only while somebody looks.

A process of its own, since drawing in software takes most of a core: in the vehicle's process it
would stand between a driving command and the motors, waiting for the same interpreter.

On its standard input come poses, each three little-endian doubles: x, y (m) and yaw (rad). The end
of the input ends the process. It writes one JSON line: ``{"way": "egl" | "osmesa"}`` when it can
draw, or ``{"reasons": {way: reason}}`` when it cannot.
"""

from __future__ import annotations

import argparse
import array
import contextlib
import json
import math
import os
import signal
import sys
import threading
import time
from typing import TYPE_CHECKING

import talaia.ros_start  # noqa: F401 - before the first import of rclpy

# isort: split
import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import CameraInfo, Image

from talaia.sim.errors import NoRenderer
from talaia.sim.vehicle.camera import HEIGHT, WIDTH, Camera
from talaia.sim.vehicle.camera_process import POSE
from talaia.sim.vehicle.vehicle import CAMERA_FIELD
from talaia.sim.vehicle.world import World

if TYPE_CHECKING:
    from typing import BinaryIO

    from rclpy.node import Node

__all__ = ["main"]

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""Only the newest picture is worth sending, also again."""
# What draws has so long to end by itself; whoever started it ends it by force soon after (s).
_ENDS_WITHIN_S = 4.0
IDLE_S = 0.1
"""How often it is asked whether somebody looks now."""
SHARE = 0.2
"""Of all cores, at most this part draws; software on two cores then makes about 15 pictures/s."""


def main() -> int:
    """Run until the input ends."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--rate", type=float, required=True)
    options = parser.parse_args()
    # Whoever started this ends it by the input; Ctrl-C in a terminal reaches both.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        camera = Camera(World(options.seed, looks=True))
    except NoRenderer as error:
        _write_line({"reasons": error.reasons})
        return 1
    # Once before it is said that it can.
    camera.render_view(0.0, 0.0, 0.0)
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("vehicle_camera", enable_rosout=False, start_parameter_services=False)
    poses = _Poses(sys.stdin.buffer)
    images = Images(node, poses, rate=options.rate)
    _write_line({"way": camera.way})
    # Not before: beside other work it might never come so far, and everything waits for it.
    _give_way(spared=poses.thread_id)
    try:
        images.publish_until_ended(camera)
    finally:
        camera.close()
        node.destroy_node()
        rclpy.try_shutdown()
    return 0


def _give_way(spared: int) -> None:
    """Draw with the time nobody else wants: any other thread that wakes goes first (sched(7)).

    Args:
        spared: the thread that goes on as before: it ends this process.

    """
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            # Also the threads that draw, and ROS's.
            for thread in set(map(int, os.listdir("/proc/self/task"))) - {spared}:
                os.sched_setscheduler(thread, os.SCHED_IDLE, os.sched_param(0))
    else:
        os.nice(10)


def _write_line(line: object) -> None:
    sys.stdout.write(json.dumps(line) + "\n")
    sys.stdout.flush()


class _Poses:
    """The newest pose of those that come in, read by a thread that does nothing else.

    Attributes:
        newest: x, y (m) and heading (rad).
        ended: no more will come.
        thread_id: of the thread, as the system has it.

    """

    def __init__(self, source: BinaryIO) -> None:
        # Replaced as a whole by the reading thread, so that no lock is needed.
        self.newest = (0.0, 0.0, 0.0)
        self.ended = threading.Event()
        self._source = source
        # It stands in a read that nobody can end.
        thread = threading.Thread(target=self._read_poses, name="poses", daemon=True)
        thread.start()
        self.thread_id = thread.native_id or 0

    def _read_poses(self) -> None:
        while len(raw := self._source.read(POSE.size)) == POSE.size:
            self.newest = POSE.unpack(raw)
        self.ended.set()
        # What draws ends by itself, unless others want all of the time: then it would take minutes
        # for its goodbyes. This thread is gone before, where it is done in time.
        time.sleep(_ENDS_WITHIN_S)
        os._exit(0)


class Images:
    """Publishes what the camera sees.

    A picture that cannot be drawn in time is left out, never queued. While nothing moves, the
    last picture is sent again with a new time.

    Args:
        node: publishes.
        poses: tells where the vehicle is, and when it ends.
        rate: pictures a second at most.

    """

    def __init__(self, node: Node, poses: _Poses, *, rate: float) -> None:
        """Create the publishers."""
        self._node = node
        self._poses = poses
        # Least time between two pictures (s).
        self._period = 1.0 / rate
        self._pictures = node.create_publisher(Image, "/images", NEWEST)
        self._infos = node.create_publisher(CameraInfo, "/camera_info", NEWEST)
        # The lens never changes; only the stamp does.
        self._info = _make_camera_info()

    def publish_until_ended(self, camera: Camera) -> None:
        """Go on until no more poses come."""
        message = Image(height=HEIGHT, width=WIDTH, encoding="rgb8", step=3 * WIDTH)
        message.header.frame_id = "camera_optical_frame"
        # Equal to nothing: the first pose is always drawn.
        drawn = (math.nan, math.nan, math.nan)
        ended = self._poses.ended
        due = time.monotonic()
        spent = time.process_time()
        while not ended.is_set():
            if not self._pictures.get_subscription_count():
                ended.wait(IDLE_S)
                due = time.monotonic()
                self._publish_camera_info()
                continue
            pose = self._poses.newest
            stamp = self._node.get_clock().now().to_msg()
            if pose != drawn:
                pixels = array.array("B")
                pixels.frombytes(camera.render_view(*pose).data)
                message.data = pixels
                drawn = pose
            message.header.stamp = stamp
            self._pictures.publish(message)
            self._publish_camera_info(stamp)
            # Of all its threads. The rest behind it keeps drawing within its share of the cores.
            spent, before = time.process_time(), spent
            rest = (spent - before) / (SHARE * (os.cpu_count() or 1))
            due = max(due + max(self._period, rest), time.monotonic())
            ended.wait(due - time.monotonic())

    def _publish_camera_info(self, stamp: object | None = None) -> None:
        """Publish what the lens is like, if somebody asks."""
        if self._infos.get_subscription_count():
            self._info.header.stamp = stamp or self._node.get_clock().now().to_msg()
            self._infos.publish(self._info)


def _make_camera_info() -> CameraInfo:
    # Of a pinhole (px): half the picture's height over the tangent of half its angle.
    focal = HEIGHT / 2 / math.tan(math.radians(CAMERA_FIELD / 2))
    cx, cy = WIDTH / 2, HEIGHT / 2
    info = CameraInfo(height=HEIGHT, width=WIDTH, distortion_model="plumb_bob")
    info.header.frame_id = "camera_optical_frame"
    info.d = [0.0] * 5
    info.k = [focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0]
    info.r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    info.p = [focal, 0.0, cx, 0.0, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
    return info


if __name__ == "__main__":
    sys.exit(main())
