"""Run the tests: a queue of groups of test files, two at a time, and then the pages' tests.

    .venv/bin/python tools/run_tests.py              all
    .venv/bin/python tools/run_tests.py --quick      the pure ones: under two minutes
    .venv/bin/python tools/run_tests.py ARGUMENTS    pytest alone, with these arguments

Files of one folder make a group, up to about a minute of expected time (`tests/durations.json`,
written by ``--save-durations``); each group is a pytest process. Failures are printed at once, and
every ten seconds where the run is.

A test that failed is repeated once at the end, when nothing else runs. If it passes then it is
*unsteady*: named loudly, with its first failure. At most three unsteady tests let a run pass.

Whatever a group leaves behind is removed: processes, temporary folders, the shared memory of
killed ROS processes. Processes left behind are named.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from leftovers import MARK, end_processes, remove_dead_shared_memory  # noqa: E402

DURATIONS = ROOT / "tests" / "durations.json"
WORKERS = 2
GROUP_S = 60.0
UNKNOWN_S = 5.0
PROGRESS_S = 10.0
# Longer than pytest lets a test take: the process hangs outside of tests.
SILENCE_S = 900.0
MOST_UNSTEADY = 3
# More failures than these are a broken tree; to repeat them would say nothing.
MOST_REPEATED = 25

# The quick ring: files that start no server, no browser, no ROS and no database. All files of
# these folders, and each file that says `pytestmark = pytest.mark.pure`.
PURE_FOLDERS = ("tests/model", "tests/wire", "tests/test_clock.py")
PURE = re.compile(r"^pytestmark = .*pytest\.mark\.pure\b", re.MULTILINE)
# Each starts a whole site with browsers: one of them at a time.
WHOLE_SITES = ("tests/system",)
# They run two sites side by side themselves, or judge what a busy machine decides.
ALONE = ("tests/system/faults/test_rows.py", "tests/system/enclosure/test_rows.py")
PAGES = "web (pages)"


@dataclass
class Group:
    """Test files that run in one process, and what has become of them.

    Attributes:
        files: paths below the project's folder.
        expected: about how long it takes (s).
        whole: no other such group runs beside it; ``alone``: none at all.
        skip: tests not to run, for they have run.
        now: the test that runs; ``since`` (monotonic, s).

    """

    files: list[str]
    expected: float
    whole: bool = False
    alone: bool = False
    skip: list[str] = field(default_factory=list)
    number: int = 0
    process: subprocess.Popen[bytes] | None = None
    folder: Path = Path()
    read: int = 0
    now: str = ""
    since: float = 0.0
    done: list[str] = field(default_factory=list)
    failures: int = 0

    @property
    def name(self) -> str:
        """What the group is called while it runs."""
        first = self.files[0].removeprefix("tests/")
        return first if len(self.files) == 1 else f"{first} and {len(self.files) - 1} more"

    @property
    def report(self) -> Path:
        """Where its tests are written down, see `tests/report_progress.py`."""
        return self.folder / "report.jsonl"

    @property
    def output(self) -> Path:
        """What the process prints."""
        return self.folder / "output.txt"


class Run:
    """One run of one ring.

    Attributes:
        waiting: groups to start, in order; ``running``: those that run.
        failed: first failure's text of each test that failed.
        spent: wall time and CPU time of each file (s).
        cpu: CPU time of all groups that have ended (s).

    """

    def __init__(self, groups: list[Group], folder: Path) -> None:
        """Put temporary files below ``folder``."""
        self._folder = folder
        # Modification times in memory file systems are a little coarser than the clock.
        self._began, self._since = time.monotonic(), time.time() - 1.0
        self._expected = sum(group.expected for group in groups) or 1.0
        self._finished = 0.0
        self._groups = 0
        self.waiting = sorted(groups, key=lambda group: (not group.whole, -group.expected))
        self.running: list[Group] = []
        self.failed: dict[str, str] = {}
        self.spent: dict[str, list[float]] = {}
        self.passed = self.skipped = 0
        self.cpu = 0.0
        self.left: list[str] = []

    def work(self) -> None:
        """Run all groups."""
        printed = time.monotonic()
        while self.waiting or self.running:
            while group := self._next():
                self._start(group)
            time.sleep(0.1)
            for group in list(self.running):
                self._read_report(group)
                self._reap(group)
            if time.monotonic() - printed >= PROGRESS_S:
                printed = time.monotonic()
                self._print_progress()

    def repeat(self, test: str) -> str:
        """Run one test again, with nothing beside it; give its failure's text, or nothing."""
        first = self.failed.pop(test)
        self.waiting = [Group([test], UNKNOWN_S)]
        self.work()
        again = self.failed.pop(test, "")
        self.failed[test] = first
        return again

    def end(self) -> None:
        """End what still runs, and remove everything that the run left behind."""
        for group in self.running:
            if group.process:
                group.process.terminate()
        for group in self.running:
            self.left += end_processes(self._mark(group))
        self.running = []
        removed = remove_dead_shared_memory(self._since)
        if removed.files:
            print(f"{removed.size / 1e6:.0f} MB of dead processes' shared memory removed")
        for words in self.left:
            print(f"LEFT RUNNING, and ended now: {words[:200]}")

    def _next(self) -> Group | None:
        """The next group that may run beside those that do."""
        if len(self.running) >= WORKERS or any(group.alone for group in self.running):
            return None
        whole = any(group.whole for group in self.running)
        others = [each for each in self.waiting if not each.alone and not (each.whole and whole)]
        if others:
            chosen = others[0]
        elif self.waiting and not self.running:
            chosen = self.waiting[0]
        else:
            return None
        self.waiting.remove(chosen)
        return chosen

    def _mark(self, group: Group) -> str:
        return f"{os.getpid()}-{group.number}"

    def _start(self, group: Group) -> None:
        self._groups += 1
        group.number, group.since = self._groups, time.monotonic()
        group.folder = self._folder / str(group.number)
        temporary = group.folder / "tmp"
        temporary.mkdir(parents=True)
        group.report.touch()
        # Database servers run as users of their own and have to find their files there.
        for folder in (group.folder, temporary):
            folder.chmod(0o711)
        words = [sys.executable, "tools/node.py", "run", "test"]
        if group.files != [PAGES]:
            # Two at once write nothing into the tree, so that they do not meet there.
            words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
            words += ["--tb=short", f"--basetemp={group.folder / 'pytest'}"]
            words += group.files
            (group.folder / "skip.json").write_text(json.dumps(group.skip))
        environment = {
            **os.environ,
            MARK: self._mark(group),
            "TMPDIR": str(temporary),
            "TALAIA_TEST_REPORT": str(group.report),
        }
        with group.output.open("wb") as output:
            group.process = subprocess.Popen(
                words, cwd=ROOT, env=environment,
                stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
            )  # fmt: skip
        self.running.append(group)

    def _read_report(self, group: Group) -> None:
        with group.report.open("rb") as file:
            file.seek(group.read)
            lines = file.read()
        lines = lines[: lines.rfind(b"\n") + 1]
        group.read += len(lines)
        for line in lines.splitlines():
            self._note_test(group, json.loads(line))

    def _note_test(self, group: Group, line: dict[str, Any]) -> None:
        group.since = time.monotonic()
        if begun := line.get("begin"):
            group.now = begun
            return
        test = line["end"]
        group.now = ""
        group.done.append(test)
        wall, cpu = self.spent.setdefault(test.partition("::")[0], [0.0, 0.0])
        self.spent[test.partition("::")[0]] = [wall + line["wall"], cpu + line["cpu"]]
        if line["outcome"] == "failed":
            self._fail(group, test, line["text"])
        elif line["outcome"] == "skipped":
            self.skipped += 1
        else:
            self.passed += 1

    def _fail(self, group: Group, test: str, text: str) -> None:
        group.failures += 1
        self.failed[test] = text
        print(f"\n✗ FAILED {test}\n{text}\n", flush=True)

    def _reap(self, group: Group) -> None:
        """See whether a group has ended, or hangs."""
        if group.process is None:
            return
        if time.monotonic() - group.since > SILENCE_S:
            group.process.kill()
        pid, status, usage = os.wait4(group.process.pid, os.WNOHANG)
        if not pid:
            return
        code = group.process.returncode = os.waitstatus_to_exitcode(status)
        self._read_report(group)
        self.running.remove(group)
        self.cpu += usage.ru_utime + usage.ru_stime
        self._finished += group.expected
        self.left += end_processes(self._mark(group))
        if group.files == [PAGES]:
            self.spent[PAGES] = [time.monotonic() - group.since, usage.ru_utime + usage.ru_stime]
        if code not in (0, 1) or (code == 1 and not group.failures):
            self._note_crash(group, code)
        shutil.rmtree(group.folder, ignore_errors=True)

    def _note_crash(self, group: Group, code: int) -> None:
        """A process that ended otherwise than pytest does: the tests that are left run anew."""
        said = group.output.read_text(errors="replace")[-4000:]
        during = group.now
        self._fail(group, during or group.files[0], f"the process ended with {code}:\n{said}")
        if during and len(group.files) > 0:
            skip = [*group.skip, *group.done, during]
            self.waiting.append(
                Group(group.files, group.expected, group.whole, group.alone, skip=skip)
            )
            self._expected += group.expected

    def _print_progress(self) -> None:
        now = []
        for group in self.running:
            seconds = time.monotonic() - group.since
            now.append(f"{(group.now or group.name).removeprefix('tests/')} {seconds:.0f} s")
        share = min(0.99, self._finished / self._expected)
        seconds = int(time.monotonic() - self._began)
        print(
            f"{seconds // 60:3}:{seconds % 60:02}  {share:3.0%}  {self.passed} passed"
            f"  {len(self.failed)} failed  |  {'  |  '.join(now)}",
            flush=True,
        )

    def summary(self) -> str:
        """Say in one line how it went."""
        seconds = int(time.monotonic() - self._began)
        return (
            f"{self.passed} passed, {self.skipped} skipped, {len(self.failed)} failed"
            f" in {seconds // 60}:{seconds % 60:02} min, {self.cpu / 60:.1f} min of CPU"
        )


def list_files(*, quick: bool) -> list[str]:
    """List the test files of a ring."""
    paths = sorted((ROOT / "tests").rglob("test_*.py"))
    files = [path.relative_to(ROOT).as_posix() for path in paths]
    return [file for file in files if not quick or is_pure(file)]


def is_pure(file: str) -> bool:
    """Tell whether a file is in the quick ring."""
    return lies_in(file, PURE_FOLDERS) or bool(PURE.search((ROOT / file).read_text()))


def lies_in(file: str, folders: tuple[str, ...]) -> bool:
    """Tell whether a file is one of ``folders``, or in one."""
    return any(file == folder or file.startswith(f"{folder}/") for folder in folders)


def make_groups(files: list[str], durations: dict[str, float]) -> list[Group]:
    """Put files of one folder and one kind together, up to `GROUP_S`."""
    groups: list[Group] = []
    at: tuple[str, bool, bool] | None = None
    for file in files:
        seconds = durations.get(file, UNKNOWN_S)
        alone, whole = lies_in(file, ALONE), lies_in(file, WHOLE_SITES)
        kind = (file.rpartition("/")[0], alone, whole)
        if not groups or kind != at or groups[-1].expected + seconds > GROUP_S:
            groups.append(Group([], 0.0, whole=whole, alone=alone))
        at = kind
        groups[-1].files.append(file)
        groups[-1].expected += seconds
    return groups


def finish(run: Run) -> int:
    """Repeat what failed; print what is to be known; give the exit code."""
    unsteady: dict[str, str] = {}
    failed: dict[str, str] = dict(run.failed)
    # What is not one test (a file that cannot be read, the pages) is not repeated.
    tests = [test for test in failed if "::" in test]
    if len(tests) <= MOST_REPEATED:
        for test in tests:
            print(f"again, alone: {test}", flush=True)
            if not run.repeat(test):
                unsteady[test] = failed.pop(test)
    run.failed = failed
    for test, text in unsteady.items():
        print(f"\n!!! UNSTEADY: {test} failed, and passed alone. It is to be mended. It said:")
        print(text)
    for test in unsteady:
        print(f"!!! UNSTEADY {test}")
    for test in failed:
        print(f"✗ FAILED {test}")
    if too_many := len(unsteady) > MOST_UNSTEADY:
        print(f"{len(unsteady)} tests were unsteady; at most {MOST_UNSTEADY} may be")
    print(run.summary() + (f", {len(unsteady)} unsteady" if unsteady else ""))
    return 1 if failed or too_many else 0


def save_durations(spent: dict[str, list[float]], known: dict[str, float]) -> None:
    """Write down what each file took, beside what is known of others that still exist."""
    kept = {file: known[file] for file in known if file == PAGES or (ROOT / file).exists()}
    taken = {file: round(wall, 1) for file, (wall, _) in spent.items()}
    text = json.dumps(kept | taken, indent=1, sort_keys=True)
    DURATIONS.write_text(text + "\n")


def print_slowest(spent: dict[str, list[float]]) -> None:
    """Print CPU and wall time for each folder, and the slowest files."""
    folders: dict[str, list[float]] = {}
    for file, (wall, cpu) in spent.items():
        total = folders.setdefault("/".join(file.split("/")[:2]), [0.0, 0.0])
        total[0] += wall
        total[1] += cpu
    for title, rows in (("folders", folders), ("files", spent)):
        print(f"\n{title}: wall, CPU (s)")
        for name, (wall, cpu) in sorted(rows.items(), key=lambda row: -row[1][0])[:25]:
            print(f"{wall:8.1f} {cpu:8.1f}  {name}")


def main(arguments: list[str]) -> int:
    """Give 0 when all passed."""
    parser = argparse.ArgumentParser(description="Run the tests.")
    parser.add_argument("--quick", action="store_true", help="the pure tests only")
    parser.add_argument("--only", nargs="+", help="these files or folders, as a ring runs them")
    parser.add_argument("--save-durations", action="store_true", help="write durations.json")
    parser.add_argument("--times", action="store_true", help="print what took longest")
    chosen, words = parser.parse_known_args(arguments)
    if words:
        pytest = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *words]
        return subprocess.run(pytest, cwd=ROOT, check=False).returncode
    durations = json.loads(DURATIONS.read_text()) if DURATIONS.exists() else {}
    files = list_files(quick=chosen.quick)
    if chosen.only:
        files = [file for file in files if lies_in(file, tuple(chosen.only))]
    groups = make_groups(files, durations)
    if not chosen.quick and not chosen.only:
        groups.append(Group([PAGES], durations.get(PAGES, GROUP_S)))
    # A run that is ended from outside tidies up, too.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    if not os.environ.get("XDG_RUNTIME_DIR"):
        # Groups have temporary folders of their own, and agree about ROS domains here.
        folder = Path(tempfile.gettempdir()) / f"talaia-runtime-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        os.environ["XDG_RUNTIME_DIR"] = str(folder)
    folder = Path(tempfile.mkdtemp(prefix="talaia-tests-"))
    folder.chmod(0o711)
    run = Run(groups, folder)
    try:
        run.work()
        if chosen.save_durations:
            save_durations(run.spent, durations)
        if chosen.times:
            print_slowest(run.spent)
        return finish(run)
    except KeyboardInterrupt:
        print("\nended by hand")
        return 130
    finally:
        with contextlib.suppress(KeyboardInterrupt):
            run.end()
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
