"""What several hubs survive; every fault three times with ``TALAIA_PROOF_MINUTES``.

`make proofs ONLY=cluster` sets it, and ``TALAIA_PROOF_TABLE``, the file that the table goes to:
then 200 gateways and 50 pages come to the hubs (``TALAIA_PROOF_CROWD=60,15``: so many), and three
pages in a real Chromium. Runs that
were good are kept in build/cluster.jsonl; no run begins when the minutes are over, and the next
proof of the same code goes on with what is left. In the short form 20 and 5 do, five rows are done,
and one that fails is done once more, for it also runs on machines that are busy. All rows are one
world's: each begins with what those before have left.
"""

from __future__ import annotations

import asyncio
import functools
import importlib.util
import os
import random
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from ..conftest import missing
from ..faults.ledgers import Findings
from ..faults.table import Table
from .cluster_world import MAIN, ClusterWorld
from .kept_runs import KeptRuns
from .rows import ROWS, Row

MINUTES = float(os.environ.get("TALAIA_PROOF_MINUTES", "0"))
TARGET = os.environ.get("TALAIA_PROOF_TABLE")
_ASKED = os.environ.get("TALAIA_PROOF_CROWD", "200,50" if MINUTES else "20,5")
GATEWAYS, PAGES = (int(number) for number in _ASKED.split(","))
# More pages, in a real Chromium; none in the short form, where they would compute like a row.
BROWSER_PAGES = 3 if MINUTES else 0
# A run of so many minutes is a proof, and each row is run three times.
WHOLE = 15.0
TURNS = 3 if MINUTES >= WHOLE else 1
BEGAN_S = time.monotonic()
# Most of a row is waiting; what stands still is broken off, and says where (s).
STANDS_STILL_S = 240.0
pytestmark = [pytest.mark.robot, pytest.mark.timeout(3 * STANDS_STILL_S)]


@functools.cache
def kept_runs() -> KeptRuns:
    return KeptRuns((GATEWAYS, PAGES))


@pytest.fixture(scope="module")
def table() -> Iterator[Table]:
    found = Table("")
    yield found
    text = found.text()
    if MINUTES:
        text += "".join(f"- Failed before it was repeated: {line}\n" for line in kept_runs().failed)
    sys.stdout.write("\n" + text)
    if TARGET:
        Path(TARGET).write_text(text)


# Kept from row to row; made by the first that needs it.
_WORLDS: list[ClusterWorld] = []


@pytest.fixture(scope="module")
def worlds(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    if not importlib.util.find_spec("rclpy"):
        missing("rclpy")
    yield tmp_path_factory.mktemp("cluster")
    while _WORLDS:
        _WORLDS.pop().close()


def world_in(folder: Path, *, divided: bool) -> ClusterWorld:
    """Give the world, which is begun when the first row needs it."""
    if _WORLDS and (_WORLDS[0].shard != MAIN) != divided:
        _WORLDS.pop().close()
    if not _WORLDS:
        try:
            place = folder / f"world{len(list(folder.iterdir()))}"
            place.mkdir()
            world = ClusterWorld(place, GATEWAYS, PAGES, BROWSER_PAGES, divided=divided)
            _WORLDS.append(world)
        except PermissionError as error:
            missing(str(error))
    return _WORLDS[0]


def run_row(folder: Path, row: Row, turn: int) -> Findings:
    """Run a row once."""
    world = world_in(folder, divided=row.divided)

    async def run() -> Findings:
        findings = Findings(turn=turn)
        async with asyncio.timeout(STANDS_STILL_S):
            await row.run(world, random.Random(f"{row.name}:{turn}"), findings)  # noqa: S311
        return findings

    findings = asyncio.run(run())
    for violation in findings.violations:
        sys.stdout.write(f"\n{row.name} {turn + 1}: {violation}\n")
        sys.stdout.flush()
    return findings


def run_for_proof(folder: Path, row: Row, turn: int) -> Findings:
    """Run a row once, and keep what was found; a world in which it broke off is done with."""
    try:
        found = run_row(folder, row, turn)
    except Exception as error:  # noqa: BLE001 - said, counted and kept; other rows go on
        found = Findings(turn=turn)
        found.breach("row", f"it broke off: {str(error) or repr(error)}"[:500])
        sys.stdout.write(f"\n{row.name} {turn + 1}: {found.violations[0]}\n")
        while _WORLDS:
            _WORLDS.pop().close()
    kept_runs().keep(row.name, turn, found)
    return found


@pytest.mark.parametrize("turn", range(TURNS))
@pytest.mark.parametrize(
    "row", [row for row in ROWS if row.short or MINUTES], ids=lambda row: row.name
)
def test_several_hubs_survive(worlds: Path, table: Table, row: Row, turn: int) -> None:
    found = kept_runs().find(row.name, turn) if MINUTES else None
    if found is None:
        if MINUTES and time.monotonic() - BEGAN_S > 60 * MINUTES:
            pytest.fail("the time is over; the next proof goes on from here")
        run = run_for_proof if MINUTES else run_row
        found = run(worlds, row, turn)
        if found.violations and not MINUTES:
            found = run_row(worlds, row, turn)
    table.add(row, turn + 1, found)
    assert found.violations == []
