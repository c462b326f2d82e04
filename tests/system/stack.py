"""The real processes of one site, each of which a test may kill, freeze and start again."""

from __future__ import annotations

import asyncio
import atexit
import bisect
import functools
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import fork_server
from fork_server import ForkedProcess, fork_program
from patience import PATIENCE_S
from ports import free_port

import talaia
from talaia.cli.child_processes import _follow_parent
from talaia.hub import accounts
from talaia.hub.settings import Settings
from talaia.hub.store.database import Database
from talaia.sim import ros_domain

SITE = "faults"
PASSWORD = "a password for a minute"  # noqa: S105 - of a hub that lives for a minute on loopback
PEOPLE = {"driver": "operator", "second": "operator", "guest": "guest"}
# The processes are those of the package under test, wherever it is installed.
SOURCE = Path(talaia.__file__).resolve().parent.parent
STEP_S = 0.02
# What the tests' own programs import is imported once, too.
SCRIPTS = {
    str(Path(__file__).parent / name)
    for name in ("robot.py", "actor.py", "enclosure/failing_disk.py")
}

DESCRIPTION = """\
talaia: 1
site: faults
name: Faults
ros2: {}
devices:
  base:
    name: Base
    kind: vehicle
    visibility: public
    signals:
      count: {name: Count, source: {topic: /count, type: std_msgs/msg/Float64, field: data}}
      open:
        name: Open to all
        visibility: public
        source: {topic: /open, type: std_msgs/msg/Float64, field: data}
      still: {name: Still, source: {topic: /still, type: std_msgs/msg/Float64, field: data}}
      wheel1: {name: Speed, source: {topic: /metric, type: std_msgs/msg/String, name: wheel1}}
    drive:
      topic: /cmd_vel
      max_speed: 0.5
      max_turn: 1.0
      max_acceleration: 1000
      max_turn_acceleration: 1000
      stop: {topic: /stop, confirmed_by: [base/still]}
  stamped:
    name: Stamped
    drive:
      {topic: /cmd_stamped, message: geometry_msgs/msg/TwistStamped, max_speed: 0.5, max_turn: 1.0}
  keys:
    name: Keys
    drive: {topic: /control, message: std_msgs/msg/String, max_speed: 0.5, max_turn: 1.0}
"""


class Heard(NamedTuple):
    """A message that reached the robot: moment (monotonic, ns) and value."""

    t: int
    v: object


async def until(
    condition: Callable[[], object], within: float = PATIENCE_S, what: str = ""
) -> None:
    """Wait until a condition holds; fail with ``what`` when it does not in time (s)."""
    deadline = time.monotonic() + within
    while not condition():
        assert time.monotonic() < deadline, f"not within {within:g} s: {what or condition}"
        await asyncio.sleep(STEP_S)


def finish(work: Coroutine[object, object, None]) -> None:
    """Run ``work`` to its end, also where Playwright has a loop in this thread.

    It starts no process: that would end with the thread here.
    """
    with ThreadPoolExecutor(1) as thread:
        thread.submit(asyncio.run, work).result()


@functools.cache
def empty_database() -> Path:
    """Make a hub's database with all tables, once: each hub here begins with a copy of it.

    To make the tables takes half a second of a core.
    """
    folder = Path(tempfile.mkdtemp(prefix="talaia-test-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)

    async def make() -> None:
        database = Database(f"sqlite:///{folder}/talaia.db")
        await database.migrate()
        await database.close()

    finish(make())
    return folder / "talaia.db"


class Process:
    """One process, its output in a file."""

    def __init__(self, words: list[str], log: Path, environment: dict[str, str]) -> None:
        """Start ``python WORDS``; more output follows what ``log`` holds already."""
        self.log = log
        self._begin = log.stat().st_size if log.exists() else 0
        everything = {
            **os.environ,
            "PYTHONPATH": str(SOURCE),
            "PYTHONUNBUFFERED": "1",
            **environment,
        }
        self.popen: subprocess.Popen[bytes] | ForkedProcess
        with log.open("ab") as output:
            # What a starter puts in place of a part must not have been imported before it.
            if fork_server.is_used() and (words[:2] == ["-m", "talaia"] or words[0] in SCRIPTS):
                self.popen = fork_program(words, everything, output)
                return
            self.popen = subprocess.Popen(
                [sys.executable, *words],
                stdin=subprocess.PIPE,
                stdout=output,
                stderr=subprocess.STDOUT,
                env=everything,
                start_new_session=True,
                # A test run that is killed leaves nobody behind.
                preexec_fn=_follow_parent if sys.platform == "linux" else None,
                bufsize=0,
            )

    def said(self) -> str:
        """What this run of it has said so far."""
        with self.log.open("rb") as file:
            file.seek(self._begin)
            return file.read().decode(errors="replace")

    async def says(self, word: str, within: float = PATIENCE_S, times: int = 1) -> None:
        def found() -> bool:
            assert self.popen.poll() is None, f"it ended:\n{self.said()}"
            return self.said().count(word) >= times

        await until(found, within, f"{word!r} in {self.log.name}")

    def tell(self, line: str) -> None:
        assert self.popen.stdin is not None
        self.popen.stdin.write(f"{line}\n".encode())

    def kill(self) -> int:
        """Kill -9; gives the moment just before (monotonic, ns)."""
        at = time.monotonic_ns()
        self.popen.send_signal(signal.SIGKILL)
        self.popen.wait(10)
        self._close()
        return at

    def end(self) -> None:
        if self.popen.poll() is None:
            self.popen.send_signal(signal.SIGCONT)
            self.popen.terminate()
            try:
                self.popen.wait(10)
            except subprocess.TimeoutExpired:
                self.popen.kill()
                self.popen.wait(10)
        self._close()

    def _close(self) -> None:
        if self.popen.stdin is not None:
            self.popen.stdin.close()


class Stack:
    """A hub, a gateway and a robot in one folder."""

    description = DESCRIPTION
    # The site's name where its hub has others, too.
    one_of_many = ""
    # Which changes of the description the gateway takes from the hub.
    accepts = "no"
    # What robot and gateway have in their environment beside their ROS domain.
    more: dict[str, str] = {}  # noqa: RUF012 - replaced, never changed

    def __init__(
        self,
        folder: Path,
        description: str = "",
        people: dict[str, str] | None = None,
        link_port: int = 0,
    ) -> None:
        """Make accounts and a key, and start all three; see `ready`.

        The gateway dials ``link_port`` where one is given: something stands between.
        """
        self.folder = folder
        self.description = description or self.description
        self._people = PEOPLE if people is None else people
        self._link_port = link_port
        self._world = ros_domain.reserve_domain()
        self._ros = {**ros_domain.domain_environment(self._world.domain), **self.more}
        self.port = self._free_port()
        finish(self._accounts())
        (folder / "site.yaml").write_text(self.description)
        self.heard_file, self.ledger_file = folder / "heard.jsonl", folder / "ledger.txt"
        self.robot = self.start_robot()
        self._read = self._read_ledger = 0
        self._ledger: list[tuple[int, int, int]] = []
        self._heard: dict[str, list[Heard]] = {}
        self.hub = self.start_hub()
        self.gateway = self.start_gateway()

    @property
    def address(self) -> str:
        return f"http://localhost:{self.port}"

    def _free_port(self) -> int:
        return free_port()

    async def _accounts(self) -> None:
        shutil.copy(empty_database(), self.folder)
        settings = Settings(
            data=self.folder, host="127.0.0.1", port=self.port, plain=True, password_cost=4
        )
        for name, role in self._people.items():
            await accounts.create_user(settings, name, PASSWORD, role)
        (self.folder / "key").write_text(await accounts.create_gateway(settings, SITE))

    def start_robot(self) -> Process:
        words = [str(Path(__file__).parent / "robot.py")]
        words += [str(self.heard_file), str(self.ledger_file)]
        return Process(words, self.folder / "robot.log", self._ros)

    def start_hub(self) -> Process:
        words = ["-m", "talaia", "hub", "--data", str(self.folder), "--plain"]
        words += ["--host", "127.0.0.1", "--port", str(self.port)]
        self.hub = Process(words, self.folder / "hub.log", {})
        return self.hub

    def start_gateway(self) -> Process:
        words = [
            "-m", "talaia", "gateway", str(self.folder / "site.yaml"), "--allow-plain",
            "--hub", f"ws://127.0.0.1:{self._link_port or self.port}",
            "--key-file", str(self.folder / "key"),
            "--data", str(self.folder / "gateway"), "--ros-domain", str(self._world.domain),
            "--accept-changes", self.accepts,
        ]  # fmt: skip
        self.gateway = Process(words, self.folder / "gateway.log", self._ros)
        return self.gateway

    def start_vehicle(self, log: Path) -> Process:
        words = ["-m", "talaia", "sim", "vehicle", "--no-camera", "--log", str(log)]
        words += ["--domain", str(self._world.domain)]
        return Process(words, self.folder / "vehicle.log", self._ros)

    async def fresh(self) -> None:
        """Start what a test before has killed, and wait until all run and are linked.

        After a loss the gateway is started anew: it waits longer before it dials each time, and
        only a link of ten seconds would make it forget that.
        """
        if self.hub.popen.poll() is not None:
            self.gateway.end()
            self.start_hub()
        if self.gateway.said().count("linked to") > 1:
            self.gateway.end()
        if self.gateway.popen.poll() is not None:
            self.start_gateway()
        await self.ready()

    async def ready(self) -> None:
        """Wait until all run and are linked."""
        await self.robot.says("ready")
        await self.hub.says("ready")
        await self.gateway.says("linked to")

    def heard(self, topic: str, since: int = 0) -> list[Heard]:
        """What the robot heard on a topic after a moment."""
        with self.heard_file.open("rb") as file:
            file.seek(self._read)
            lines = file.read().splitlines(keepends=True)
        for line in lines:
            if line.endswith(b"\n"):
                self._read += len(line)
                found = json.loads(line)
                self._heard.setdefault(found["topic"], []).append(Heard(found["t"], found["v"]))
        heard = self._heard.get(topic, [])
        # Asked many times a second, of what grows for twenty minutes.
        return heard[bisect.bisect_right(heard, since, key=lambda each: each.t) :]

    def ledger(self) -> list[tuple[int, int, int]]:
        """Value, moment and subscriptions of everything the robot counted."""
        with self.ledger_file.open("rb") as file:
            file.seek(self._read_ledger)
            lines = file.read().splitlines(keepends=True)
        for line in lines:
            if line.endswith(b"\n"):
                self._read_ledger += len(line)
                value, moment, known = map(int, line.split())
                self._ledger.append((value, moment, known))
        return self._ledger

    def close(self) -> None:
        for process in (self.gateway, self.hub, self.robot):
            process.end()
        self._world.release()
