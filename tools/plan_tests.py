"""Which test files run in one process, and which of these groups run beside each other.

Most tests wait: for a robot, a page, a time limit. So more groups run at once than there are cores,
as long as what they compute together does not ask for more cores than there are. What each file
takes and computes stands in `tests/durations.json`.
"""

from __future__ import annotations

import json
import math
import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, Protocol

ROOT = Path(__file__).resolve().parent.parent
DURATIONS = ROOT / "tests" / "durations.json"
CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
# Each is a process of some hundred megabytes, with a site and a browser beside it. With three for
# each core a seventh of the cores stood idle.
MOST_AT_ONCE = 4 * CORES
# Of those that start a whole site each: most of their time is waiting for a robot or a limit.
MOST_WHOLE = 2 * CORES
# Groups do not compute evenly: with no more than the cores asked for, these are often idle.
MOST_LOAD = 1.5 * CORES
# While a group runs that wants calm. It waits for half of the time itself: with what is beside it
# held to half of the cores, a quarter of them stood idle for the first five minutes.
MOST_CALM_LOAD = 0.9 * CORES
# What files compute is known from one machine on one day; how many processes and threads stand in
# line for a core is seen. With more than these for each core the next group waits: all is done no
# sooner for it, and what has a limit in time meets it.
MOST_IN_LINE = 2.0
# The line is judged by its average over so long; what a group adds to it is seen after a while.
LINE_S, SETTLE_S = 6.0, 4.0
# Each process takes some seconds of a core before its first test.
GROUP_S = 200.0

# The quick ring: files that start no server, no browser, no ROS and no database. All files of
# these folders, and each file that says `pytestmark = pytest.mark.pure`.
PURE_FOLDERS = ("tests/model", "tests/wire", "tests/test_clock.py")
PURE = re.compile(r"^pytestmark = .*pytest\.mark\.pure\b", re.MULTILINE)
# Each starts a whole site with browsers: only some of them at a time, see `MOST_WHOLE`.
WHOLE_SITES = ("tests/system",)
# Whose files look at one running demo, which lives as long as their process.
SHARING = (
    "tests/system/test_accounts_in_browser.py",
    "tests/system/test_browser.py",
    "tests/system/test_scripts.py",
    "tests/system/test_takeover.py",
)
# Whose parts talk to each other in real time, and give up on one that is late: they come first. The
# others compute most of what is computed, and it is the same to them when they are done.
HASTY = ("tests/system", "tests/gateway", "tests/sim")
GIVING_WAY, GIVING_WAY_MOST = 5, 10
# What gives way takes of the cores what the others leave, so it asks for less of them.
ASKED = {0: 1.0, GIVING_WAY: 0.7, GIVING_WAY_MOST: 0.3}
# They run two sites side by side themselves: with what runs beside them some of a core stays free.
CALM = (
    "tests/system/cluster/test_rows.py",
    "tests/system/faults/test_rows.py",
    "tests/system/enclosure/test_rows.py",
)
PAGES = "web (pages)"


class Cost(NamedTuple):
    """What a test file takes on a machine that does nothing else.

    Attributes:
        wall: from begin to end (s).
        cpu: CPU time of its process and of those that it starts (s).

    """

    wall: float
    cpu: float


UNKNOWN = Cost(5.0, 3.0)


class GroupProcess(Protocol):
    """A group's process, started or forked.

    Attributes:
        pid: of the process.
        returncode: None until the runner has seen its end.

    """

    pid: int
    returncode: int | None

    def kill(self) -> None:
        """End it."""

    def terminate(self) -> None:
        """Ask it to end."""


@dataclass
class Group:
    """Test files that run in one process, and what has become of them.

    Attributes:
        files: paths below the project's folder.
        wall, cpu: about what it takes and computes (s), see `Cost`.
        whole: it starts a whole site; ``calm``: it wants cores that are not all in use.
        pure: its files are the quick ring's.
        skip: tests not to run, for they have run.
        collected: how many tests its process is to run; None until it says so.
        now: the test that runs; ``since`` (monotonic, s).

    """

    files: list[str]
    wall: float = 0.0
    cpu: float = 0.0
    whole: bool = False
    calm: bool = False
    skip: list[str] = field(default_factory=list)
    pure: bool = False
    number: int = 0
    process: GroupProcess | None = None
    folder: Path = Path()
    read: int = 0
    collected: int | None = None
    now: str = ""
    since: float = 0.0
    done: list[str] = field(default_factory=list)
    failures: int = 0

    @property
    def is_cut_short(self) -> bool:
        """Whether its process, which has ended, has not told of all of its tests.

        One that becomes another program (exec) ends as well as that does.
        """
        return self.files != [PAGES] and (self.collected is None or len(self.done) < self.collected)

    @property
    def load(self) -> float:
        """How many cores it keeps busy, on average."""
        return min(self.cpu / self.wall, float(CORES)) if self.wall else 1.0

    @property
    def niceness(self) -> int:
        """How far its processes give way to those of the other groups (as of ``nice``)."""
        if all(lies_in(file.partition("::")[0], HASTY) for file in self.files):
            return 0
        return GIVING_WAY_MOST if self.pure or self.files == [PAGES] else GIVING_WAY

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


@dataclass
class CoreLine:
    """How many processes and threads run or stand in line for a core, on average of late.

    Attributes:
        average: over the last `LINE_S` or so; older counts weigh less and less.
        source: where Linux shows the count; elsewhere nothing is ever in line.

    """

    average: float = 0.0
    source: Path = Path("/proc/loadavg")

    def look(self, seconds: float) -> None:
        """Count again, so long after the last time (s)."""
        try:
            counts = self.source.read_text().split()[3]
        except OSError:
            return
        # Who reads it runs.
        now = int(counts.partition("/")[0]) - 1
        self.average += (now - self.average) * (1.0 - math.exp(-seconds / LINE_S))

    @property
    def is_long(self) -> bool:
        """Whether another group would only make all others slower."""
        return self.average > MOST_IN_LINE * CORES


def list_files(*, quick: bool) -> list[str]:
    """List the test files of a ring."""
    paths = sorted((ROOT / "tests").rglob("test_*.py"))
    files = [path.relative_to(ROOT).as_posix() for path in paths]
    return [file for file in files if not quick or is_pure(file)]


def is_pure(file: str) -> bool:
    """Tell whether a file is in the quick ring."""
    path = ROOT / file
    return lies_in(file, PURE_FOLDERS) or (path.exists() and bool(PURE.search(path.read_text())))


def lies_in(file: str, folders: tuple[str, ...]) -> bool:
    """Tell whether a file is one of ``folders``, or in one."""
    return any(file == folder or file.startswith(f"{folder}/") for folder in folders)


def make_groups(files: list[str], costs: dict[str, Cost]) -> list[Group]:
    """Put files of one part of the product and one kind together, up to `GROUP_S`.

    The folders in ``tests/hub`` are no groups of their own: each would begin a process.
    """
    groups: list[Group] = []
    last: dict[tuple[str, bool, bool, bool, bool], Group] = {}
    for file in files:
        cost = costs.get(file, UNKNOWN)
        calm, whole, pure = lies_in(file, CALM), lies_in(file, WHOLE_SITES), is_pure(file)
        # The quick ring's need nothing of each other: of all folders together.
        folder = "" if pure else "/".join(file.split("/")[:-1][:2])
        sharing = file in SHARING
        kind = (folder, calm, whole, pure, sharing)
        group = last.get(kind)
        if group is None or (group.wall + cost.wall > GROUP_S and not sharing):
            group = last[kind] = Group([], whole=whole, calm=calm, pure=pure)
            groups.append(group)
        group.files.append(file)
        group.wall += cost.wall
        group.cpu += cost.cpu
    return groups


def pages_group(costs: dict[str, Cost]) -> Group:
    """Give the group of the pages' own tests, which are not pytest's."""
    cost = costs.get(PAGES, Cost(20.0, 20.0))
    return Group([PAGES], cost.wall, cost.cpu)


def in_order(groups: list[Group]) -> list[Group]:
    """Sort: first what may run beside little, then the longest."""
    return sorted(groups, key=lambda group: (not group.calm, -group.wall))


def choose_next(
    waiting: list[Group], running: list[Group], *, line_is_long: bool = False
) -> Group | None:
    """Choose the group to start beside those that run; none while it is better to wait."""
    if not running:
        return waiting[0] if waiting else None
    if len(running) >= (CORES if line_is_long else MOST_AT_ONCE):
        return None
    return next((group for group in waiting if _fits(group, running)), None)


def _fits(group: Group, running: list[Group]) -> bool:
    """Tell whether what runs leaves a group the cores that it needs."""
    together = [*running, group]
    if group.whole and sum(each.whole for each in running) >= MOST_WHOLE:
        return False
    load = sum(each.load * ASKED[each.niceness] for each in together)
    return load <= (MOST_CALM_LOAD if any(each.calm for each in together) else MOST_LOAD)


def read_costs() -> dict[str, Cost]:
    """Read what each test file took when `save_costs` last wrote it down."""
    if not DURATIONS.exists():
        return {}
    return {file: Cost(*cost) for file, cost in json.loads(DURATIONS.read_text()).items()}


def save_costs(spent: dict[str, Cost], known: dict[str, Cost]) -> None:
    """Write down what each file took, beside what is known of others that still exist."""
    kept = {file: known[file] for file in known if file == PAGES or (ROOT / file).exists()}
    lines = (
        f' "{file}": [{cost.wall:.1f}, {cost.cpu:.1f}]'
        for file, cost in sorted((kept | spent).items())
    )
    DURATIONS.write_text("{\n" + ",\n".join(lines) + "\n}\n")
