"""Texts of a support bundle that are read from this machine: versions, programs, logs, files."""

from __future__ import annotations

import contextlib
import importlib.metadata
import os
import platform
import shutil
import subprocess
from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING

from talaia import __version__
from talaia.cli.examining.doctor import examine_machine
from talaia.cli.examining.host import examine_host

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from talaia.cli.examining.host import RunningProgram
    from talaia.cli.support.redaction import Redactor

__all__ = [
    "cut_lines",
    "describe_doctor",
    "describe_files",
    "describe_programs",
    "describe_versions",
    "environment_of",
    "read_journal",
    "read_log",
]

# Of each log, its last lines, and the beginning of each: long ones are pictures or tracebacks.
_MOST_LINES, _MOST_LETTERS = 2_000, 2_000
_JOURNAL_S = 20.0
_MOST_FILES = 500


def describe_versions() -> str:
    """List Talaia, Python, the machine, and every Python package that is installed."""
    packages = sorted(
        f"{found.metadata['Name']}=={found.version}" for found in importlib.metadata.distributions()
    )
    with contextlib.suppress(OSError):
        release = platform.freedesktop_os_release().get("PRETTY_NAME", "")
        packages.insert(0, f"\nsystem: {release}\n")
    head = [
        f"Talaia {__version__}",
        f"Python {platform.python_version()} ({platform.python_implementation()})",
        f"kernel: {platform.platform()}",
        f"processors: {os.cpu_count()}",
    ]
    return "\n".join([*head, *packages, ""])


def describe_doctor(data: Path, port: int) -> str:
    """Write what `talaia doctor` says."""
    rows = []
    for finding in [*examine_machine(), *examine_host(data, port)]:
        # With its words, which may be secrets; `describe_programs` lists them without.
        if finding.what == "running":
            continue
        rows.append(f"{finding.state}  {finding.what}: {finding.detail}")
        if finding.remedy:
            rows.append(f"      → {finding.remedy}")
    return "\n".join([*rows, ""])


def describe_programs(programs: Iterable[RunningProgram], redactor: Redactor) -> str:
    """List Talaia's programs that run, with their options' names and how much memory they have."""
    # Their words may hold secrets; the names of options tell enough.
    rows = []
    for program in programs:
        words = " ".join(redactor.clean_words(program.words))
        rows.append(f"{program.pid}  {words}  ({_memory_of(program.pid)})")
    return "\n".join([*(rows or ["none runs"]), ""])


def environment_of(pid: int, proc: Path = Path("/proc")) -> dict[str, str]:
    """Give the variables with which a program was started; none where it is another user's."""
    with contextlib.suppress(OSError):
        pairs = (proc / str(pid) / "environ").read_bytes().decode(errors="replace").split("\0")
        return dict(pair.split("=", 1) for pair in pairs if "=" in pair)
    return {}


def read_log(path: Path) -> str:
    """Give the last lines of a log."""
    last: deque[str] = deque(maxlen=_MOST_LINES)
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            last.extend(file)
    except OSError as error:
        return f"cannot be read: {error.strerror}\n"
    return cut_lines(last)


def read_journal() -> str:
    """Give what systemd's journal has of Talaia's units; empty where there is no journal."""
    program = shutil.which("journalctl")
    if program is None:
        return ""
    words = ["--unit", "talaia*", "--lines", str(_MOST_LINES), "--no-pager", "--quiet"]
    words += ["--output", "short-iso", "--utc"]
    try:
        done = subprocess.run(  # noqa: S603 - the system's own program
            [program, *words], capture_output=True, timeout=_JOURNAL_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return cut_lines(done.stdout.decode("utf-8", "replace").splitlines(keepends=True))


def cut_lines(lines: Iterable[str]) -> str:
    """Give lines, each of a bounded length: cleaning a line takes more than its length in time."""
    return "".join(
        line if len(line) <= _MOST_LETTERS else line[:_MOST_LETTERS] + " …\n" for line in lines
    )


def describe_files(data: Path) -> str:
    """List the files of a data folder with their sizes; of large folders the sum."""
    rows = list(_sizes_below(data, data))
    more = f"\n… and {len(rows) - _MOST_FILES} more" if len(rows) > _MOST_FILES else ""
    return "\n".join(rows[:_MOST_FILES]) + more + "\n"


def _sizes_below(folder: Path, data: Path) -> Iterator[str]:
    try:
        paths = sorted(folder.iterdir())
    except OSError as error:
        yield f"{folder.name}: {error.strerror}"
        return
    for path in paths:
        with contextlib.suppress(OSError):
            # Where it leads is not ours.
            if path.is_symlink():
                yield f"{'link':>15}  {path.relative_to(data)}"
            elif path.is_dir() and folder == data:
                files = [found for found in path.rglob("*") if found.is_file()]
                size = sum(found.stat().st_size for found in files)
                yield f"{size:>15,}  {path.relative_to(data)}/ ({len(files)} files)"
            elif path.is_file():
                yield f"{path.stat().st_size:>15,}  {path.relative_to(data)}"


def _memory_of(pid: int) -> str:
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{pid}/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return f"{int(line.split()[1]) // 1024} MiB"
    return "memory not known"
