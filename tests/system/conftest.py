"""What the system tests stand on: the demo itself, and a real Chromium."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from browser_program import find_browser
from patience import PATIENCE_MS, PATIENCE_S
from playwright.sync_api import Browser, expect, sync_playwright
from ports import free_port

from .stack import Stack, empty_database

# What must come may take its time on a busy machine; see `patience`.
expect.set_options(timeout=PATIENCE_MS)

REQUIRE_ALL = bool(os.environ.get("TALAIA_REQUIRE_ALL"))
CHROMIUM_FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


class Demo(NamedTuple):
    """A running demo: its address, its accounts, its folder, and what it said."""

    process: subprocess.Popen[str]
    address: str
    passwords: dict[str, str]
    data: Path
    seconds: float
    said: str = ""

    @property
    def actuations(self) -> Path:
        """Where the simulated vehicle writes what it did."""
        return self.data / "actuations.jsonl"


def missing(what: str) -> None:
    """Skip, or fail where nothing may be missing."""
    if REQUIRE_ALL:
        pytest.fail(f"{what} is missing, and TALAIA_REQUIRE_ALL is set")
    pytest.skip(f"{what} is missing")


def need_ros2() -> None:
    """Skip, or fail, where there is no ROS 2."""
    if not __import__("importlib.util").util.find_spec("rclpy"):
        missing("ROS 2 (rclpy)")


def absent_ros1() -> list[str]:
    """Give what of Debian's ROS 1 is not there."""
    packages = ("rospy", "rosgraph", "std_srvs", "geometry_msgs", "sensor_msgs")
    here = [Path("/usr/lib/python3/dist-packages") / each for each in packages]
    return [each.name for each in (*here, Path("/usr/bin/rosmaster")) if not each.exists()]


def need_ros1() -> None:
    """Skip, or fail, where Debian's ROS 1 is not whole."""
    if absent := absent_ros1():
        missing(f"ROS 1 ({', '.join(absent)}; apt install python3-rospy python3-rosmaster)")


def need_indi(*drivers: str) -> None:
    """Skip, or fail, where INDI's server or one of these drivers is missing."""
    absent = [each for each in ("indiserver", *drivers) if shutil.which(each) is None]
    if absent:
        missing(f"INDI ({', '.join(absent)}; apt install indi-bin)")


def start_demo(data: Path, *more: str) -> Demo:
    """Run ``talaia demo`` until it says that it is ready."""
    for module in ("rclpy", "mujoco"):
        if not __import__("importlib.util").util.find_spec(module):
            missing(module)
    # Nights at high speed have a test of their own; here they would only take time.
    return begin_demo("demo", data, "--data", str(data), "--no-time-lapse", *more)


def begin_demo(word: str, folder: Path, *more: str) -> Demo:
    """Run ``talaia WORD`` until it says that it is ready; what it throws away is in ``folder``.

    It gets a port of its own: two that look for the usual one at once may find the same one free.
    """
    port = str(free_port())
    process = subprocess.Popen(
        [sys.executable, "-m", "talaia", word, "--no-browser", "--port", port, *more],
        env={**os.environ, "TMPDIR": str(folder)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    # A demo that says nothing is ended, so that the read below cannot wait for ever.
    alarm = threading.Timer(PATIENCE_S, process.kill)
    alarm.start()
    said = ""
    assert process.stdout is not None
    for line in process.stdout:
        said += line
        if "Ctrl-C" in line:
            break
    alarm.cancel()
    ready = re.search(r"ready \(([\d.]+) s\):\s+(\S+)", said)
    if not ready:
        process.kill()
        process.wait()
        process.stdout.close()
        logs = "".join(f"\n{p.name}:\n{p.read_text()[-2000:]}" for p in folder.rglob("*.log"))
        pytest.fail(f"the demo did not start:\n{said}{logs}")
    passwords = dict(re.findall(r"^    (admin|operator|guest)\s+(\S+)$", said, re.MULTILINE))
    data = re.search(r"data and logs: (\S+)", said)
    assert data is not None
    return Demo(process, ready[2], passwords, Path(data[1]), float(ready[1]), said)


def stop_demo(demo: Demo) -> int:
    """Press Ctrl-C and give the exit code."""
    demo.process.send_signal(signal.SIGINT)
    code = demo.process.wait(PATIENCE_S)
    assert demo.process.stdout is not None
    demo.process.stdout.close()
    return code


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    """One for all files of a process, see ``SHARING`` in `tools/plan_tests.py`.

    These look at the vehicle; the observatory has tests of its own. Nor does anybody look at
    pictures: to draw and detect keeps a core busy.
    """
    folder = tmp_path_factory.mktemp("demo")
    # `test_demo` is about a demo that begins with nothing.
    shutil.copy(empty_database(), folder)
    running = start_demo(folder, "--no-observatory", "--no-camera")
    try:
        yield running
    finally:
        if running.process.poll() is None:
            stop_demo(running)


@pytest.fixture(scope="session")
def chromium() -> str:
    found = find_browser()
    if found is None:
        missing("Chromium")
    return str(found)


def launching(program: str) -> dict[str, object]:
    """How a Chromium is launched; ROS's own libraries are not for it."""
    clean = {key: value for key, value in os.environ.items() if key != "LD_LIBRARY_PATH"}
    return {"executable_path": program, "args": CHROMIUM_FLAGS, "env": clean}


@pytest.fixture(scope="module")
def browser(chromium: str) -> Iterator[Browser]:
    """One for a module: Playwright's loop would be in the way of other modules' own."""
    with sync_playwright() as play, play.chromium.launch(**launching(chromium)) as running:
        yield running


@pytest.fixture
def chrome(browser: Browser) -> Iterator[Browser]:
    """The module's browser; what a test opens in it is closed behind it."""
    yield browser
    for context in browser.contexts:
        context.close()


@contextlib.contextmanager
def running_stack(folders: pytest.TempPathFactory, description: str = "") -> Iterator[Stack]:
    """Run a hub, a gateway and a robot; see `Stack`."""
    for module in ("rclpy", "mujoco"):
        if not __import__("importlib.util").util.find_spec(module):
            missing(module)
    running = Stack(folders.mktemp("stack"), description)
    try:
        yield running
    finally:
        running.close()


@pytest.fixture(scope="module")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stack]:
    with running_stack(tmp_path_factory) as started:
        yield started
