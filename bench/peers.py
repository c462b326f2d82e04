"""Talaia beside others that people use for the same, in one run: make bench-peers.

python bench/peers.py [TABLE]

Each is installed by pip into an empty environment, started empty and left alone; then topics of
ROS 2 go to one client through Talaia and through a server of ``foxglove-sdk``. What no package
index and no Debian has, or what does not start here, is skipped with a word. TABLE is written.
"""

from __future__ import annotations

import asyncio
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import psutil
import stack
import taps

ROOT = Path(__file__).resolve().parent.parent
TOPICS, RATE = 20, 100.0
# To start at all, and at rest before it is looked at (s).
PATIENCE_S, REST_S, LOOK_S = 180.0, 20.0, 15.0
# What people name beside Talaia and no index of this run has.
NOT_HERE = {
    "rosbridge_suite": "neither PyPI nor Debian has it; it comes with ROS 2 from its own archive",
    "ThingsBoard": "a server of Java in its vendor's own archives and images",
    "KStars with Ekos": "Debian has it, and it is a window that starts by hand; no server to ask",
}
FOXGLOVE = """\
import sys, time, foxglove
foxglove.start_server(host="127.0.0.1", port=int(sys.argv[1]))
print("ready", flush=True)
while True: time.sleep(3600)
"""


class Peer(NamedTuple):
    """One program: what pip installs, and the words that start it on a port.

    Attributes:
        name: for the table.
        install: words behind ``pip install``.
        start: gives the words; of the environment's ``bin``, an empty folder and a port.
        about: what it is.

    """

    name: str
    install: tuple[str, ...]
    start: Callable[[Path, Path, int], list[str]]
    about: str


def start_talaia(programs: Path, folder: Path, port: int) -> list[str]:
    """Start a hub that has no site."""
    where = ["--data", str(folder), "--port", str(port)]
    return [str(programs / "talaia"), "hub", *where]


def start_home_assistant(programs: Path, folder: Path, port: int) -> list[str]:
    """Start Home Assistant with its web server; what that needs it installs by itself."""
    (folder / "configuration.yaml").write_text(
        f"http:\n  server_host: 127.0.0.1\n  server_port: {port}\n"
    )
    return [str(programs / "hass"), "--config", str(folder)]


def start_indiweb(programs: Path, folder: Path, port: int) -> list[str]:
    """Start INDI's web manager."""
    return [str(programs / "indi-web"), "-v", "-P", str(port), "--fifo", str(folder / "fifo")]


def start_foxglove(programs: Path, folder: Path, port: int) -> list[str]:
    """Start a server of the SDK with no channel."""
    (folder / "serve.py").write_text(FOXGLOVE)
    return [str(programs / "python"), str(folder / "serve.py"), str(port)]


class Seen(NamedTuple):
    """What was measured of one; or why it was not."""

    name: str
    about: str
    version: str = ""
    megabytes: int = 0
    start_s: float = 0.0
    memory_mib: float = 0.0
    percent: float = 0.0
    skipped: str = ""


def measure_peer(peer: Peer) -> Seen:
    """Install, start and look at one; whatever it left is removed."""
    with tempfile.TemporaryDirectory(prefix="talaia-peers-") as name:
        folder = Path(name)
        made = folder / "environment"
        subprocess.run([sys.executable, "-m", "venv", str(made)], check=True)
        programs = made / "bin"
        pip = [str(programs / "python"), "-m", "pip", "install", "--quiet", *peer.install]
        done = subprocess.run(pip, check=False, capture_output=True, text=True)
        if done.returncode:
            return Seen(peer.name, peer.about, skipped=last_words(done.stderr))
        (packages,) = made.glob("lib/python*/site-packages")
        port = free_port()
        data = folder / "data"
        data.mkdir()
        words = peer.start(programs, data, port)
        log = folder / "log"
        with log.open("wb") as file:
            began = time.monotonic()
            process = subprocess.Popen(
                words, cwd=data, stdout=file, stderr=file, start_new_session=True
            )
            try:
                if not answers(port, process):
                    said = last_words(log.read_text(errors="replace"))
                    return Seen(peer.name, peer.about, skipped=said)
                took = time.monotonic() - began
                time.sleep(REST_S)
                family = [psutil.Process(process.pid)]
                family += family[0].children(recursive=True)
                pids = [each.pid for each in family]
                before, since = taps.seconds_used(*pids), time.monotonic()
                time.sleep(LOOK_S)
                used = 100 * (taps.seconds_used(*pids) - before) / (time.monotonic() - since)
                memory = sum(taps.memory_mib(pid) for pid in pids)
            finally:
                end_group(process)
        version = version_in(programs, peer)
        # Last: some install more when they start first.
        size = installed_megabytes(packages)
        return Seen(peer.name, peer.about, version, size, took, memory, used)


def end_group(process: subprocess.Popen[bytes]) -> None:
    """End a program and what it started."""
    for each in psutil.Process(process.pid).children(recursive=True):
        each.kill()
    process.kill()
    process.wait()


def version_in(programs: Path, peer: Peer) -> str:
    """Give the version that was installed."""
    name = {"Talaia, a hub": "talaia", "Home Assistant": "homeassistant"}.get(peer.name, peer.name)
    code = f"from importlib.metadata import version; print(version({name!r}))"
    words = [str(programs / "python"), "-c", code]
    return subprocess.run(words, check=False, capture_output=True, text=True).stdout.strip()


def installed_megabytes(packages: Path) -> int:
    """Give the size of what was installed, with bytecode, without pip and setuptools."""
    for each in ("pip", "setuptools", "pkg_resources", "_distutils_hack"):
        shutil.rmtree(packages / each, ignore_errors=True)
    said = subprocess.run(["du", "-sm", str(packages)], check=True, capture_output=True, text=True)
    return int(said.stdout.split()[0])


def free_port() -> int:
    """Find one."""
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def answers(port: int, process: subprocess.Popen[bytes]) -> bool:
    """Wait until something listens there; no: it ended, or took too long."""
    until = time.monotonic() + PATIENCE_S
    while time.monotonic() < until and process.poll() is None:
        try:
            socket.create_connection(("127.0.0.1", port), 1).close()
        except OSError:
            time.sleep(0.05)
        else:
            return True
    return False


def last_words(text: str) -> str:
    """Give the last line of what was said."""
    lines = [line.strip() for line in text.strip().splitlines() if line.strip()]
    return (lines or ["it says nothing"])[-1][:160]


async def compare_topics() -> list[str]:
    """Hand 20 topics at 100 Hz to one client, in turn by both."""
    async with stack.running(0, tapped=True) as here, stack.publisher(here, TOPICS, RATE):
        found = await taps.side_by_side(here, TOPICS, rounds=2, seconds=8)
    rows = []
    for name, shown in (("talaia", "Talaia: hub and gateway"), ("foxglove-sdk", "foxglove-sdk")):
        used, ages = found[name]
        p50, p99 = np.percentile(ages, [50, 99])
        rows.append(f"| {shown} | {p50:.1f} / {p99:.1f} ms | {used:.0f} % of a core |")
    return rows


def main(arguments: list[str]) -> int:
    """Measure all of them and print the table."""
    with tempfile.TemporaryDirectory(prefix="talaia-wheel-") as folder:
        build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder]
        subprocess.run([*build, str(ROOT)], check=True, stdout=subprocess.DEVNULL)
        (wheel,) = Path(folder).glob("*.whl")
        peers = (
            Peer("Talaia, a hub", (f"{wheel}[hub]",), start_talaia, "no site; TLS, accounts"),
            Peer("foxglove-sdk", ("foxglove-sdk",), start_foxglove, "its server, no channel"),
            Peer("indiweb", ("indiweb",), start_indiweb, "INDI's web manager, no driver"),
            Peer(
                # The last version for the oldest Python that Talaia runs on.
                "Home Assistant", ("homeassistant==2024.3.3",), start_home_assistant,
                "its first start, in which it installs the rest",
            ),
        )  # fmt: skip
        seen = [measure_peer(peer) for peer in peers]
    load = os.getloadavg()[0]
    rows = [
        f"| {each.name} {each.version} | {each.about} | {each.megabytes} MB | {each.start_s:.1f} s "
        f"| {each.memory_mib:.0f} MiB | {each.percent:.1f} % |"
        if not each.skipped
        else f"| {each.name} | *skipped: {each.skipped.replace('|', '/')}* | | | | |"
        for each in seen
    ]
    rows += [f"| {name} | *skipped: {why}* | | | | |" for name, why in NOT_HERE.items()]
    topics = asyncio.run(compare_topics())
    text = "\n".join(
        [
            "# Measured beside others",
            "",
            f"Made by `make bench-peers` in one run, {time.strftime('%Y-%m-%d')}, two cores, load "
            f"{load:.0f} of other work, Python {sys.version.split()[0]}.",
            "",
            "Installed by pip into an empty environment (with bytecode), started empty, left alone "
            f"for {REST_S:.0f} s:",
            "",
            "| what | as what | installed | until it answers | memory | processor at rest |",
            "|---|---|--:|--:|--:|--:|",
            *rows,
            "",
            f"{TOPICS} topics of ROS 2 at {RATE:.0f} Hz to one client of Foxglove's protocol, in "
            "turn, twice 8 s each. Talaia's way has TLS, rights and two processes; foxglove-sdk's "
            "is one, with rclpy, and plain.",
            "",
            "| what | ROS → client, p50 / p99 | processor |",
            "|---|--:|--:|",
            *topics,
            "",
        ]
    )
    print(text)
    if arguments:
        Path(arguments[0]).write_text(text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
