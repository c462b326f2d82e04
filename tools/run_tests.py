"""Run the tests: a queue of groups of test files, some side by side, and the pages' tests.

    .venv/bin/python tools/run_tests.py              all
    .venv/bin/python tools/run_tests.py --quick      the pure ones: under two minutes
    .venv/bin/python tools/run_tests.py --coverage   all, and which lines of Python they cover
    .venv/bin/python tools/run_tests.py ARGUMENTS    pytest alone, with these arguments
    .venv/bin/python tools/run_tests.py --times …    and where all of the CPU time went

Files of one part make a group, up to two minutes of expected time (`tests/durations.json`,
written by ``--save-durations``); each group is a pytest process. `plan_tests` says which run beside
each other. Failures are printed at once, and every ten seconds where the run is.

A test that failed is repeated once at the end, when nothing else runs. If it passes then it is
*unsteady*: named loudly, with its first failure. A run with more than three unsteady tests, and
more than one in a thousand, fails.

Whatever a group leaves behind is removed: processes, temporary folders, the shared memory of
killed ROS processes. Processes left behind are named.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests")]

import fork_server  # noqa: E402
import measure_coverage  # noqa: E402
from cpu_times import PROCESSES, CpuTimes, busy_time  # noqa: E402
from forked_pytest import fork_pytest, import_everything  # noqa: E402
from leftovers import MARK, end_processes, remove_dead_shared_memory  # noqa: E402
from plan_tests import (  # noqa: E402
    CORES,
    PAGES,
    SETTLE_S,
    UNKNOWN,
    CoreLine,
    Cost,
    Group,
    choose_next,
    in_order,
    lies_in,
    list_files,
    make_groups,
    pages_group,
    read_costs,
    save_costs,
)

PYTEST = [sys.executable, "-m", "pytest"]
PROGRESS_S = 10.0
LOOK_S = 0.1
# How often `--times` looks at all processes, which takes some 10 ms, and how often it is done else.
# What lives shorter is counted when it is waited for, without its name.
SAMPLE_S = 1.0
SELDOM_S = 5.0
# Longer than pytest lets a test take: the process hangs outside of tests.
SILENCE_S = 900.0
MOST_UNSTEADY = 3
# Of thousands, some meet a moment in which a slow machine does nothing: one of so many may.
STEADY_FOR_EACH_UNSTEADY = 1000
# From so many groups on it pays to import everything once for all of them.
FORKING_GROUPS = 4
# More failures than these are a broken tree; to repeat them would say nothing.
MOST_REPEATED = 25


class Run:
    """One run of one ring.

    Attributes:
        waiting: groups to start, in order; ``running``: those that run.
        failed: first failure's text of each test that failed.
        ended_badly: files of processes that failed after all of their tests had passed, by the
            first of them.
        spent: wall time and CPU time of each file (s); ``tests``: of each test.
        cpu: CPU time of all groups that have ended (s).

    """

    def __init__(self, groups: list[Group], folder: Path, *, measure_all: bool) -> None:
        """Put temporary files below ``folder``; measure the coverage of all groups, or of some."""
        self._folder = folder
        self._measure_all = measure_all
        # Modification times in memory file systems are a little coarser than the clock.
        self._began, self._since = time.monotonic(), time.time() - 1.0
        self._expected = sum(group.wall for group in groups) or 1.0
        self._finished = 0.0
        self._groups = 0
        self.waiting = in_order(groups)
        self.running: list[Group] = []
        self.failed: dict[str, str] = {}
        self.ended_badly: dict[str, list[str]] = {}
        self.spent: dict[str, Cost] = {}
        self.tests: dict[str, Cost] = {}
        self.passed = self.skipped = 0
        self.cpu = 0.0
        self.left: list[str] = []
        self.times = CpuTimes(os.getpid())
        self._line, self._started = CoreLine(), 0.0
        self._busy, self._busy_since = busy_time(PROCESSES), self._began
        self.sample_s = SELDOM_S

    def work(self) -> None:
        """Run all groups."""
        printed = sampled = time.monotonic()
        while self.waiting or self.running:
            while group := self._choose_group():
                self.waiting.remove(group)
                self._start(group)
            time.sleep(LOOK_S)
            self._line.look(LOOK_S)
            for group in list(self.running):
                self._read_report(group)
                self._reap(group)
            if time.monotonic() - sampled >= self.sample_s:
                sampled = time.monotonic()
                self.times.sample(
                    {
                        group.process.pid: group.now or f"(between tests) {group.files[0]}"
                        for group in self.running
                        if group.process
                    }
                )
            if time.monotonic() - printed >= PROGRESS_S:
                printed = time.monotonic()
                self._print_progress()

    def _choose_group(self) -> Group | None:
        """Choose what to start now; beside others one after the other, to see what each adds."""
        if len(self.running) >= CORES and time.monotonic() - self._started < SETTLE_S:
            return None
        return choose_next(self.waiting, self.running, line_is_long=self._line.is_long)

    def repeat(self, test: str) -> str:
        """Run one test again, with nothing beside it; give its failure's text, or nothing.

        Of a process that ended badly after its tests had passed: all of its files.
        """
        first = self.failed.pop(test)
        self.waiting = [Group(self.ended_badly.pop(test, [test]), *UNKNOWN)]
        self.work()
        again = self.failed.pop(test, "")
        self.failed[test] = first
        return again

    def costs(self) -> dict[str, Cost]:
        """Give what each file took, with what was computed for it by others' children."""
        seen = {file: sum(kinds.values()) for file, kinds in self.times.by_file.items()}
        return {
            file: Cost(cost.wall, max(cost.cpu, seen.get(file, 0.0)))
            for file, cost in self.spent.items()
        }

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

    def _mark(self, group: Group) -> str:
        return f"{os.getpid()}-{group.number}"

    def _start(self, group: Group) -> None:
        self._groups += 1
        self._started = time.monotonic()
        group.number, group.since = self._groups, time.monotonic()
        group.folder = self._folder / str(group.number)
        temporary = group.folder / "tmp"
        temporary.mkdir(parents=True)
        group.report.touch()
        # Database servers run as users of their own and have to find their files there.
        for folder in (group.folder, temporary):
            folder.chmod(0o711)
        (group.folder / "skip.json").write_text(json.dumps(group.skip))
        words = self._words_of(group)
        environment = {
            **os.environ,
            MARK: self._mark(group),
            "TMPDIR": str(temporary),
            **measure_coverage.environment(self._folder),
            "TALAIA_TEST_REPORT": str(group.report),
        }
        # Hundreds of processes would compile the same modules, each for itself.
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        if words[:3] == PYTEST and fork_server.is_used():
            group.process = fork_pytest(words[3:], environment, group.output)
        else:
            with group.output.open("wb") as output:
                group.process = subprocess.Popen(
                    words, cwd=ROOT, env=environment,
                    stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                )  # fmt: skip
        # What it starts inherits it. It may have ended already; its end is read as of any other.
        # Counted from this process's own, which may itself have been started as giving way.
        with contextlib.suppress(ProcessLookupError):
            os.setpriority(os.PRIO_PROCESS, group.process.pid, os.nice(0) + group.niceness)
        self.running.append(group)

    def _words_of(self, group: Group) -> list[str]:
        """Give the command that runs a group, with its coverage measured where it is to be."""
        measurable = measure_coverage.is_measurable(pages=group.files == [PAGES])
        if group.files == [PAGES]:
            words = [sys.executable, "tools/node.py", "run", "test"]
            if measurable:
                reports = measure_coverage.report_folder(self._folder)
                words += ["--", "--coverage", f"--coverage.reportsDirectory={reports}"]
            return words
        words = list(PYTEST)
        if measurable and (self._measure_all or group.pure):
            words = measure_coverage.words_before("pytest", processes=self._measure_all)
        # Two at once write nothing into the tree, so that they do not meet there.
        words += ["-q", "-p", "no:cacheprovider"]
        words += ["--tb=short", f"--basetemp={group.folder / 'pytest'}"]
        return words + group.files

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
        if "collected" in line:
            group.collected = line["collected"]
            return
        if begun := line.get("begin"):
            group.now = begun
            return
        test = line["end"]
        group.now = ""
        group.done.append(test)
        self._add_cost(test.partition("::")[0], line["wall"], line["cpu"])
        self.tests[test] = Cost(line["wall"], line["cpu"])
        if line["outcome"] == "failed":
            self._fail(group, test, line["text"])
        elif line["outcome"] == "skipped":
            self.skipped += 1
        else:
            self.passed += 1

    def _add_cost(self, file: str, wall: float, cpu: float) -> None:
        before = self.spent.get(file, Cost(0.0, 0.0))
        self.spent[file] = Cost(before.wall + wall, before.cpu + cpu)

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
        self._finished += group.wall
        self.left += end_processes(self._mark(group))
        if group.files == [PAGES]:
            wall = time.monotonic() - group.since
            self._add_cost(PAGES, wall, usage.ru_utime + usage.ru_stime)
        if code not in (0, 1) or (code == 1 and not group.failures) or group.is_cut_short:
            self._note_crash(group, code)
        shutil.rmtree(group.folder, ignore_errors=True)

    def _note_crash(self, group: Group, code: int) -> None:
        """A process that ended otherwise than pytest does: the tests that are left run anew."""
        said = group.output.read_text(errors="replace")[-4000:]
        during = group.now
        if not during and group.done:
            # All passed, and what they left behind (a socket, say) is found at the end of them.
            self.ended_badly[group.files[0]] = group.files
        self._fail(group, during or group.files[0], f"the process ended with {code}:\n{said}")
        if during and len(group.files) > 0:
            skip = [*group.skip, *group.done, during]
            rest = Group(
                group.files, group.wall, group.cpu, group.whole, group.calm, skip, group.pure
            )
            self.waiting.append(rest)
            self._expected += group.wall

    def _print_progress(self) -> None:
        now = []
        for group in self.running:
            seconds = time.monotonic() - group.since
            now.append(f"{(group.now or group.name).removeprefix('tests/')} {seconds:.0f} s")
        share = min(0.99, self._finished / self._expected)
        at, busy = time.monotonic(), busy_time(PROCESSES)
        # By whatever else this machine does, too; nothing where that is not shown.
        used = (busy - self._busy) / (at - self._busy_since)
        self._busy, self._busy_since = busy, at
        seconds = int(at - self._began)
        print(
            f"{seconds // 60:3}:{seconds % 60:02}  {share:3.0%}  {self.passed} passed"
            f"  {len(self.failed)} failed  {used:.1f} cores  |  {'  |  '.join(now)}",
            flush=True,
        )

    def summary(self) -> str:
        """Say in one line how it went."""
        seconds = int(time.monotonic() - self._began)
        # Where processes cannot be looked at: of those alone that the groups waited for.
        cpu = max(self.cpu, self.times.total)
        return (
            f"{self.passed} passed, {self.skipped} skipped, {len(self.failed)} failed"
            f" in {seconds // 60}:{seconds % 60:02} min, {cpu / 60:.1f} min of CPU"
        )


def finish(run: Run) -> int:
    """Repeat what failed; print what is to be known; give the exit code."""
    unsteady: dict[str, str] = {}
    failed: dict[str, str] = dict(run.failed)
    # What is not one test (a file that cannot be read, the pages) is not repeated.
    tests = [test for test in failed if "::" in test or test in run.ended_badly]
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
    most = max(MOST_UNSTEADY, run.passed // STEADY_FOR_EACH_UNSTEADY)
    if too_many := len(unsteady) > most:
        print(f"{len(unsteady)} tests were unsteady; at most {most} may be")
    print(run.summary() + (f", {len(unsteady)} unsteady" if unsteady else ""))
    return 1 if failed or too_many else 0


def print_slowest(spent: dict[str, Cost], tests: dict[str, Cost]) -> None:
    """Print CPU and wall time for each folder, and the files and tests that compute most."""
    folders: dict[str, Cost] = {}
    for file, cost in spent.items():
        folder = file.rpartition("/")[0] or file
        before = folders.get(folder, Cost(0.0, 0.0))
        folders[folder] = Cost(before.wall + cost.wall, before.cpu + cost.cpu)
    for title, rows in (("folders", folders), ("files", spent), ("tests", tests)):
        print(f"\n{title}: wall, CPU (s)")
        for name, cost in sorted(rows.items(), key=lambda row: -row[1].cpu)[:40]:
            print(f"{cost.wall:8.1f} {cost.cpu:8.1f}  {name}")


def run_pytest(words: list[str], *, times: bool) -> int:
    """Run pytest alone, with these arguments; give its exit code."""
    process = subprocess.Popen([*PYTEST, "-p", "no:cacheprovider", *words], cwd=ROOT)
    if times:
        spent = CpuTimes(os.getpid())
        while process.poll() is None:
            spent.sample({process.pid: " ".join(words)})
            time.sleep(SAMPLE_S / 5)
        spent.print_tables()
    return process.wait()


def main(arguments: list[str]) -> int:
    """Give 0 when all passed."""
    parser = argparse.ArgumentParser(description="Run the tests.")
    parser.add_argument("--quick", action="store_true", help="the pure tests only")
    parser.add_argument("--only", nargs="+", help="these files or folders, as a ring runs them")
    parser.add_argument("--save-durations", action="store_true", help="write durations.json")
    parser.add_argument("--coverage", action="store_true", help="measure all files' coverage")
    parser.add_argument("--times", action="store_true", help="print what took longest")
    chosen, words = parser.parse_known_args(arguments)
    if words:
        return run_pytest(words, times=chosen.times)
    # Forks are where this process is.
    os.chdir(ROOT)
    costs = read_costs()
    files = list_files(quick=chosen.quick)
    if chosen.only:
        files = [file for file in files if lies_in(file, tuple(chosen.only))]
    groups = make_groups(files, costs)
    if not chosen.quick and not chosen.only:
        groups.append(pages_group(costs))
    # A shell's background job ignores it, and so would the programs that tests interrupt.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # A run that is ended from outside tidies up, too.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    if not os.environ.get("XDG_RUNTIME_DIR"):
        # Groups have temporary folders of their own, and agree about ROS domains here.
        folder = Path(tempfile.gettempdir()) / f"talaia-runtime-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        os.environ["XDG_RUNTIME_DIR"] = str(folder)
    folder = Path(tempfile.mkdtemp(prefix="talaia-tests-"))
    folder.chmod(0o711)
    run = Run(groups, folder, measure_all=chosen.coverage)
    run.sample_s = SAMPLE_S if chosen.times else SELDOM_S
    ancestor = None
    many = len(groups) >= FORKING_GROUPS
    if many and fork_server.is_used() and not chosen.quick and not chosen.coverage:
        os.environ[fork_server.ANCESTOR] = str(folder / "forks")
        ancestor = fork_server.start_ancestor(folder / "forks")
        import_everything(ROOT)
    try:
        run.work()
        if chosen.save_durations:
            save_costs(run.costs(), costs)
        if chosen.times:
            print_slowest(run.spent, run.tests)
            run.times.print_tables()
        code = finish(run)
        covered = measure_coverage.print_shares(
            folder, everything=chosen.coverage, whole_ring=not chosen.only
        )
        return code or int(not covered)
    except KeyboardInterrupt:
        print("\nended by hand")
        return 130
    finally:
        if ancestor is not None:
            ancestor.terminate()
            ancestor.wait()
        with contextlib.suppress(KeyboardInterrupt):
            run.end()
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
