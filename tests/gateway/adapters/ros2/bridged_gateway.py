"""A gateway in a process of its own, until its input ends: URL of a hub, and a folder for its data.

A third word is the file of its description where that is not the bench's.
With ``TALAIA_ROS_PYTHON`` set its ROS 2 is that of another Python.
"""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path

from gateway_bench import SITE, running

TEXT = Path(sys.argv[3]).read_text() if sys.argv[3:] else SITE


async def main() -> None:
    async with running(sys.argv[1], Path(sys.argv[2]), TEXT):
        # Who came with rclpy itself would be no judge of what stands for it.
        assert sys.modules["rclpy"].__name__.startswith("talaia.")
        await asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)


asyncio.run(main())
