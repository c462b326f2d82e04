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
from typing import NamedTuple

import psutil
import pytest
from patience import PATIENCE_S

from .conftest import Demo, start_demo, stop_demo

pytestmark = pytest.mark.robot


class Ended(NamedTuple):
    """A demo of which something was seen, and which was ended with Ctrl-C."""

    demo: Demo
    family: list[psutil.Process]
    code: int
    # What it printed behind the greeting, and the vehicle's description that it left.
    said: str
    description: str


def is_served(demo: Demo) -> bool:
    with urllib.request.urlopen(f"{demo.address}/api/health", timeout=10) as answer:  # noqa: S310 - http, on loopback
        return bool(answer.status == 200)


def said_last(demo: Demo, log: str) -> dict[str, object]:
    """Give what a simulator said when it was ready."""
    lines = (demo.data / log).read_text().splitlines()
    return dict(json.loads([line for line in lines if line.startswith("{")][-1]))


def end_demo(demo: Demo) -> Ended:
    """Press Ctrl-C; gives all that it had started until then."""
    family = psutil.Process(demo.process.pid).children(recursive=True)
    demo.process.send_signal(signal.SIGINT)
    said, _ = demo.process.communicate(timeout=PATIENCE_S)
    description = (demo.data / "agv.yaml").read_text()
    return Ended(demo, family, demo.process.returncode, said, description)


def assert_gone(family: list[psutil.Process]) -> None:
    gone, alive = psutil.wait_procs(family, timeout=PATIENCE_S)
    # Who ended and was not waited for by its new parent yet does nothing any more.
    alive = [each for each in alive if each.is_running() and not _is_zombie(each)]
    # Said by their words: numbers of processes mean nothing to who reads of it later.
    words = [" ".join(each.cmdline()) for each in alive]
    for process in alive:
        process.kill()
    assert words == []
    assert len(gone) >= 3


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


# To start all of it costs most here: each demo serves several tests, in the order of a kept folder.


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a demo that is kept."""
    return tmp_path_factory.mktemp("kept")


@pytest.fixture(scope="module")
def first(kept: Path) -> Ended:
    """The demo's first run, of vehicle and observatory."""
    demo = start_demo(kept, "--no-camera")
    try:
        assert set(demo.passwords) == {"admin", "operator", "guest"}
        assert is_served(demo)
    finally:
        ended = end_demo(demo)
    return ended


@pytest.fixture(scope="module")
def second(kept: Path, first: Ended) -> Ended:
    """Its second run, of the vehicle alone, in which hub and gateway are killed."""
    assert first.code == 0
    demo = start_demo(kept, "--no-camera", "--no-observatory")
    try:
        hub, gateway = demo.data / "hub.log", demo.data / "gateway.log"
        before = {log: log.read_text() for log in (hub, gateway)}

        def since(log: Path, words: str) -> int:
            return log.read_text().removeprefix(before[log]).count(words)

        kill_part(demo, "hub")
        wait_for(lambda: since(hub, "talaia hub is ready") == 1)
        wait_for(lambda: since(gateway, "linked to") == 1)
        assert is_served(demo)
        kill_part(demo, "gateway")
        wait_for(lambda: since(gateway, "linked to") == 2)
    finally:
        ended = end_demo(demo)
    return ended


class SideBySide(NamedTuple):
    """The kept demo's third run with descriptions of somebody's own, and another beside it."""

    third: Ended
    addresses: list[str]
    domains: list[object]
    # What the other had started when it was killed, and how its camera draws.
    orphans: list[psutil.Process]
    camera: object
    # The vehicle's description as it was changed.
    changed: str


@pytest.fixture(scope="module")
def side_by_side(kept: Path, second: Ended, tmp_path_factory: pytest.TempPathFactory) -> SideBySide:
    assert second.code == 0
    for each in (kept / "agv.yaml", kept / "observatory.yaml"):
        text, count = re.subn(r"(?m)^name: .*$", "name: Ours  # chosen by us", each.read_text())
        assert count == 1
        each.write_text(text)
    changed = (kept / "agv.yaml").read_text()
    third = start_demo(kept, "--no-camera")
    orphans: list[psutil.Process] = []
    try:
        # As a person starts it: with its camera, too.
        other = start_demo(tmp_path_factory.mktemp("other"))
        orphans = psutil.Process(other.process.pid).children(recursive=True)
        said = [said_last(each, "sim.log") for each in (third, other)]
        os.kill(other.process.pid, signal.SIGKILL)
        other.process.wait(10)
        assert other.process.stdout is not None
        other.process.stdout.close()
    finally:
        ended = end_demo(third)
    addresses, domains = [third.address, other.address], [each["domain"] for each in said]
    return SideBySide(ended, addresses, domains, orphans, said[1]["camera"], changed)


def test_the_demo_starts_serves_and_ends_with_everything_it_started(first: Ended) -> None:
    assert first.code == 0
    assert_gone(first.family)
    port = int(first.demo.address.rsplit(":", 1)[1])
    with socket.socket() as probe:
        assert probe.connect_ex(("127.0.0.1", port)) != 0


def test_a_hub_and_a_gateway_of_the_demo_that_are_killed_are_started_again(second: Ended) -> None:
    assert second.code == 0
    assert_gone(second.family)
    assert second.said.count("the hub stopped (exit code -9); it is started again") == 1
    assert second.said.count("the gateway of the vehicle stopped (exit code -9)") == 1


def test_when_the_demo_is_killed_its_vehicle_does_not_go_on_alone(
    side_by_side: SideBySide,
) -> None:
    assert side_by_side.camera
    assert_gone(side_by_side.orphans)


def test_two_demos_side_by_side_have_ports_and_domains_of_their_own(
    side_by_side: SideBySide,
) -> None:
    assert len(set(side_by_side.addresses)) == 2
    assert len(set(side_by_side.domains)) == 2


def test_what_somebody_changed_in_a_kept_demo_is_still_so_in_the_next(
    kept: Path, first: Ended, second: Ended, side_by_side: SideBySide
) -> None:
    files = [kept / "agv.yaml", kept / "observatory.yaml"]
    # In the next demo the same again, and then each with a name of somebody's own.
    assert second.description == first.description
    third = side_by_side.third
    assert third.code == 0
    assert third.description == side_by_side.changed
    assert "name: Ours  # chosen by us" in files[1].read_text()
    assert third.demo.said.count("was changed in an earlier run and stays so") == 2
    files[0].unlink()
    fourth = start_demo(kept, "--no-camera", "--no-observatory")
    assert stop_demo(fourth) == 0
    assert files[0].read_text() == first.description
    assert "was changed" not in fourth.said


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
