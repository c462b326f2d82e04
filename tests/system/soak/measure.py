"""What hub and gateway use at one moment: memory, descriptors, threads, tasks, and room on disk."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import psutil

from ..faults.world import World
from ..stack import Process

__all__ = ["Measure"]

MIB = 2**20
TASKS = re.compile(r"usage: tasks (\d+)")
CACHED = re.compile(r"usage: .*, cached (\d+\.\d+) MiB")
SHARED = Path("/dev/shm")
# How much of a log's end is searched for the last answer.
TAIL = 65_536


class Measure:
    """Looks at one world again and again.

    Attributes:
        cpu_s: processor time that all its processes have taken so far (s).

    """

    def __init__(self, world: World) -> None:
        """Look at the processes of a world as they are at each moment."""
        self._world = world
        self._segments: set[Path] = set()
        self._cpu: dict[tuple[int, float], float] = {}

    @property
    def cpu_s(self) -> float:
        own = os.times()
        return sum(self._cpu.values()) + own.user + own.system

    def figures(self) -> dict[str, float]:
        """Give all figures that cost little, by name."""
        found: dict[str, float] = {}
        for name, part in (("hub", self._world.hub), ("gateway", self._world.gateway)):
            with contextlib.suppress(psutil.Error, OSError):
                found |= {f"{name}: {what}": n for what, n in _process(part).items()}
        self._count_cpu()
        self.remember_segments()
        segments = [each for each in self._segments if each.exists()]
        found["/dev/shm, MiB"] = sum(map(_size, segments)) / MIB
        found["/dev/shm, files"] = len(segments)
        found |= self._disk()
        return found

    def ask_tasks(self) -> None:
        """Ask hub and gateway for their usage; they must run and handle the signal already."""
        for part in (self._world.hub, self._world.gateway):
            if part.popen.poll() is None and _handles_usr1(part.popen.pid):
                part.popen.send_signal(signal.SIGUSR1)

    def tables(self) -> dict[str, int]:
        """Give the number of rows of each table of the hub's database."""
        path = self._world.hub_data / "talaia.db"
        with (
            contextlib.suppress(sqlite3.Error),
            closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as database,
        ):
            names = database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
            return {
                name: database.execute(f'SELECT count(*) FROM "{name}"').fetchone()[0]  # noqa: S608
                for (name,) in names.fetchall()
            }
        return {}

    def remember_segments(self) -> None:
        """Remember which shared memory is ours; to be done before each kill, too."""
        parts = (self._world.gateway, self._world.robot)
        for process in (each for part in parts for each in _family(part)):
            with contextlib.suppress(OSError):
                for line in Path(f"/proc/{process.pid}/maps").read_text().splitlines():
                    path = line.partition("/dev/shm/")[2]
                    if path:
                        name = path.removesuffix(" (deleted)")
                        self._segments |= {SHARED / name, SHARED / f"{name}_el"}

    def _disk(self) -> dict[str, float]:
        world = self._world
        hub, gateway = world.hub_data, world.gateway_data
        logs = [world.folder / "hub.log", world.folder / "gateway.log"]
        return {
            "hub: WAL, MiB": _size(hub / "talaia.db-wal") / MIB,
            "hub: database, MiB": _size(hub / "talaia.db") / MIB,
            "gateway: spool, MiB": sum(map(_size, (gateway / "spool").rglob("*"))) / MIB,
            "gateway: all else it keeps, MiB": sum(
                _size(each) for each in gateway.rglob("*") if "spool" not in each.parts
            )
            / MIB,
            "logs, MiB": sum(map(_size, logs)) / MIB,
        }

    def _count_cpu(self) -> None:
        world = self._world
        for part in (world.hub, world.gateway, world.robot):
            for process in _family(part):
                with contextlib.suppress(psutil.Error):
                    times = process.cpu_times()
                    self._cpu[process.pid, process.create_time()] = times.user + times.system


def _family(part: Process) -> Iterator[psutil.Process]:
    """Give a process and its children, as long as it runs."""
    with contextlib.suppress(psutil.Error):
        process = psutil.Process(part.popen.pid)
        yield process
        yield from process.children(recursive=True)


def _process(part: Process) -> dict[str, float]:
    family = [each.pid for each in _family(part)]
    found = {
        "memory (RSS), MiB": sum(_kib(each, "status", "VmRSS") for each in family) / 1024,
        # Its share of what is in no file: pages of a library count for fewer when others end.
        "memory (anonymous), MiB": sum(_kib(pid, "smaps_rollup", "Pss_Anon") for pid in family)
        / 1024,
        "descriptors": sum(len(os.listdir(f"/proc/{each}/fd")) for each in family),
        "threads": sum(len(os.listdir(f"/proc/{each}/task")) for each in family),
    }
    log = _end_of(part)
    if said := TASKS.findall(log):
        found["tasks"] = float(said[-1])
    if said := CACHED.findall(log):
        found["cache of what was read, MiB"] = float(said[-1])
    return found


def _end_of(part: Process) -> str:
    """Give the end of what this life of a process has said."""
    with part.log.open("rb") as file:
        file.seek(max(part._begin, part.log.stat().st_size - TAIL))
        return file.read().decode(errors="replace")


def _kib(pid: int, file: str, key: str) -> int:
    for line in Path(f"/proc/{pid}/{file}").read_text().splitlines():
        if line.startswith(f"{key}:"):
            return int(line.split()[1])
    return 0


def _handles_usr1(pid: int) -> bool:
    """Tell whether the signal would be handled: while a process starts, it would end it."""
    with contextlib.suppress(OSError, StopIteration):
        status = Path(f"/proc/{pid}/status").read_text().splitlines()
        caught = next(line for line in status if line.startswith("SigCgt:"))
        return bool(int(caught.split()[1], 16) >> (signal.SIGUSR1 - 1) & 1)
    return False


def _size(path: Path) -> int:
    """Give the room that a file takes (bytes); 0 where there is none."""
    try:
        found = path.lstat()
    except OSError:
        return 0
    return found.st_blocks * 512 if path.is_file() else 0
