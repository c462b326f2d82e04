"""Every fault, at least once; as often as fits with ``TALAIA_FAULT_MINUTES`` (`make faults`).

``TALAIA_FAULT_SEED`` chooses the first seed; ``TALAIA_FAULT_TABLE`` names the file the table goes
to. A seed tells what was decided (moments, points, weather), not how a busy machine took it.
"""

from __future__ import annotations

import os
import random
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from ..conftest import missing
from .ledgers import Findings
from .rows import ROWS, Row
from .table import Table
from .world import World

MINUTES = float(os.environ.get("TALAIA_FAULT_MINUTES", "0"))
SEED = int(os.environ.get("TALAIA_FAULT_SEED", "1"))
pytestmark = [pytest.mark.robot, pytest.mark.timeout(max(120, MINUTES * 60))]


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    for module in ("rclpy",):
        if not __import__("importlib.util").util.find_spec(module):
            missing(module)
    running = World(tmp_path_factory.mktemp("faults"))
    running.long = MINUTES > 0
    try:
        yield running
    finally:
        running.close()


@pytest.fixture(scope="module")
def table() -> Iterator[Table]:
    kept = Table()
    yield kept
    text = kept.text()
    sys.stdout.write("\n" + text)
    target = os.environ.get("TALAIA_FAULT_TABLE")
    if target:
        Path(target).write_text(text)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
async def test_the_site_survives(world: World, table: Table, row: Row) -> None:
    until = time.monotonic() + MINUTES * 60 / len(ROWS)
    seed, found = SEED, []
    while seed == SEED or time.monotonic() < until:
        findings = Findings()
        world.proxy.reseed(seed)
        try:
            await row.run(world, random.Random(f"{row.name}:{seed}"), findings)  # noqa: S311
        except PermissionError as error:
            missing(str(error))
        except Exception as error:
            # In a long run the other seeds are still tried; the table tells of this one.
            findings.breach("run", f"{type(error).__name__}: {error}"[:500])
            if not MINUTES:
                raise
        finally:
            table.add(row, seed, findings)
        found += findings.violations
        seed += 1
    assert found == []
