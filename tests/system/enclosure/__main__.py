"""Do the rows of the enclosure's table, and write it.

    PYTHONPATH=src:tests python -m system.enclosure [--table FILE] [--minutes N] [--rows NAME …]

Goes on where it was: what has passed for this state of the code is kept in build/enclosure.jsonl.
Worlds run side by side, each a process of its own. The exit code is 1 when a run has found a
violation, or not all has been run.
"""

from __future__ import annotations

import argparse
import asyncio
import importlib.util
import multiprocessing
import random
import shutil
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path

from ..conftest import absent_ros1
from ..proof_state import ROOT, code_state
from .results import PROTOCOLS, SEEDS, Results, Trial, table
from .rows import ROWS, run_trial
from .trial import DISKS, Row, Run, disk_of
from .world import World

# A row that takes longer hangs.
TRIAL_S = 180.0
# A world is begun anew after so many trials: what a long life brings is the soak's matter.
LIFE = 60
# So many seeds of one kind of roof before those of the other.
TOGETHER = 5
LANES = {"ROS 2": 4, "ROS 1": 2, "INDI": 1}


def wanted(options: argparse.Namespace, protocol: str) -> list[tuple[Row, int]]:
    """Give rows and seeds of a protocol: each row a few times before any row more often."""
    rows = [row for row in ROWS if protocol in row.protocols]
    if options.rows:
        rows = [row for row in rows if row.name in options.rows]
    if options.short and protocol != "ROS 2":
        rows = [row for row in rows if row.short]
    if options.short:
        # The disks by turns of the rows.
        return [(row, number % len(DISKS) + 1) for number, row in enumerate(rows)]
    seeds = options.seeds or SEEDS[protocol]
    found = [(row, seed) for seed in range(1, seeds + 1) for row in rows]
    # A world has one roof: the other kind's rows come together.
    return sorted(found, key=lambda each: ((each[1] - 1) // TOGETHER, each[0].roof != "dome"))


async def lane(options: argparse.Namespace) -> None:
    """Do this process's share, in a world that is begun anew when something breaks."""
    results = Results(options.results)
    done = results.passed(options.state)
    mine = [
        (row, seed)
        for row, seed in wanted(options, options.lane)
        if (options.lane, row.name, seed) not in done
    ][options.number :: options.of]
    ends = time.monotonic() + options.minutes * 60
    world: World | None = None
    lived = 0
    try:
        for row, seed in mine:
            if time.monotonic() > ends:
                break
            began = time.monotonic()
            for attempt in range(2 if options.short else 1):
                if world is not None and (lived >= LIFE or world.roof != row.roof):
                    await world.aclose()
                    world = None
                run = Run(None, random.Random(0), options.lane, disk_of(row, seed))  # type: ignore[arg-type] # noqa: S311
                try:
                    if world is None:
                        world, lived = await begin(protocol=options.lane, roof=row.roof), 0
                    async with asyncio.timeout(TRIAL_S):
                        run = await run_trial(world, row, seed, options.lane)
                    lived += 1
                except Exception as error:  # noqa: BLE001 - what broke is a violation of the row
                    run.breach(f"run: {type(error).__name__}: {error}"[:300])
                    traceback.print_exc()
                    _keep(options, world, row, seed)
                    if world is not None:
                        await world.aclose()
                    world = None
                if run.violations:
                    _keep(options, world, row, seed)
                # A product's fault shows again; a stall of a machine that others use does not.
                if not run.violations or attempt or not options.short:
                    results.add(options.state, row, seed, run)
                    break
            told = f"closed {run.closed_s} told {run.told_s} {run.violations} {run.counted}"
            took = time.monotonic() - began
            print(f"{options.lane} {row.name} {seed} {run.disk}: {told} {took:.1f} s", flush=True)
    finally:
        if world is not None:
            await world.aclose()


def _keep(options: argparse.Namespace, world: World | None, row: Row, seed: int) -> None:
    """Keep what a world has written, so that a violation can be looked into."""
    if world is None:
        return
    name = f"{row.name}-{options.lane}-{seed}".replace(" ", "")
    folder = options.results.parent / "enclosure-violations" / f"{name}-{time.time():.0f}"
    folder.mkdir(parents=True, exist_ok=True)
    for each in ("gateway.log", "ledger.jsonl", "sim.log"):
        if (world.folder / each).exists():
            shutil.copy(world.folder / each, folder / each)
    (folder / "hub.txt").write_text("\n".join(map(repr, world.hub.messages)))


async def begin(protocol: str, roof: str) -> World:
    """Start a world in a folder that goes with it."""
    world = World(Path(tempfile.mkdtemp(prefix="enclosure-")), protocol, roof)
    try:
        await world.open()
    except BaseException:
        await world.aclose()
        raise
    return world


def there() -> list[str]:
    """Give the protocols that this machine has."""
    found = ["ROS 2"] if importlib.util.find_spec("rclpy") else []
    found += [] if absent_ros1() else ["ROS 1"]
    return [*found, *(["INDI"] if shutil.which("indiserver") else [])]


def main() -> int:
    """Run until all is done, or the time is over."""
    parser = argparse.ArgumentParser("system.enclosure")
    parser.add_argument("--table", type=Path)
    parser.add_argument("--results", type=Path, default=ROOT / "build" / "enclosure.jsonl")
    parser.add_argument("--minutes", type=float, default=1e6)
    parser.add_argument("--seeds", type=int)
    parser.add_argument("--rows", nargs="*")
    parser.add_argument("--protocols", nargs="*", choices=PROTOCOLS)
    parser.add_argument("--lanes", type=int, help="worlds of ROS 2 side by side")
    parser.add_argument("--short", action="store_true", help="each row once")
    parser.add_argument("--state")
    options = parser.parse_args()
    options.state = options.state or code_state()
    protocols = options.protocols or there()
    # The lanes end with it.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    _run_lanes(options, protocols)
    trials: list[Trial] = Results(options.results).trials(options.state)
    text = table(trials)
    sys.stdout.write("\n" + text)
    if options.table:
        options.table.write_text(text)
    passed = Results(options.results).passed(options.state)
    left = [
        (protocol, row.name, seed)
        for protocol in protocols
        for row, seed in wanted(options, protocol)
        if (protocol, row.name, seed) not in passed
    ]
    return 1 if left else 0


def _run_lanes(options: argparse.Namespace, protocols: list[str]) -> None:
    # Forks: what a lane imports takes two seconds of a core, and this process has it.
    fork = multiprocessing.get_context("fork")
    running = []
    for protocol in protocols:
        lanes = (options.lanes or LANES[protocol]) if protocol == "ROS 2" else LANES[protocol]
        for number in range(lanes):
            running.append(fork.Process(target=_work_lane, args=(options, protocol, number, lanes)))
            running[-1].start()
    try:
        for each in running:
            each.join()
    finally:
        for each in running:
            if each.is_alive():
                each.terminate()
                each.join(30)


def _work_lane(options: argparse.Namespace, protocol: str, number: int, lanes: int) -> None:
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    options.lane, options.number, options.of = protocol, number, lanes
    asyncio.run(lane(options))


if __name__ == "__main__":
    raise SystemExit(main())
