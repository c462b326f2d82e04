"""A real gateway under a service manager: what it says on the notification socket."""

from __future__ import annotations

import asyncio
import os
import signal
import socket
import sys
from pathlib import Path

from patience import PATIENCE_S
from ports import free_port

SITE = """
talaia: 1
site: hut
name: Hut
interlocks:
  alone: {name: Alone, when: [{link_lost: 5}], refuse: [thing/*]}
devices:
  thing: {name: Thing}
"""


async def heard(manager: socket.socket) -> str:
    async with asyncio.timeout(PATIENCE_S):
        return (await asyncio.get_running_loop().sock_recv(manager, 100)).decode()


async def test_it_reports_ready_feeds_the_watchdog_and_says_when_it_ends(tmp_path: Path) -> None:
    (tmp_path / "site.yaml").write_text(SITE)
    (tmp_path / "key").write_text("a-key-that-no-hub-knows-of-forty-letters")
    words = [
        "-m", "talaia", "gateway", str(tmp_path / "site.yaml"), "--allow-plain", "--hub",
        f"ws://127.0.0.1:{free_port()}", "--key-file", str(tmp_path / "key"),
        "--data", str(tmp_path / "data"),
    ]  # fmt: skip
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(str(tmp_path / "notify"))
        manager.settimeout(0)
        more = {"NOTIFY_SOCKET": str(tmp_path / "notify"), "WATCHDOG_USEC": "20000000"}
        gateway = await asyncio.create_subprocess_exec(
            sys.executable, *words, env={**os.environ, **more}, stderr=asyncio.subprocess.DEVNULL
        )
        try:
            assert await heard(manager) == "READY=1"
            assert await heard(manager) == "WATCHDOG=1"
            gateway.send_signal(signal.SIGSTOP)
            await asyncio.to_thread(os.waitid, os.P_PID, gateway.pid, os.WSTOPPED | os.WNOWAIT)
            # What had been said by then; a frozen gateway says nothing more.
            while True:
                try:
                    async with asyncio.timeout(1.0):
                        await asyncio.get_running_loop().sock_recv(manager, 100)
                except TimeoutError:
                    break
            gateway.send_signal(signal.SIGCONT)
            assert await heard(manager) == "WATCHDOG=1"
            gateway.terminate()
            while await heard(manager) != "STOPPING=1":
                pass
            assert await gateway.wait() == 0
        finally:
            if gateway.returncode is None:
                gateway.kill()
                await gateway.wait()
