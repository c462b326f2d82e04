"""What hangs in the process for pictures does not hold up what comes behind it."""

from __future__ import annotations

import os
import time
from concurrent.futures import wait

from talaia.gateway.night.imaging.frame_reckoner import FrameReckoner


def test_a_process_that_hangs_is_ended_and_the_next_work_has_another() -> None:
    reckoner = FrameReckoner()
    first = reckoner.submit(os.getpid).result(60)
    hangs = reckoner.submit(time.sleep, 3600)
    reckoner.end_process()
    try:
        second = reckoner.submit(os.getpid).result(60)
        assert len({first, second, os.getpid()}) == 3
        # Its process had begun it, or not yet.
        wait([hangs], 60)
        assert hangs.cancelled() or hangs.exception() is not None
    finally:
        reckoner.end_process()
