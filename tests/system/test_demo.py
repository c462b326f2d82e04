"""``talaia demo`` as a person meets it: it starts, says how to get in, and ends without a trace."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest
from patience import PATIENCE_S

from .conftest import Demo, start_demo, stop_demo

pytestmark = pytest.mark.robot


def test_the_demo_starts_serves_and_ends_with_everything_it_started(tmp_path: Path) -> None:
    demo = start_demo(tmp_path, "--no-camera")
    try:
        assert set(demo.passwords) == {"admin", "operator", "guest"}
        with urllib.request.urlopen(f"{demo.address}/api/health", timeout=10) as answer:  # noqa: S310 - http, on loopback
            assert answer.status == 200
        family = psutil.Process(demo.process.pid).children(recursive=True)
        assert len(family) >= 3
    finally:
        code = stop_demo(demo)
    assert code == 0
    gone, alive = psutil.wait_procs(family, timeout=10)
    assert alive == []
    assert len(gone) >= 3
    port = int(demo.address.rsplit(":", 1)[1])
    with socket.socket() as probe:
        assert probe.connect_ex(("127.0.0.1", port)) != 0


def _is_zombie(process: psutil.Process) -> bool:
    try:
        return process.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def wait_for(condition: Callable[[], object]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def kill_part(demo: Demo, word: str) -> None:
    """Kill -9 the demo's own hub or gateway."""
    children = psutil.Process(demo.process.pid).children()
    (found,) = [each for each in children if word in each.cmdline()[:4]]
    found.kill()


def test_a_hub_and_a_gateway_of_the_demo_that_are_killed_are_started_again(tmp_path: Path) -> None:
    demo = start_demo(tmp_path, "--no-camera", "--no-observatory")
    try:
        hub, gateway = demo.data / "hub.log", demo.data / "gateway.log"
        kill_part(demo, "hub")
        wait_for(lambda: hub.read_text().count("talaia hub is ready") == 2)
        wait_for(lambda: gateway.read_text().count("linked to") == 2)
        with urllib.request.urlopen(f"{demo.address}/api/health", timeout=10) as answer:  # noqa: S310 - http, on loopback
            assert answer.status == 200
        kill_part(demo, "gateway")
        wait_for(lambda: gateway.read_text().count("linked to") == 3)
        family = psutil.Process(demo.process.pid).children(recursive=True)
    finally:
        demo.process.send_signal(signal.SIGINT)
        said, _ = demo.process.communicate(timeout=PATIENCE_S)
    assert demo.process.returncode == 0
    assert psutil.wait_procs(family, timeout=10)[1] == []
    assert said.count("the hub stopped (exit code -9); it is started again") == 1
    assert said.count("the gateway of the vehicle stopped (exit code -9)") == 1


def test_when_the_demo_is_killed_its_vehicle_does_not_go_on_alone(tmp_path: Path) -> None:
    demo = start_demo(tmp_path, "--no-camera")
    family = psutil.Process(demo.process.pid).children(recursive=True)
    os.kill(demo.process.pid, signal.SIGKILL)
    demo.process.wait(10)
    assert demo.process.stdout is not None
    demo.process.stdout.close()
    _, left = psutil.wait_procs(family, timeout=15)
    # Who ended and was not waited for by its new parent yet does nothing any more.
    alive = [each for each in left if each.is_running() and not _is_zombie(each)]
    for process in alive:
        process.kill()
    assert alive == []


def test_what_somebody_changed_in_a_kept_demo_is_still_so_in_the_next(tmp_path: Path) -> None:
    files = [tmp_path / "agv.yaml", tmp_path / "observatory.yaml"]
    assert stop_demo(start_demo(tmp_path, "--no-camera")) == 0
    untouched = files[0].read_text()
    # In the next demo the same again, and then each with a name of somebody's own.
    assert stop_demo(start_demo(tmp_path, "--no-camera", "--no-observatory")) == 0
    assert files[0].read_text() == untouched
    for each in files:
        text, count = re.subn(r"(?m)^name: .*$", "name: Ours  # chosen by us", each.read_text())
        assert count == 1
        each.write_text(text)
    changed = files[0].read_text()
    demo = start_demo(tmp_path, "--no-camera")
    assert stop_demo(demo) == 0
    assert files[0].read_text() == changed
    assert "name: Ours  # chosen by us" in files[1].read_text()
    assert demo.said.count("was changed in an earlier run and stays so") == 2
    files[0].unlink()
    demo = start_demo(tmp_path, "--no-camera", "--no-observatory")
    assert stop_demo(demo) == 0
    assert files[0].read_text() == untouched
    assert "was changed" not in demo.said


def test_two_demos_side_by_side_have_ports_and_domains_of_their_own(tmp_path: Path) -> None:
    first = start_demo(tmp_path / "one", "--no-camera")
    try:
        second = start_demo(tmp_path / "two", "--no-camera")
        try:
            assert first.address != second.address
            domains = [
                json.loads((each.data / "sim.log").read_text().splitlines()[-1])["domain"]
                for each in (first, second)
            ]
            assert domains[0] != domains[1]
        finally:
            stop_demo(second)
    finally:
        stop_demo(first)


def test_a_port_that_is_taken_is_told_before_anything_starts(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        done = subprocess.run(
            [sys.executable, "-m", "talaia", "demo", "--port", port, "--data", str(tmp_path)],
            capture_output=True, text=True, timeout=60, check=False,
        )  # fmt: skip
    assert done.returncode == 2
    assert f"port {port} is taken; choose another with --port" in done.stderr
    assert list(tmp_path.iterdir()) == []
