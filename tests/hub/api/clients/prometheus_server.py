"""A real Prometheus that scrapes a hub and reads past values from it, and tokens for it."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import shutil
import subprocess
from typing import TYPE_CHECKING

import httpx
import pytest
from patience import PATIENCE_S
from ports import free_port
from shared_trust import usual_trust

from talaia.clock import SystemClock

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

OPENMETRICS = {"Accept": "application/openmetrics-text; version=1.0.0"}
EVERYWHERE = {"right": "metrics", "site": "*", "device": "*"}
VIEW_ALL = {"right": "view", "site": "*", "device": "*"}
VIEW_BASE = {"right": "view", "site": "agv", "device": "base"}


def prometheus_program() -> str:
    """Find Debian's Prometheus, or skip."""
    program = shutil.which("prometheus")
    if program is None:
        pytest.skip("Prometheus is missing (apt install prometheus)")
    return program


async def open_protocol(hub, *, is_open: bool = True) -> None:
    admin = await hub.client("admin")
    asked = {"open": is_open, "origins": []}
    answer = await admin.put("/api/client-protocols/metrics", json=asked)
    assert answer.status_code == 204, answer.text


async def token(hub, *permissions: dict[str, str], name: str = "admin") -> dict[str, str]:
    """Give the header of a new token with these permissions."""
    client = await hub.client(name)
    asked = {
        "name": "scrape",
        "ends_us": SystemClock().wall_ns() // 1000 + 3_600_000_000,
        "permissions": list(permissions),
    }
    answer = await client.post("/api/me/tokens", json=asked)
    assert answer.status_code == 200, answer.text
    return {"Authorization": f"Bearer {answer.json()['token']}"}


@contextlib.asynccontextmanager
async def serving(
    folder: Path, port: int, headers: dict[str, str], *, reads_past: bool = False
) -> AsyncIterator[httpx.AsyncClient]:
    """Run Prometheus until the block ends; it scrapes the hub each second."""
    program = prometheus_program()
    own = free_port()
    authorization = {"credentials": headers["Authorization"].split()[1]}
    past = f"http://127.0.0.1:{port}/clients/prometheus/read?job=talaia&instance=127.0.0.1:{port}"
    config: dict[str, object] = {
        "global": {"scrape_interval": "1s", "scrape_timeout": "1s"},
        "scrape_configs": [
            {
                "job_name": "talaia",
                "authorization": authorization,
                "static_configs": [{"targets": [f"127.0.0.1:{port}"]}],
            }
        ],
    }
    if reads_past:
        read = {"url": past, "authorization": authorization, "read_recent": True}
        config["remote_read"] = [read]
    # JSON is YAML, too.
    (folder / "prometheus.yml").write_text(json.dumps(config))
    process = await asyncio.create_subprocess_exec(
        program,
        f"--config.file={folder / 'prometheus.yml'}",
        f"--storage.tsdb.path={folder / 'data'}",
        f"--web.listen-address=127.0.0.1:{own}",
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "GOMAXPROCS": "1"},
    )
    try:
        async with httpx.AsyncClient(
            base_url=f"http://127.0.0.1:{own}", verify=usual_trust()
        ) as client:
            await _ready(client, process)
            yield client
    finally:
        process.terminate()
        await process.wait()


async def _ready(client: httpx.AsyncClient, process: asyncio.subprocess.Process) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while True:
            with contextlib.suppress(httpx.TransportError):
                if (await client.get("/-/ready")).is_success:
                    return
            assert process.returncode is None, "prometheus does not start"
            await asyncio.sleep(0.05)


async def query(client: httpx.AsyncClient, expression: str, **more: object) -> list[dict]:
    """Ask Prometheus, over a range where ``more`` has ``start``, ``end`` and ``step``."""
    path = "/api/v1/query_range" if "start" in more else "/api/v1/query"
    asked = {"query": expression, **more}
    answer = await client.get(path, params=asked, timeout=PATIENCE_S)
    assert answer.is_success, answer.text
    said = answer.json()
    # What remote read could not do is a warning here, and fewer series.
    assert not said.get("warnings"), said["warnings"]
    return said["data"]["result"]
