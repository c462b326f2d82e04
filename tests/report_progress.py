"""Tells `tools/run_tests.py` of each test while pytest runs: one JSON object a line.

The file's name is in TALAIA_TEST_REPORT; without it nothing is written. Beside it, ``skip.json``
lists tests that are not to be run, for they have run in a process that crashed. Lines:
``{"collected": NUMBER}`` of tests that are to be run; ``{"begin": ID}`` before a test;
``{"end": ID, "outcome", "text", "wall", "cpu"}`` after it, with the seconds since the test before
it ended: ``wall``, and ``cpu`` of this process and of its children that have ended, those of the
fork server with them.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import time
from pathlib import Path
from typing import Any

import pytest


def _cpu() -> float:
    """CPU time so far of this process and of its children that have ended (s)."""
    usages = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    # Only tests of whole sites import it.
    forks = sys.modules.get("fork_server")
    forked = forks.cpu_time() if forks else 0.0
    return sum(usage.ru_utime + usage.ru_stime for usage in usages) + forked


class ProgressReport:
    """Writes down what becomes of each test.

    Attributes:
        failed: the text of the first phase of the present test that failed.
        skipped: the present test was skipped.

    """

    def __init__(self, path: Path) -> None:
        """Append to the file at ``path``."""
        self._path = path
        self._wall, self._cpu = time.monotonic(), _cpu()
        self.failed = ""
        self.skipped = False

    def write(self, line: dict[str, Any]) -> None:
        with self._path.open("a") as file:
            file.write(json.dumps(line) + "\n")

    def end(self, test: str, outcome: str, text: str = "") -> None:
        wall, cpu = time.monotonic(), _cpu()
        spent = {"wall": round(wall - self._wall, 3), "cpu": round(cpu - self._cpu, 3)}
        self._wall, self._cpu = wall, cpu
        self.write({"end": test, "outcome": outcome, "text": text, **spent})

    def pytest_collection_modifyitems(
        self, config: pytest.Config, items: list[pytest.Item]
    ) -> None:
        listed = self._path.parent / "skip.json"
        skip = set(json.loads(listed.read_text())) if listed.exists() else set()
        config.hook.pytest_deselected(items=[item for item in items if item.nodeid in skip])
        items[:] = [item for item in items if item.nodeid not in skip]

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        self.write({"collected": len(session.items)})

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.end(report.nodeid, "failed", report.longreprtext)

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.failed, self.skipped = "", False
        self.write({"begin": nodeid})

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and not self.failed:
            sections = "".join(f"\n── {title}\n{text}" for title, text in report.sections)
            self.failed = f"{report.when}: {report.longreprtext}{sections[-4000:]}"
        self.skipped |= report.skipped

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        outcome = "failed" if self.failed else "skipped" if self.skipped else "passed"
        self.end(nodeid, outcome, self.failed)


def register(config: pytest.Config) -> None:
    """Report, when the runner asked for it."""
    if path := os.environ.pop("TALAIA_TEST_REPORT", ""):
        config.pluginmanager.register(ProgressReport(Path(path)))
