"""A real indiserver with Debian's simulators, as tests start, kill and end it."""

from __future__ import annotations

import asyncio
import os
import shutil
import signal
import socket
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from patience import PATIENCE_S
from ports import free_port

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


class Server:
    """An indiserver that a test starts, kills and starts again on the same port."""

    def __init__(self, port: int, home: Path, drivers: tuple[str, ...]) -> None:  # noqa: D107
        self.port, self._home, self._drivers = port, home, drivers
        self._process: asyncio.subprocess.Process | None = None

    async def start(self) -> None:
        self._process = await asyncio.create_subprocess_exec(
            # A local socket of its own too, or two servers on one machine are in each other's way.
            "indiserver", "-p", str(self.port), "-u", f"{self._home}/indi", *self._drivers,
            env={**os.environ, "HOME": str(self._home)},
            stdout=asyncio.subprocess.DEVNULL,
            stderr=asyncio.subprocess.DEVNULL,
            start_new_session=True,
        )  # fmt: skip
        async with asyncio.timeout(PATIENCE_S):
            while not _answers(self.port):  # noqa: ASYNC110 - a server tells nobody
                await asyncio.sleep(0.05)

    def kill_driver(self, name: str) -> None:
        """As a driver that crashes; the server starts it again, disconnected."""
        assert self._process is not None
        children = Path(f"/proc/{self._process.pid}/task/{self._process.pid}/children")
        for child in children.read_text().split():
            words = Path(f"/proc/{child}/cmdline").read_bytes().split(b"\0")
            if Path(words[0].decode()).name == name:
                os.kill(int(child), signal.SIGKILL)
                return
        raise AssertionError(f"{name} does not run")

    async def kill(self) -> None:
        """As a power cut of the machine: the server and all its drivers, at once."""
        if self._process is not None and self._process.returncode is None:
            os.killpg(self._process.pid, signal.SIGKILL)
            await self._process.wait()


def _answers(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@asynccontextmanager
async def server_of(tmp_path: Path, *drivers: str) -> AsyncIterator[Server]:
    """Start a server with these drivers; skips, and says so, where INDI is missing."""
    missing = [each for each in ("indiserver", *drivers) if shutil.which(each) is None]
    if missing:
        said = f"{', '.join(missing)} missing: install indi-bin"
        if os.environ.get("TALAIA_REQUIRE_ALL") == "1":
            pytest.fail(f"{said}, and TALAIA_REQUIRE_ALL=1")
        pytest.skip(said)
    port = free_port()
    home = tmp_path / "home"
    home.mkdir(exist_ok=True)
    server = Server(port, home, drivers)
    await server.start()
    try:
        yield server
    finally:
        await server.kill()
