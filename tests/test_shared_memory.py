"""Shared memory of dead ROS 2 processes goes; that of living ones, of strangers and ports stays."""

import fcntl
import importlib.util
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from patience import PATIENCE_S
from segments import segments_of, write_crash_row

from talaia.shared_memory import Removed, remove_dead_segments
from talaia.sim import ros_domain

# `make proofs` kills a hundred.
KILLS = 100 if "TALAIA_PROOF_TABLE" in os.environ else 4
NODE = """
import sys
import ros_wheels_bootstrapper
import rclpy
rclpy.init()
node = rclpy.create_node("short_lived", enable_rosout=False, start_parameter_services=False)
print("ready", flush=True)
sys.stdin.read()
"""
ID = "0123456789abcdef"


def segment(folder: Path, name: str = f"fastdds_{ID}", age_s: float = 60.0) -> tuple[Path, Path]:
    path, lock = folder / name, folder / f"{name}_el"
    path.write_bytes(bytes(100_000))
    lock.touch()
    os.utime(lock, (time.time() - age_s,) * 2)
    return path, lock


@pytest.mark.parametrize("name", [f"fastdds_{ID}", f"fastrtps_{ID}"])
def test_a_segment_whose_lock_is_free_goes_with_its_lock(tmp_path: Path, name: str) -> None:
    path, lock = segment(tmp_path, name)
    removed = remove_dead_segments(tmp_path)
    assert removed.segments == 1
    assert removed.size >= 100_000
    assert not path.exists()
    assert not lock.exists()


def test_a_segment_whose_lock_is_held_stays(tmp_path: Path) -> None:
    path, lock = segment(tmp_path)
    with lock.open() as owner:
        fcntl.flock(owner, fcntl.LOCK_EX)
        assert remove_dead_segments(tmp_path) == Removed()
    assert path.exists()
    assert lock.exists()


def test_a_young_segment_stays_and_its_lock_is_not_touched(tmp_path: Path) -> None:
    path, lock = segment(tmp_path, age_s=0.0)
    assert remove_dead_segments(tmp_path) == Removed(young=1)
    assert path.exists()
    assert lock.exists()


@pytest.mark.parametrize(
    "name",
    ["fastdds_port7411", "sem.fastdds_port7411_mutex", "fastdds_short", "other_0123456789abcdef"],
)
def test_ports_and_what_is_not_known_stay(tmp_path: Path, name: str) -> None:
    path, lock = segment(tmp_path, name)
    assert remove_dead_segments(tmp_path) == Removed()
    assert path.exists()
    assert lock.exists()


def test_a_link_leads_nowhere(tmp_path: Path) -> None:
    precious = tmp_path / "precious"
    precious.write_text("kept")
    os.utime(precious, (0, 0))
    (tmp_path / f"fastdds_{ID}_el").symlink_to(precious)
    assert remove_dead_segments(tmp_path) == Removed()
    path, lock = segment(tmp_path, f"fastdds_{ID[::-1]}")
    path.unlink()
    path.symlink_to(precious)
    remove_dead_segments(tmp_path)
    assert precious.read_text() == "kept"
    assert lock.exists()


def test_what_belongs_to_somebody_else_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, lock = segment(tmp_path)
    stranger = os.geteuid() + 1
    monkeypatch.setattr(os, "geteuid", lambda: stranger)
    assert remove_dead_segments(tmp_path) == Removed()
    assert path.exists()
    assert lock.exists()


def test_without_shared_memory_nothing_is_done(tmp_path: Path) -> None:
    assert remove_dead_segments(tmp_path / "absent") == Removed()


def lock_of(path: Path) -> Path:
    return path.with_name(f"{path.name}_el")


def start_node(environment: dict[str, str]) -> subprocess.Popen[bytes]:
    process = subprocess.Popen(
        [sys.executable, "-c", NODE], env={**os.environ, **environment},
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == b"ready\n"
    return process


def end(process: subprocess.Popen[bytes], number: int) -> None:
    process.send_signal(number)
    process.communicate(timeout=PATIENCE_S)


@pytest.mark.robot
@pytest.mark.skipif(not importlib.util.find_spec("rclpy"), reason="ROS 2 (rclpy) is missing")
@pytest.mark.timeout(60 + KILLS * 10)
def test_a_crash_loop_of_ros_nodes_leaves_nothing_and_a_living_one_is_spared() -> None:
    with ros_domain.reserve_domain() as reserved:
        environment = ros_domain.domain_environment(reserved.domain)
        living = start_node(environment)
        try:
            spared, dead = segments_of(living.pid), dict[Path, int]()
            assert spared
            # A frozen owner is no dead one.
            living.send_signal(signal.SIGSTOP)
            for _ in range(KILLS):
                node = start_node(environment)
                dead |= {e: e.stat().st_blocks * 512 for e in segments_of(node.pid)}
                end(node, signal.SIGKILL)
                remove_dead_segments()
            assert len(dead) >= KILLS
            deadline = time.monotonic() + PATIENCE_S
            while any(each.exists() or lock_of(each).exists() for each in dead):
                remove_dead_segments()
                assert time.monotonic() < deadline
            assert all(each.exists() and lock_of(each).exists() for each in spared)
            write_crash_row("ROS 2 node", KILLS, dead)
        finally:
            living.send_signal(signal.SIGCONT)
            end(living, signal.SIGTERM)
