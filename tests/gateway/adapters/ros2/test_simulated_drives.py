"""A simulated base that moves sideways, described by what `talaia init` finds of it."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from contextlib import asynccontextmanager
from itertools import count
from typing import TYPE_CHECKING

import pytest
from fake_hub import fake_hub
from gateway_bench import addresses_of, running, take_lease
from patience import PATIENCE_S, until_answered

from talaia.model.yaml_text.load import load_site
from talaia.sim.ros_domain import domain_environment
from talaia.wire.frames import DriveFrame, LeaseOp, LeaseRequest

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

pytestmark = pytest.mark.robot
SEQ = count()


async def start(domain: int, *words: str) -> asyncio.subprocess.Process:
    environment = {
        **os.environ, **domain_environment(domain), "PYTHONPATH": os.pathsep.join(sys.path)
    }  # fmt: skip
    return await asyncio.create_subprocess_exec(
        sys.executable, "-m", "talaia", *words, "--domain", str(domain),
        stdout=asyncio.subprocess.PIPE, env=environment,
    )  # fmt: skip


@asynccontextmanager
async def vehicle(domain: int, log: Path) -> AsyncIterator[None]:
    """Run one with wheels for all directions."""
    words = ("--drive", "holonomic", "--no-camera", "--log", str(log))
    process = await start(domain, "sim", "vehicle", *words)
    try:
        async with asyncio.timeout(PATIENCE_S):
            assert json.loads(await process.stdout.readline())["ready"]
        yield
    finally:
        process.terminate()
        await process.wait()


def sideways_limit(text: str) -> float:
    drive = load_site(text).devices["base"].drive
    return 0.0 if drive is None else drive.max_sideways


async def test_what_init_finds_of_a_holonomic_base_drives_it_sideways(
    ros_domain: int, tmp_path: Path
) -> None:
    log, file = tmp_path / "log.jsonl", tmp_path / "site.yaml"
    async with vehicle(ros_domain, log):

        async def describe() -> bool:
            words = ("--ros2", "--no-questions", "--force", "--seconds", "3", "-o", str(file))
            asked = await start(ros_domain, "init", *words)
            async with asyncio.timeout(PATIENCE_S):
                assert await asked.wait() == 0
            # On a busy machine its form is not heard in so short a time.
            return sideways_limit(file.read_text()) > 0

        await until_answered(describe)
        text = file.read_text()
        async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "gateway", text):
            await hub.until(lambda: hub.hellos, "a hello")
            epoch = await take_lease(hub)

            async def push_left() -> bool:
                await hub.send(
                    LeaseRequest(device="base", session="tab", who="Ada", op=LeaseOp.RENEW)
                )
                await hub.send(
                    DriveFrame(
                        device="base", session="tab", epoch=epoch, seq=next(SEQ), tick=hub.tick,
                        linear=0.0, angular=0.0, lateral=0.15,
                    )
                )  # fmt: skip
                rows = [json.loads(line) for line in log.read_text().splitlines()]
                return any(row.get("lateral", 0) > 0.14 and row["v"] == 0 for row in rows)

            await until_answered(push_left)
