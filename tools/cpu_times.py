"""Where a test run's CPU time goes: by kind of program, and by test file with all that it started.

A process's own count has what it waited for and nothing else: not a browser's renderers, not
programs that were forked for it elsewhere, not a server that runs on. So `/proc` is read each
second. Linux only; elsewhere all tables are empty.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

PROCESSES = Path("/proc")
TICK_S = 1.0 / os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 0.01
# What `fork_server` calls a process that forks programs for the process with this number.
FORKS_FOR = re.compile(r"for (\d+)$")
RUNNER = "(the runner)"
# The first that is found in a command line, or in a name where there is none, says what runs.
KINDS = {
    "run_tests.py": "forked by a test",
    "-m pytest": "forked by a test",
    "--type=renderer": "browser: pages",
    "--type=gpu-process": "browser: drawing",
    "--type=": "browser: network and storage",
    "headless_shell": "browser",
    "headless-shell": "browser",
    "chromium": "browser",
    "playwright": "browser's driver (node)",
    "mariadb": "MariaDB",
    "postgres": "PostgreSQL",
    "initdb": "PostgreSQL",
    "indi": "INDI",
    "mosquitto": "Mosquitto",
    "talaia hub": "hub",
    "talaia gateway": "gateway",
    "talaia sim": "simulator",
    "talaia demo": "talaia demo, up",
    "talaia up": "talaia demo, up",
    "talaia ": "other commands of talaia",
    "/bin/talaia": "other commands of talaia",
    "fork_server": "fork server",
    "vitest": "node",
    "node": "node",
    "pip": "pip, uv",
    "/uv ": "pip, uv",
    "ros": "ROS 1 and 2",
}
# While a process is so young it may still become another program (samples).
YOUNG = 3


class Stat(NamedTuple):
    """Fields of proc_pid_stat(5).

    Attributes:
        name: of the program, at most 15 bytes.
        parent: its process number.
        own: CPU time of the process, without its children (s).
        waited: CPU time of its children that it has waited for, and of theirs (s).
        start: when it began, in ticks: a number may be used again.

    """

    name: str
    parent: int
    own: float
    waited: float
    start: int


@dataclass
class _Process:
    """A process of the run, as it was last seen.

    Attributes:
        kind: see `KINDS`.
        root: the number of the group's process that it belongs to.
        samples: how often it was seen.

    """

    stat: Stat
    kind: str
    root: int
    samples: int = 0


@dataclass
class CpuTimes:
    """Sums CPU time while a run goes on.

    Attributes:
        runner: number of the process below which everything of the run is.
        processes: where the kernel shows them.
        by_kind: CPU time of each kind of program (s).
        by_file: of each test file, by kind (s).
        by_test: of each test (s).

    """

    runner: int
    processes: Path = PROCESSES
    by_kind: Counter[str] = field(default_factory=Counter)
    by_file: dict[str, Counter[str]] = field(default_factory=dict)
    by_test: Counter[str] = field(default_factory=Counter)
    _seen: dict[int, _Process] = field(default_factory=dict)
    _busy: float = 0.0

    def __post_init__(self) -> None:
        """Count from now on."""
        self._busy = -busy_time(self.processes)

    def sample(self, tests: dict[int, str]) -> None:
        """Add what was computed since the last sample.

        Args:
            tests: the test that each group's process runs now, by process number.

        """
        stats = read_stats(self.processes)
        found: dict[int, _Process] = {}
        for pid, stat in stats.items():
            before = self._seen.get(pid)
            if before is not None and before.stat.start == stat.start:
                found[pid] = before
            elif (root := self._root_of(pid, stats, tests)) is not None:
                # It may have begun long ago only where it is the runner.
                born = stat._replace(own=0.0, waited=0.0) if pid != self.runner else stat
                found[pid] = _Process(born, "", root)
        ended: dict[int, list[tuple[int, _Process]]] = {}
        for pid, process in self._seen.items():
            if pid not in found:
                ended.setdefault(process.stat.parent, []).append((pid, process))
        for pid, process in found.items():
            if process.samples < YOUNG:
                folder = self.processes / str(pid)
                process.kind = _kind_of(folder, stats[pid].name, group=pid in tests)
            process.samples += 1
        for pid, process in found.items():
            stat, before_stat = stats[pid], process.stat
            self._add(process.root, process.kind, stat.own - before_stat.own, tests)
            # What a child computed after it was last seen alive; or all, if it never was.
            unseen = stat.waited - before_stat.waited - _known_of(pid, ended)
            children = ended.get(pid)
            kind = children[0][1].kind if children else f"short-lived, of {process.kind}"
            self._add(process.root, kind, max(0.0, unseen), tests)
            process.stat = stat
        self._seen = found

    @property
    def total(self) -> float:
        """CPU time of the whole run so far (s)."""
        return sum(self.by_kind.values())

    def print_tables(self) -> None:
        """Print what was computed, the most first."""
        total = self.total
        print(f"\nCPU time of the run: {total / 60:.1f} min; by kind of program (s):")
        for kind, seconds in self.by_kind.most_common():
            if seconds >= 0.5:
                print(f"{seconds:8.1f}  {kind}")
        others = self._busy + busy_time(self.processes) - total
        print(f"{others:8.1f}  (the rest of this machine, its kernel with it)")
        print("\nCPU time of each test file with all that it started (s):")
        sums = Counter({file: sum(kinds.values()) for file, kinds in self.by_file.items()})
        for file, seconds in sums.most_common(80):
            most = ", ".join(f"{kind} {of:.1f}" for kind, of in self.by_file[file].most_common(5))
            print(f"{seconds:8.1f}  {file}: {most}")
        print("\nCPU time of each test with all that it started (s):")
        for test, seconds in self.by_test.most_common(80):
            print(f"{seconds:8.1f}  {test}")

    def _add(self, root: int, kind: str, seconds: float, tests: dict[int, str]) -> None:
        if seconds <= 0.0:
            return
        test = RUNNER if root == self.runner else tests.get(root, "(between tests)")
        self.by_kind[kind] += seconds
        self.by_file.setdefault(test.partition("::")[0], Counter())[kind] += seconds
        self.by_test[test] += seconds

    def _root_of(self, pid: int, stats: dict[int, Stat], tests: dict[int, str]) -> int | None:
        """Give the group's process that a process descends from; None if it is not of the run."""
        for _ in range(100):
            if pid in tests or pid == self.runner:
                return pid
            known, stat = self._seen.get(pid), stats.get(pid)
            if stat is None:
                return None
            if known is not None and known.stat.start == stat.start and known.root in tests:
                return known.root
            forks = FORKS_FOR.match(stat.name)
            pid = int(forks[1]) if forks else stat.parent
        return None


def _known_of(parent: int, ended: dict[int, list[tuple[int, _Process]]]) -> float:
    """CPU time (s) that is counted already of a process's children that have ended.

    One that ended together with its own children had waited for them first.
    """
    children = ended.get(parent, ())
    return sum(
        process.stat.own + process.stat.waited + _known_of(pid, ended) for pid, process in children
    )


def read_stats(processes: Path) -> dict[int, Stat]:
    """Read all processes of this machine, by number."""
    stats = {}
    for entry in os.scandir(processes) if processes.is_dir() else ():
        if entry.name.isdigit():
            # It may have ended meanwhile.
            with contextlib.suppress(OSError, IndexError):
                text = (processes / entry.name / "stat").read_text(errors="replace")
                stats[int(entry.name)] = parse_stat(text)
    return stats


def parse_stat(text: str) -> Stat:
    """Read a line of proc_pid_stat(5)."""
    front, _, behind = text.rpartition(")")
    # Counted from the third field on: a name may hold spaces and brackets.
    fields = behind.split()
    own, waited = (sum(map(int, fields[at : at + 2])) * TICK_S for at in (11, 13))
    return Stat(front.partition("(")[2], int(fields[1]), own, waited, int(fields[19]))


def find_kind(words: str, name: str) -> str:
    """Say what runs, by a command line and a program's name."""
    for part, kind in KINDS.items():
        if part in words or part in f"{name} ":
            return kind
    return name


def _kind_of(folder: Path, name: str, *, group: bool) -> str:
    if group:
        return "pytest"
    words = b""
    with contextlib.suppress(OSError):
        words = (folder / "cmdline").read_bytes()
    line = words.replace(b"\0", b" ").decode(errors="replace")
    # A forked program has its server's words, and a name of its own.
    if "fork_server.py" in line and name != "python" and not FORKS_FOR.match(name):
        line = ""
    elif "python" in line.partition(" ")[0]:
        # Not the interpreter's path, which may hold any word.
        line = line.partition(" ")[2]
    return find_kind(line, name)


def busy_time(processes: Path) -> float:
    """CPU time that all cores have computed since the machine began (s)."""
    with contextlib.suppress(OSError):
        # proc_stat(5): user, nice, system, idle, iowait, irq, softirq.
        words = (processes / "stat").read_text().splitlines()[0].split()[1:8]
        ticks = [int(word) for word in words]
        return (sum(ticks) - ticks[3] - ticks[4]) * TICK_S
    return 0.0
