"""The vehicle's side of its camera: starts the drawing process and tells it every pose."""

from __future__ import annotations

import json
import logging
import os
import struct
import subprocess
import sys
from typing import TYPE_CHECKING

from talaia.sim.errors import CameraEnded, NoRenderer

if TYPE_CHECKING:
    from talaia.sim.vehicle.world import Motion

__all__ = ["POSE", "CameraProcess"]

POSE = struct.Struct("<3d")
"""x (m), y (m), yaw (rad)."""
logger = logging.getLogger(__name__)


class CameraProcess:
    """The camera of the vehicle as a process of its own, see `talaia.sim.vehicle.images`.

    Args:
        seed: of the same world.
        rate: pictures a second at most.

    """

    def __init__(self, seed: int, rate: float) -> None:
        """Start the process; `wait_ready` tells when it can draw."""
        words = [sys.executable, "-m", "talaia.sim.vehicle.images"]
        words += ["--seed", str(seed), "--rate", str(rate)]
        poses, self._poses = os.pipe()
        # A full pipe must not make the vehicle wait.
        os.set_blocking(self._poses, False)
        self._process = subprocess.Popen(words, stdin=poses, stdout=subprocess.PIPE)  # noqa: S603 - our own words
        # While we held a reading end, too, the end of the process would not be noticed.
        os.close(poses)
        # The process is gone, and this was logged.
        self._lost = False

    def wait_ready(self) -> str:
        """Wait until it can draw; gives how: ``egl`` or ``osmesa``.

        Raises:
            NoRenderer: no software renderer works here.
            CameraEnded: the process ended without a word.

        """
        line = self._process.stdout.readline() if self._process.stdout else b""
        if not line:
            raise CameraEnded(self._process.wait())
        said = json.loads(line)
        if "way" in said:
            return str(said["way"])
        raise NoRenderer(said["reasons"])

    def send_pose(self, motion: Motion) -> None:
        """Tell where the vehicle is; never waits. Poses that find the pipe full are left out."""
        try:
            # 24 bytes are written whole or not at all (pipe(7)).
            os.write(self._poses, POSE.pack(motion.x, motion.y, motion.yaw))
        except BlockingIOError:
            return
        except BrokenPipeError:
            if not self._lost:
                self._lost = True
                logger.warning("the camera's process ended; there are no more pictures")

    @property
    def lost(self) -> bool:
        """Whether its process ended, as far as it was noticed."""
        return self._lost

    def close(self) -> None:
        """End the process."""
        # The end of its input ends it.
        os.close(self._poses)
        try:
            self._process.wait(timeout=5.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdout:
            self._process.stdout.close()
