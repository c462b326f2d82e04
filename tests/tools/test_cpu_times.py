"""`tools/cpu_times.py` on processes as `/proc` shows them, and on real ones against wait4(2)."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]
RUNNER, GROUP, SERVER, HUB, GATEWAY = 10, 20, 30, 40, 50
TEST = "tests/test_a.py::test_one"
BURN = """
import subprocess, sys, time
if sys.argv[1:]:
    subprocess.run([sys.executable, __file__], check=True)
while time.process_time() < 0.4:
    pass
"""


@pytest.fixture(scope="module")
def cpu_times() -> ModuleType:
    spec = importlib.util.spec_from_file_location("cpu_times", ROOT / "tools" / "cpu_times.py")
    assert spec
    assert spec.loader
    # Its dataclass looks for its module there.
    module = sys.modules["cpu_times"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def show(folder: Path, pid: int, name: str, parent: int, own: float, waited: float = 0.0) -> None:
    """Write a process down as proc_pid_stat(5) does; times in seconds."""
    ticks = [round(seconds * os.sysconf("SC_CLK_TCK")) for seconds in (own, waited)]
    place = folder / str(pid)
    place.mkdir(exist_ok=True)
    fields = [parent, 0, 0, 0, 0, 0, 0, 0, 0, 0, ticks[0], 0, ticks[1], 0, 20, 0, 1, 0, 77]
    (place / "stat").write_text(f"{pid} ({name}) S {' '.join(map(str, fields))} 0\n")
    (place / "cmdline").write_bytes(b"")


def hide(folder: Path, pid: int) -> None:
    for file in (folder / str(pid)).iterdir():
        file.unlink()
    (folder / str(pid)).rmdir()


@pytest.fixture
def processes(tmp_path: Path) -> Path:
    """A runner, a group and the server of its forks, and somebody else's process."""
    show(tmp_path, RUNNER, "python", 1, 5.0)
    show(tmp_path, GROUP, "python", RUNNER, 1.0)
    # A name may hold what stands between the fields.
    show(tmp_path, 60, "else) R (where", 1, 100.0)
    show(tmp_path, SERVER, f"for {GROUP}", 1, 0.0)
    return tmp_path


@pytest.fixture
def times(cpu_times: ModuleType, processes: Path):
    found = cpu_times.CpuTimes(RUNNER, processes)
    found.sample({GROUP: TEST})
    return found


def test_what_is_forked_for_a_group_is_of_its_test_and_what_is_not_of_the_run_is_left_out(
    times, processes: Path
) -> None:
    show(processes, HUB, "talaia hub", SERVER, 2.0)
    show(processes, GROUP, "python", RUNNER, 1.5)
    times.sample({GROUP: TEST})
    assert dict(times.by_kind) == pytest.approx({"pytest": 1.5, "hub": 2.0})
    assert dict(times.by_test) == pytest.approx({TEST: 3.5})
    assert times.total == pytest.approx(3.5)


def test_what_ended_between_two_looks_is_counted_once(times, processes: Path) -> None:
    show(processes, HUB, "talaia demo", GROUP, 2.0)
    show(processes, GATEWAY, "talaia gateway", HUB, 3.0)
    times.sample({GROUP: TEST})
    # Both end: the demo has waited for its gateway, and the group for the demo and another program.
    hide(processes, HUB)
    hide(processes, GATEWAY)
    show(processes, GROUP, "python", RUNNER, 1.0, waited=6.0)
    times.sample({GROUP: TEST})
    assert times.total == pytest.approx(1.0 + 6.0)
    show(processes, GROUP, "python", RUNNER, 1.0, waited=6.5)
    times.sample({GROUP: TEST})
    assert times.by_kind["short-lived, of pytest"] == pytest.approx(0.5)


def test_real_processes_compute_what_the_system_says(cpu_times: ModuleType, tmp_path: Path) -> None:
    if not cpu_times.PROCESSES.is_dir():
        pytest.skip("there is no /proc")
    program = tmp_path / "burn.py"
    program.write_text(BURN)
    times = cpu_times.CpuTimes(os.getpid())
    times.sample({})
    process = subprocess.Popen([sys.executable, str(program), "with a child"])
    while not (ended := os.wait4(process.pid, os.WNOHANG))[0]:
        times.sample({process.pid: TEST})
        time.sleep(0.01)
    process.returncode = 0
    times.sample({})
    known = ended[2].ru_utime + ended[2].ru_stime
    assert times.by_test[TEST] == pytest.approx(known, abs=0.2)
