"""`tools/run_tests.py` on a few tests of its own, and what `tests/leftovers.py` removes."""

from __future__ import annotations

import fcntl
import importlib.util
import mmap
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType

import leftovers
import pytest
from patience import PATIENCE_S

ROOT = Path(__file__).resolve().parents[2]
PARTS = (
    "tools/run_tests.py",
    "tools/cpu_times.py",
    "tools/plan_tests.py",
    "tools/forked_pytest.py",
    "tools/measure_coverage.py",
    "tests/fork_server.py",
    "tests/leftovers.py",
    "tests/many_examples.py",
    "tests/report_progress.py",
)
CONFTEST = """\
import report_progress


def pytest_configure(config):
    report_progress.register(config)
"""


def load_plan() -> ModuleType:
    """Load `tools/plan_tests.py`, as on a machine of two cores."""
    spec = importlib.util.spec_from_file_location("plan_tests", ROOT / "tools/plan_tests.py")
    assert spec
    assert spec.loader
    # Its dataclass looks for its module there.
    module = sys.modules["plan_tests"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.CORES, module.MOST_LOAD, module.MOST_AT_ONCE = 2, 2.5, 4
    return module


def run_tests(folder: Path, files: dict[str, str], *words: str) -> tuple[int, str]:
    """Run the runner in a project that has these test files; give its exit code and output."""
    for part in PARTS:
        (folder / part).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / part, folder / part)
    (folder / "pyproject.toml").write_text(
        '[tool.pytest.ini_options]\npythonpath = ["tests"]\n'
        'addopts = ["--import-mode=importlib"]\nmarkers = ["pure: "]\n'
    )
    (folder / "tests/conftest.py").write_text(CONFTEST)
    for name, text in files.items():
        (folder / "tests" / name).parent.mkdir(exist_ok=True)
        (folder / "tests" / name).write_text(text)
    done = subprocess.run(
        [sys.executable, str(folder / "tools/run_tests.py"), "--only", "tests", *words],
        env={**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
        capture_output=True, text=True, check=False, timeout=PATIENCE_S,
    )  # fmt: skip
    return done.returncode, done.stdout + done.stderr


def fails_until(path: Path) -> str:
    """A test that fails the first time."""
    return (
        "from pathlib import Path\n\ndef test_now_and_then():\n"
        f"    path = Path({str(path)!r})\n"
        "    if not path.exists():\n        path.touch()\n        raise AssertionError('a stall')\n"
    )


def test_a_test_that_passes_alone_is_named_as_unsteady_with_its_first_failure(
    tmp_path: Path,
) -> None:
    files = {"test_a.py": fails_until(tmp_path / "seen"), "test_b.py": "def test_b(): pass\n"}
    code, said = run_tests(tmp_path, files)
    assert code == 0, said
    assert "!!! UNSTEADY tests/test_a.py::test_now_and_then" in said
    assert said.count("AssertionError: a stall") >= 2
    assert "2 passed" in said


def test_more_than_three_unsteady_tests_fail_the_run(tmp_path: Path) -> None:
    files = {f"test_{at}.py": fails_until(tmp_path / f"seen{at}") for at in range(4)}
    code, said = run_tests(tmp_path, files)
    assert code == 1
    assert "4 tests were unsteady; at most 3 may be" in said


def test_of_thousands_of_tests_one_in_a_thousand_may_be_unsteady(tmp_path: Path) -> None:
    many = "import pytest\n\n@pytest.mark.parametrize('at', range(4000))\ndef test_many(at): pass\n"
    files = {f"test_{at}.py": fails_until(tmp_path / f"seen{at}") for at in range(4)}
    code, said = run_tests(tmp_path, files | {"test_many.py": many})
    assert code == 0, said
    assert "4004 passed, 0 skipped, 0 failed" in said
    assert "4 unsteady" in said


def test_what_computes_gives_way_to_what_talks_in_real_time(tmp_path: Path) -> None:
    tells = f"import os\ndef test_a(): assert os.nice(0) == min(19, {os.nice(0)} + %d)\n"
    pure = "import pytest\npytestmark = pytest.mark.pure\n"
    files = {
        "system/test_a.py": tells % 0, "hub/test_b.py": tells % 5, "test_c.py": pure + tells % 10
    }  # fmt: skip
    code, said = run_tests(tmp_path, files)
    assert code == 0, said


def test_no_further_group_starts_while_many_stand_in_line_for_a_core(tmp_path: Path) -> None:
    plan, source = load_plan(), tmp_path / "loadavg"
    line = plan.CoreLine(source=source)
    # It is not there on other systems, where nothing is known and nothing held back.
    line.look(1.0)
    assert line.average == 0.0
    # One of those that run is who reads it.
    source.write_text("3.10 2.00 1.00 11/800 4242\n")
    line.look(0.1)
    assert not line.is_long
    for _ in range(300):
        line.look(0.1)
    assert line.average == pytest.approx(10.0, abs=0.1)
    assert line.is_long
    running = [plan.Group([f"tests/{at}.py"], 10.0, 1.0) for at in range(2)]
    further = plan.Group(["tests/hub/test_a.py"], 10.0, 1.0)
    assert plan.choose_next([further], running, line_is_long=True) is None
    assert plan.choose_next([further], running[:1], line_is_long=True) is further
    assert plan.choose_next([further], running) is further
    source.write_text("3.10 2.00 1.00 2/800 4242\n")
    for _ in range(300):
        line.look(0.1)
    assert not line.is_long


def test_a_test_that_fails_again_fails_the_run(tmp_path: Path) -> None:
    code, said = run_tests(tmp_path, {"test_a.py": "def test_a(): assert False\n"})
    assert code == 1
    assert "✗ FAILED tests/test_a.py::test_a\n0 passed, 0 skipped, 1 failed" in said


def test_a_process_that_crashes_fails_the_test_and_the_others_still_run(tmp_path: Path) -> None:
    crash = "import os\ndef test_a(): pass\ndef test_c(): os._exit(7)\ndef test_cc(): pass\n"
    code, said = run_tests(tmp_path, {"test_a.py": crash})
    assert code == 1
    assert "FAILED tests/test_a.py::test_c\nthe process ended with 7" in said
    assert "2 passed, 0 skipped, 1 failed" in said


@pytest.mark.parametrize("ends", ["os.execv('/bin/true', ['true'])", "os._exit(0)"])
def test_a_process_that_ends_well_before_its_tests_are_done_loses_none(
    tmp_path: Path, ends: str
) -> None:
    leaves = f"import os\ndef test_a(): pass\ndef test_c(): {ends}\ndef test_cc(): pass\n"
    code, said = run_tests(tmp_path, {"test_a.py": leaves})
    assert code == 1
    assert "FAILED tests/test_a.py::test_c\nthe process ended with 0" in said
    assert "2 passed, 0 skipped, 1 failed" in said


def test_a_process_that_fails_after_its_tests_have_passed_is_repeated_whole(tmp_path: Path) -> None:
    seen = tmp_path / "seen"
    leaves = (
        "import atexit, os\nfrom pathlib import Path\n\n"
        f"def test_a():\n    seen = Path({str(seen)!r})\n"
        "    if seen.read_text().count('b') < {runs}: atexit.register(os._exit, 1)\n"
    )
    counts = f"from pathlib import Path\ndef test_b(): Path({str(seen)!r}).open('a').write('b')\n"
    for runs, code in ((1, 0), (9, 1)):
        seen.write_text("")
        files = {"test_a.py": leaves.replace("{runs}", str(runs)), "test_b.py": counts}
        ended, said = run_tests(tmp_path, files)
        assert (ended, seen.read_text()) == (code, "bb"), said
        assert ("!!! UNSTEADY" in said) == (code == 0)


def test_a_file_that_cannot_be_read_fails_the_run(tmp_path: Path) -> None:
    code, said = run_tests(tmp_path, {"test_a.py": "import nothing_of_that_name\n"})
    assert code == 1
    assert "nothing_of_that_name" in said


def test_a_process_left_running_is_named_and_ended_and_its_files_go(tmp_path: Path) -> None:
    leave = (
        "import subprocess, sys, tempfile\nfrom pathlib import Path\n"
        "def test_a():\n"
        "    one = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(99)'],\n"
        "                           start_new_session=True)\n"
        f"    Path({str(tmp_path / 'left')!r}).write_text(f'{{one.pid}} {{tempfile.mkdtemp()}}')\n"
        "    one.returncode = 0\n"
    )
    code, said = run_tests(tmp_path, {"test_a.py": leave})
    assert code == 0, said
    assert "LEFT RUNNING, and ended now" in said
    pid, folder = (tmp_path / "left").read_text().split()
    # Whoever adopted it may not have heard of its end yet.
    status = Path(f"/proc/{pid}/status")
    assert not status.exists() or "zombie" in status.read_text()
    assert not Path(folder).exists()


def test_the_quick_ring_has_the_files_that_say_they_are_pure(tmp_path: Path) -> None:
    pure = "import pytest\npytestmark = pytest.mark.pure\ndef test_a(): pass\n"
    files = {"hub/test_a.py": pure, "hub/test_b.py": "def test_b(): pass\n"}
    files["model/test_c.py"] = "def test_c(): pass\n"
    code, said = run_tests(tmp_path, files, "--quick")
    assert code == 0
    assert "2 passed" in said


def test_a_pure_test_that_opens_a_socket_or_starts_a_process_fails(tmp_path: Path) -> None:
    pure = (
        "import socket, subprocess, sys\nimport pytest\npytestmark = pytest.mark.pure\n"
        "def test_a(): socket.create_server(('127.0.0.1', 0))\n"
        "def test_b(): subprocess.run([sys.executable, '-c', ''])\n"
        "def test_c(): pass\n"
    )
    real = (ROOT / "tests/conftest.py").read_text()
    code, said = run_tests(tmp_path, {"conftest.py": real, "test_a.py": pure})
    assert code == 1
    assert "test_a is marked as pure, and calls socket.bind" in said
    assert "test_b is marked as pure, and calls subprocess.Popen" in said
    assert "1 passed, 0 skipped, 2 failed" in said


def test_files_that_share_a_demo_run_in_one_process_however_long_they_take() -> None:
    plan = load_plan()
    files = sorted([*plan.SHARING, "tests/system/test_driving.py", "tests/system/test_up.py"])
    costs = {file: plan.Cost(plan.GROUP_S - 1.0, 20.0) for file in files}
    groups = [each.files for each in plan.make_groups(files, costs)]
    assert sorted(plan.SHARING) in groups
    assert len(groups) == 3
    assert all((ROOT / file).exists() for file in files)


def test_groups_that_wait_run_side_by_side_beyond_the_number_of_cores() -> None:
    plan = load_plan()
    light = [plan.Group([f"tests/gateway/{at}"], wall=60.0, cpu=12.0) for at in range(5)]
    heavy = [plan.Group([f"tests/gateway/h{at}"], wall=60.0, cpu=60.0) for at in range(3)]
    assert plan.choose_next(light, light[:3]) is light[0]
    assert plan.choose_next(light, light[:4]) is None
    assert plan.choose_next(heavy, heavy[:2]) is None
    # What waits does not wait behind what computes.
    assert plan.choose_next([*heavy, *light], heavy[:2]) is light[0]


def test_a_calm_group_and_what_runs_beside_it_leave_some_of_a_core_free() -> None:
    plan = load_plan()
    calm = [plan.Group([f"tests/gateway/c{at}"], wall=60.0, cpu=40.0, calm=True) for at in range(2)]
    light = plan.Group(["tests/gateway/light"], wall=60.0, cpu=40.0)
    heavy = plan.Group(["tests/gateway/heavy"], wall=60.0, cpu=70.0)
    assert plan.choose_next([heavy, light], [calm[0]]) is light
    assert calm[0].load + light.load <= 0.9 * plan.CORES < calm[0].load + heavy.load
    assert plan.choose_next(calm[1:], calm[:1]) is calm[1]
    assert plan.choose_next(calm, [heavy]) is None
    assert plan.choose_next(calm, [light]) is calm[0]


def test_groups_that_give_way_ask_for_less_than_those_that_talk_in_real_time() -> None:
    plan = load_plan()
    hasty = [plan.Group([f"tests/gateway/{at}"], wall=60.0, cpu=60.0) for at in range(2)]
    hub = plan.Group(["tests/hub/a"], wall=60.0, cpu=40.0)
    pure = plan.Group(["tests/model/a"], wall=60.0, cpu=60.0, pure=True)
    assert plan.choose_next([hub], hasty) is hub
    assert plan.choose_next([pure], hasty) is pure
    assert plan.choose_next([*hasty, hub, pure], [*hasty, hub]) is None


def test_no_more_whole_sites_run_than_twice_as_many_as_there_are_cores() -> None:
    plan = load_plan()
    most = 2 * plan.CORES
    sites = [plan.Group([f"{at}"], wall=60.0, cpu=6.0, whole=True) for at in range(most + 1)]
    assert plan.choose_next(sites, sites[: most - 1]) is sites[0]
    assert plan.choose_next(sites, sites[:most]) is None


def old(path: Path) -> Path:
    """Make a file that is no longer new."""
    path.write_bytes(bytes(4096))
    os.utime(path, (time.time() - 60, time.time() - 60))
    return path


def test_shared_memory_of_the_dead_is_removed_and_that_of_the_living_stays(
    tmp_path: Path, monkeypatch
) -> None:
    # ctime cannot be set by hand; the files here are as old as their mtime says.
    monkeypatch.setattr(leftovers, "_changed", lambda status: status.st_mtime)
    dead = [old(tmp_path / "fastdds_0123456789abcdef"), old(tmp_path / "fastdds_port7421")]
    dead += [old(tmp_path / "fastdds_0123456789abcdef_el"), old(tmp_path / "fastdds_port7421_el")]
    dead += [old(tmp_path / "sem.fastdds_port7421_mutex"), old(tmp_path / "fastrtps_00112233")]
    locked = [old(tmp_path / "fastdds_fedcba9876543210")]
    locked += [old(tmp_path / "fastdds_fedcba9876543210_el")]
    mapped = [old(tmp_path / "fastdds_port7999"), old(tmp_path / "sem.fastdds_port7999_mutex")]
    new = tmp_path / "fastdds_aaaaaaaaaaaaaaaa"
    new.touch()
    # Just made, however long this test stands still.
    os.utime(new, (time.time() + 60, time.time() + 60))
    other = [old(tmp_path / "PostgreSQL.1"), old(tmp_path / "sem.mine")]
    with locked[1].open() as lock, mapped[0].open("r+b") as file:
        fcntl.flock(lock, fcntl.LOCK_EX)
        memory = mmap.mmap(file.fileno(), 4096)
        removed = leftovers.remove_dead_shared_memory(folder=tmp_path)
        memory.close()
    assert removed == (6, 6 * 4096)
    assert sorted(tmp_path.iterdir()) == sorted([*locked, *mapped, new, *other])
    assert not any(path.exists() for path in dead)


def test_shared_memory_from_before_the_run_stays(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(leftovers, "_changed", lambda status: status.st_mtime)
    before = old(tmp_path / "fastdds_0123456789abcdef")
    leftovers.remove_dead_shared_memory(time.time() - 30, tmp_path)
    assert before.exists()
