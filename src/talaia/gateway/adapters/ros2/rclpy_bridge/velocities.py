"""Publications that end with a zero, whatever becomes of the gateway.

A velocity stands for half a second at most without a new one, is not published when it has waited
for a quarter, and is followed by zeros when the gateway is gone.
"""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from typing import Any

# A velocity stands no longer than this without a new one (s).
SILENCE_S = 0.5
# One that has waited so long in the pipe is of the past: whoever sent it may have let go since.
STALE_NS = 250_000_000
# Zeros are published for so long (s).
_ZEROS_FOR_S = 1.0


class VelocityPublisher:
    """A publisher of velocities; any thread."""

    def __init__(
        self,
        publisher: Any,  # noqa: ANN401 - rclpy ships no types
        zero: bytes,
        kept: tuple[int, int] = (0, 0),
    ) -> None:
        """Take rclpy's publisher, and the message that stops the robot.

        ``kept`` is from where to where the zero leaves bytes as they were published last.
        """
        self._publisher, self._zero, self._kept = publisher, zero, kept
        # The pipe's thread and the watching one both publish: a zero must not overtake.
        self._turn = threading.Lock()
        # Whether something other than the zero was published last, and when (monotonic, s).
        self._moving = False
        self._told_s = 0.0
        # Until when zeros are published again and again (monotonic, s).
        self._zeros_until_s = 0.0

    def publish(self, message: bytes, made_ns: int) -> None:
        """Publish a velocity, unless it is of the past; zeros always."""
        with self._turn:
            now_ns = time.monotonic_ns()
            begin, end = self._kept
            zero = self._zero[:begin] + message[begin:end] + self._zero[end:]
            # The gateway says its own zeros: then there is nothing to end.
            if message == zero:
                self._moving = False
            elif now_ns - made_ns > STALE_NS:
                return
            else:
                self._moving, self._zeros_until_s = True, 0.0
                self._told_s = now_ns / 1e9
            # As it stands from here on: what was of the past was never published.
            self._zero = zero
            self._publisher.publish(message)

    def end_silence(self, silence_s: float = SILENCE_S) -> None:
        """Publish a zero if a velocity stands for too long, and for a second after that."""
        with self._turn:
            now_s = time.monotonic()
            if self._moving and now_s - self._told_s >= silence_s:
                self._moving, self._zeros_until_s = False, now_s + _ZEROS_FOR_S
            # A single one could be lost, or come before a velocity that is under way.
            if now_s < self._zeros_until_s:
                self._publisher.publish(self._zero)
