"""What several hubs survive; every fault three times with ``TALAIA_PROOF_MINUTES``.

`make proofs ONLY=cluster` sets it, and ``TALAIA_PROOF_TABLE``, the file that the table goes to:
then 200 gateways and 50 pages come to the hubs. In the short form 20 and 5 do, five rows are done,
and one that fails is done once more, for it also runs on machines that are busy. All rows are one
world's: each begins with what those before have left.
"""

from __future__ import annotations

import asyncio
import importlib.util
import os
import random
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from ..conftest import missing
from ..faults.ledgers import Findings
from ..faults.table import Table
from .cluster_world import ClusterWorld
from .rows import ROWS, Row

MINUTES = float(os.environ.get("TALAIA_PROOF_MINUTES", "0"))
TARGET = os.environ.get("TALAIA_PROOF_TABLE")
GATEWAYS, PAGES = (int(word) for word in os.environ.get("TALAIA_CLUSTER_CROWD", "200,50" if MINUTES else "20,5").split(","))
# A run of so many minutes is a proof, and each row is run three times.
WHOLE = 20.0
RUNS = 3 if MINUTES >= WHOLE else 1
# Most of a row is waiting; what stands still is broken off, and says where (s).
STANDS_STILL_S = 240.0
pytestmark = [
    pytest.mark.robot,
    pytest.mark.timeout(max(3 * STANDS_STILL_S, RUNS * STANDS_STILL_S)),
]


@pytest.fixture(scope="module")
def table() -> Iterator[Table]:
    found = Table("")
    yield found
    text = found.text()
    sys.stdout.write("\n" + text)
    if TARGET:
        Path(TARGET).write_text(text)


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ClusterWorld]:
    if not importlib.util.find_spec("rclpy"):
        missing("rclpy")
    try:
        running = ClusterWorld(tmp_path_factory.mktemp("cluster"), GATEWAYS, PAGES)
    except PermissionError as error:
        missing(str(error))
    try:
        yield running
    finally:
        running.close()


def run_row(world: ClusterWorld, row: Row, turn: int) -> Findings:
    """Run a row once."""

    async def run() -> Findings:
        findings = Findings(turn=turn)
        async with asyncio.timeout(STANDS_STILL_S):
            await row.run(world, random.Random(f"{row.name}:{turn}"), findings)  # noqa: S311
        return findings

    return asyncio.run(run())


@pytest.mark.parametrize(
    "row", [row for row in ROWS if row.short or MINUTES], ids=lambda row: row.name
)
def test_several_hubs_survive(world: ClusterWorld, table: Table, row: Row) -> None:
    found: list[str] = []
    for turn in range(RUNS):
        findings = run_row(world, row, turn)
        for violation in findings.violations:
            sys.stdout.write(f"\n{row.name} {turn + 1}: {violation}\n")
            sys.stdout.flush()
        if findings.violations and not MINUTES:
            findings = run_row(world, row, turn)
        table.add(row, turn + 1, findings)
        found += findings.violations
    assert found == []
