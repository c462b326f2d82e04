"""Each row of the enclosure's table once on ROS 2, and some on the other protocols.

`make proofs ONLY=enclosure` does all seeds. The rows are done by ``python -m system.enclosure`` in
several worlds side by side, each used for many rows; the tests here wait for what each came to. A
row that fails is done once more, for this also runs on machines that are busy.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from ..conftest import absent_ros1, need_indi, need_ros1, need_ros2
from ..stack import SOURCE
from .results import Results, Trial
from .rows import ROWS

pytestmark = [pytest.mark.robot, pytest.mark.timeout(900)]
STATE = "short"
ASKED = [
    (protocol, row.name)
    for protocol in ("ROS 2", "ROS 1", "INDI")
    for row in ROWS
    if protocol in row.protocols and (protocol == "ROS 2" or row.short)
]
WITHIN_S = 800.0
ENDING_S = 20.0


class Rows:
    """The process that does the rows, and what they came to so far."""

    def __init__(self, folder: Path, names: list[str], protocols: list[str]) -> None:
        """Start it."""
        self._file = folder / "results.jsonl"
        self.log = folder / "rows.log"
        words = [sys.executable, "-m", "system.enclosure", "--short", "--state", STATE]
        words += ["--results", str(self._file), "--lanes", "3", "--rows", *names]
        words += ["--protocols", *protocols]
        tests = Path(__file__).parents[2]
        path = os.pathsep.join((str(SOURCE), str(tests)))
        with self.log.open("wb") as log:
            self.process = subprocess.Popen(
                words, stdout=log, stderr=log, start_new_session=True,
                env={**os.environ, "PYTHONPATH": path},
            )  # fmt: skip
        self._ends = time.monotonic() + WITHIN_S

    def result(self, protocol: str, name: str) -> Trial:
        """Wait for a row."""
        while True:
            ended = self.process.poll() is not None
            for each in Results(self._file).trials(STATE):
                if (each.protocol, each.row) == (protocol, name):
                    return each
            assert not ended, f"it ended:\n{self.log.read_text()[-4000:]}"
            assert time.monotonic() < self._ends, f"{protocol} {name}: no result"
            time.sleep(0.2)

    def end(self) -> None:
        # The last row's result comes before its world has ended: one that is cut short leaves a
        # watchdog that goes on closing.
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(ENDING_S)
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(40)
            except subprocess.TimeoutExpired:
                os.killpg(self.process.pid, signal.SIGKILL)
                self.process.wait(10)


@pytest.fixture(scope="module")
def rows(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Rows]:
    need_ros2()
    asked = {
        each.callspec.params["name"]
        for each in request.session.items
        if getattr(each, "module", None) is request.module and hasattr(each, "callspec")
    }
    protocols = ["ROS 2"] + ([] if absent_ros1() else ["ROS 1"])
    protocols += ["INDI"] if shutil.which("indiserver") else []
    running = Rows(tmp_path_factory.mktemp("enclosure"), sorted(asked), protocols)
    try:
        yield running
    finally:
        running.end()


@pytest.mark.parametrize(("protocol", "name"), ASKED)
def test_the_roof_is_closed_in_time_and_people_are_told(
    rows: Rows, protocol: str, name: str
) -> None:
    if protocol == "ROS 1":
        need_ros1()
    if protocol == "INDI":
        need_indi()
    assert rows.result(protocol, name).violations == []
