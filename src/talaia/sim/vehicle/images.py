"""Publishes the camera's pictures from a thread of its own, and only while somebody looks."""

from __future__ import annotations

import array
import contextlib
import logging
import math
import os
import threading
import time
from typing import TYPE_CHECKING

from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image

from talaia.sim.vehicle.camera import HEIGHT, WIDTH, Camera
from talaia.sim.vehicle.vehicle import CAMERA_FIELD

if TYPE_CHECKING:
    from collections.abc import Callable

    from rclpy.node import Node

    from talaia.sim.vehicle.world import Motion, World

__all__ = ["Images"]

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""Only the newest picture is worth sending, also again."""
IDLE_S = 0.1
"""How often it is asked whether somebody looks now."""
POLITE = 10
"""Niceness of the drawing thread: driving goes before pictures."""

logger = logging.getLogger(__name__)


class Images:
    """The camera of the vehicle as a thread.

    A picture that cannot be drawn in time is left out, never queued. While nothing moves, the
    last picture is sent again with a new time.

    Args:
        node: publishes.
        world: a world built with ``looks=True``.
        where: gives the newest pose; called from the drawing thread.
        rate: pictures a second at most.

    """

    def __init__(
        self, node: Node, world: World, where: Callable[[], Motion], *, rate: float
    ) -> None:
        """Create the publishers."""
        self._node = node
        self._world = world
        self._where = where
        self._period = 1.0 / rate
        self._pictures = node.create_publisher(Image, "/images", NEWEST)
        self._infos = node.create_publisher(CameraInfo, "/camera_info", NEWEST)
        self._info = _lens()
        self._ended = threading.Event()
        self._opened = threading.Event()
        self._failure: Exception | None = None
        self.way = ""
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)

    def start(self) -> None:
        """Open the renderer and begin.

        Raises:
            NoRenderer: no software renderer works here.

        """
        self._thread.start()
        self._opened.wait()
        if self._failure is not None:
            self._thread.join()
            raise self._failure

    def close(self) -> None:
        """End the thread and give the renderer's memory back."""
        self._ended.set()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), POLITE)
        try:
            camera = Camera(self._world)
            motion = self._where()
            camera.draw(motion.x, motion.y, motion.yaw)
        except Exception as error:  # noqa: BLE001 - handed to the thread that waits in start
            self._failure = error
            self._opened.set()
            return
        self.way = camera.way
        self._opened.set()
        try:
            self._publish_until_ended(camera)
        except Exception:
            if not self._ended.is_set():
                logger.exception("the camera's thread ended; there are no more pictures")
        finally:
            camera.close()

    def _publish_until_ended(self, camera: Camera) -> None:
        message = Image(height=HEIGHT, width=WIDTH, encoding="rgb8", step=3 * WIDTH)
        message.header.frame_id = "camera_optical_frame"
        drawn = (math.nan, math.nan, math.nan)
        due = time.monotonic()
        while not self._ended.is_set():
            if not self._pictures.get_subscription_count():
                self._ended.wait(IDLE_S)
                due = time.monotonic()
                self._inform()
                continue
            motion = self._where()
            stamp = self._node.get_clock().now().to_msg()
            pose = (motion.x, motion.y, motion.yaw)
            if pose != drawn:
                pixels = array.array("B")
                pixels.frombytes(camera.draw(*pose).data)
                message.data = pixels
                drawn = pose
            message.header.stamp = stamp
            self._pictures.publish(message)
            self._inform(stamp)
            due = max(due + self._period, time.monotonic())
            self._ended.wait(due - time.monotonic())

    def _inform(self, stamp: object | None = None) -> None:
        """Publish what the lens is like, if somebody asks."""
        if self._infos.get_subscription_count():
            self._info.header.stamp = stamp or self._node.get_clock().now().to_msg()
            self._infos.publish(self._info)


def _lens() -> CameraInfo:
    focal = HEIGHT / 2 / math.tan(math.radians(CAMERA_FIELD / 2))
    cx, cy = WIDTH / 2, HEIGHT / 2
    info = CameraInfo(height=HEIGHT, width=WIDTH, distortion_model="plumb_bob")
    info.header.frame_id = "camera_optical_frame"
    info.d = [0.0] * 5
    info.k = [focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0]
    info.r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    info.p = [focal, 0.0, cx, 0.0, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
    return info
