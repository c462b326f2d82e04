"""Every fault, at least once; as often as fits with ``TALAIA_PROOF_MINUTES``.

`make proofs ONLY=faults` sets it, and ``TALAIA_PROOF_TABLE``, the file that the table goes to.
``TALAIA_FAULT_SEED`` chooses the first seed. A seed tells what was decided (moments,
points, weather), not how a busy machine took it.

In the short form a row that fails is done once more, for it also runs on machines that are busy.

Most of a row is waiting. So the short form has two worlds, each in a process of its own, that
take the rows by turns; where figures are wanted, there is one.
"""

from __future__ import annotations

import asyncio
import importlib.util
import multiprocessing
import os
import random
import signal
import sys
import time
import traceback
from collections.abc import Iterator
from multiprocessing.queues import SimpleQueue
from pathlib import Path
from typing import NamedTuple

import httpx
import pytest

from ..conftest import missing
from .ledgers import Findings
from .rows import ROWS, Row
from .table import Table
from .world import World

MINUTES = float(os.environ.get("TALAIA_PROOF_MINUTES", "0"))
# A run of so many minutes is through every named point and every length of partition.
WHOLE = 10.0
TARGET = os.environ.get("TALAIA_PROOF_TABLE")
SEED = int(os.environ.get("TALAIA_FAULT_SEED", "1"))
LANES = 1 if MINUTES else 2
# In the short form a row takes 1 to 22 s; what stands still is broken off, and says where (s).
STANDS_STILL_S = 90.0
pytestmark = [pytest.mark.robot, pytest.mark.timeout(max(2.5 * STANDS_STILL_S, MINUTES * 60))]


class Outcome(NamedTuple):
    """What a row came to: its runs, and what kept it from being run."""

    name: str
    runs: list[tuple[int, Findings]]
    missing: str = ""
    error: str = ""


def lane(
    folder: Path, rows: SimpleQueue[str], outcomes: SimpleQueue[Outcome], left: list[str]
) -> None:
    """Take rows by turns, in a process with a world of its own."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    ends = time.monotonic() + MINUTES * 60
    world: World | None = None
    try:
        while name := rows.get():
            row = next(each for each in ROWS if each.name == name)
            weights = {each.name: each.weight for each in ROWS}
            # Who is done early leaves time to the others.
            rest = sum(weights[each] for each in left[left.index(name) :])
            until = time.monotonic() + (ends - time.monotonic()) * row.weight / rest
            runs: list[tuple[int, Findings]] = []
            problem = absent = ""
            try:
                if world is None:
                    world = World(folder)
                    world.long = MINUTES > 0
                try:
                    asyncio.run(run_row(world, row, until, runs))
                    again = not MINUTES and any(each.violations for _, each in runs)
                except (AssertionError, TimeoutError, httpx.HTTPError):
                    if MINUTES:
                        raise
                    traceback.print_exc()
                    again = True
                if again:
                    # A product's fault shows again with the same seed; a stall of a machine that
                    # others use too does not. Where figures are wanted, each violation counts.
                    runs.clear()
                    asyncio.run(run_row(world, row, until, runs))
            except (PermissionError, pytest.skip.Exception) as error:
                absent = str(error)
            except BaseException:  # noqa: BLE001 - told by the row's own test
                problem = traceback.format_exc()
            outcomes.put(Outcome(name, runs, absent, problem))
    finally:
        if world is not None:
            world.close()


async def run_row(world: World, row: Row, until: float, runs: list[tuple[int, Findings]]) -> None:
    """Run a row until its time is over."""
    least = row.least if MINUTES >= WHOLE else 1
    while len(runs) < least or time.monotonic() < until:
        seed = SEED + len(runs)
        findings = Findings(turn=seed - 1)
        runs.append((seed, findings))
        world.proxy.reseed(seed)
        try:
            async with asyncio.timeout(None if MINUTES else STANDS_STILL_S):
                await row.run(world, random.Random(f"{row.name}:{seed}"), findings)  # noqa: S311
        except PermissionError:
            raise
        except Exception as error:
            # In a long run the other seeds are still tried; the table tells of this one.
            findings.breach("run", f"{type(error).__name__}: {error}"[:500])
            if not MINUTES:
                raise
        finally:
            for each in findings.violations:
                sys.stdout.write(f"\n{row.name} {seed}: {each}\n")
                sys.stdout.flush()


class Lanes:
    """Worlds that take the rows by turns, and what each row came to."""

    def __init__(self, rows: list[str], folders: list[Path]) -> None:
        """Begin with these rows, with a world in each folder."""
        fork = multiprocessing.get_context("fork")
        self._outcomes: SimpleQueue[Outcome] = fork.SimpleQueue()
        self._found: dict[str, Outcome] = {}
        queue: SimpleQueue[str] = fork.SimpleQueue()
        for each in [*rows, *("" for _ in folders)]:
            queue.put(each)
        self._processes = [
            fork.Process(target=lane, args=(each, queue, self._outcomes, rows)) for each in folders
        ]
        for each in self._processes:
            each.start()

    def outcome(self, name: str) -> Outcome:
        """Wait for what a row came to."""
        while name not in self._found:
            found = self._outcomes.get()
            self._found[found.name] = found
        return self._found[name]

    def end(self) -> Table:
        """Wait for the worlds to end, or end them; give the table of all rows."""
        for each in self._processes:
            each.join(20)
            if each.is_alive():
                each.terminate()
                each.join()
        table = Table()
        for row in ROWS:
            if row.name in self._found:
                for seed, findings in self._found[row.name].runs:
                    table.add(row, seed, findings)
        return table


@pytest.fixture(scope="module")
def lanes(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Lanes]:
    if not importlib.util.find_spec("rclpy"):
        missing("rclpy")
    asked = [
        each.callspec.params["row"].name
        for each in request.session.items
        if getattr(each, "module", None) is request.module and hasattr(each, "callspec")
    ]
    running = Lanes(asked, [tmp_path_factory.mktemp("faults") for _ in range(LANES)])
    try:
        yield running
    finally:
        text = running.end().text()
        sys.stdout.write("\n" + text)
        if TARGET:
            Path(TARGET).write_text(text)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_the_site_survives(lanes: Lanes, row: Row) -> None:
    outcome = lanes.outcome(row.name)
    if outcome.missing:
        missing(outcome.missing)
    if outcome.error:
        pytest.fail(outcome.error)
    assert [text for _, findings in outcome.runs for text in findings.violations] == []
