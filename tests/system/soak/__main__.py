"""Run hub and gateway for hours under mixed load and faults, and judge what grows.

    PYTHONPATH=src:tests python -m system.soak HOURS [--table FILE] [--samples FILE] [--seed N]
    PYTHONPATH=src:tests python -m system.soak 0 --samples FILE

The second judges the samples of a run that was, or still goes on. It ends by itself; on SIGINT or
SIGTERM it ends early, with the table of what it has. The exit code is 1 when something grew over
its limit, or an error was seen.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import random
import signal
import sys
import tempfile
import time
from pathlib import Path
from typing import TextIO

from patience import lasts_for

from ..faults.world import World
from .load import Load
from .measure import Measure
from .report import Sample, passed, table

EVERY_S = 10.0
# The tasks are asked for, and rows are counted, at each so-many-th sample.
SELDOM = 6
# So long hub and gateway have to answer; an answer that is late is read the next time.
ANSWER_S = 1.0
TOLD_EVERY_S = 300.0
# From here on there are several lives, each long enough to be judged.
LONG_H = 6.0
# Beside the alarm that the world has of its own, which its description ends with.
ALARM = """\
  fast:
    {name: Too fast, kind: limit, signal: base/wheel1, above: 5, severity: critical}
"""


def kills(hours: float) -> list[tuple[float, str]]:
    """Give when whom to kill (s): long lives where there is time, else within the warm-up.

    A life is judged after its first half hour; what is left of one hour is too short for that.
    """
    if hours < LONG_H:
        return [(hours * 3600 * 0.05, "hub"), (hours * 3600 * 0.1, "gateway")]
    period = max(1.0, hours / 6) * 3600
    times = int(hours * 3600 / period)
    hub = [(period * each, "hub") for each in range(1, times)]
    gateway = [(period * (each + 0.5), "gateway") for each in range(times)]
    return sorted(hub + gateway)


class Run:
    """One run, sample by sample."""

    def __init__(self, world: World, options: argparse.Namespace, kept: TextIO | None) -> None:
        """Load and measure a world that is ready; samples go to ``kept``, too."""
        chance = random.Random(f"soak:{options.seed}")  # noqa: S311 - a test's decisions
        self.samples: list[Sample] = []
        self._hours = options.hours
        self._measure = Measure(world)
        self._load = Load(world, self._measure, chance)
        self._kept = kept
        self._began = time.monotonic()

    async def run(self) -> None:
        """Go on until the time is over or the load breaks down."""
        loading = asyncio.create_task(self._load.run(kills(self._hours)))
        turn, told = 0, 0.0
        try:
            # Not ended while somebody starts again: he could not be asked for anything.
            while (
                self._passed_s < self._hours * 3600 or self._load.killing
            ) and not loading.done():
                due = self._began + turn * EVERY_S
                await asyncio.wait({loading}, timeout=max(0.0, due - time.monotonic()))
                await self._sample(seldom=turn % SELDOM == 1)
                turn += 1
                if self._passed_s > told + TOLD_EVERY_S:
                    told = self._passed_s
                    print(f"\n{told / 60:.0f} min\n{table(self.samples)}", flush=True)
        finally:
            broke_down = loading.done()
            loading.cancel()
            (ended,) = await asyncio.gather(loading, return_exceptions=True)
            if broke_down:
                self._load.errors.append(f"the load broke down: {ended!r}")
            await self._sample(seldom=True)

    @property
    def _passed_s(self) -> float:
        return time.monotonic() - self._began

    async def _sample(self, *, seldom: bool) -> None:
        if seldom:
            self._measure.ask_tasks()
            await lasts_for(ANSWER_S)
        now = time.monotonic()
        sample = Sample(
            s=round(now - self._began, 1),
            figures=self._measure.figures(),
            rows=self._measure.tables() if seldom else {},
            lives=dict(self._load.lives),
            ages={name: round(now - at, 1) for name, at in self._load.ready_at.items()},
            done=dict(self._load.done),
            errors=list(self._load.errors),
            cpu_s=round(self._measure.cpu_s, 1),
        )
        self.samples.append(sample)
        if self._kept:
            self._kept.write(json.dumps(sample) + "\n")
            self._kept.flush()


async def soak(world: World, options: argparse.Namespace) -> list[Sample]:
    """Run until the time is over, or until told to end; gives the samples."""
    await world.ready()
    with contextlib.ExitStack() as stack:
        kept = stack.enter_context(options.samples.open("w")) if options.samples else None
        run = Run(world, options, kept)
        task = asyncio.create_task(run.run())
        for number in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(number, task.cancel)
        with contextlib.suppress(asyncio.CancelledError):
            await task
    return run.samples


def main() -> int:
    """Give 0 when nothing grew over its limit."""
    parser = argparse.ArgumentParser("soak", description="Run for hours and judge what grows.")
    parser.add_argument("hours", type=float, help="0: judge the samples of another run")
    parser.add_argument("--table", type=Path, help="write the table to this file, too")
    parser.add_argument("--samples", type=Path, help="write each sample to this file (JSON lines)")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if options.hours:
        for each in filter(None, (options.table, options.samples)):
            each.parent.mkdir(parents=True, exist_ok=True)
        found = run_world(options)
    else:
        found = [json.loads(line) for line in options.samples.read_text().splitlines()]
    said = table(found)
    print(said)
    if options.table:
        options.table.write_text(said)
    return 0 if passed(found) else 1


def run_world(options: argparse.Namespace) -> list[Sample]:
    """Make a world, soak it, and end it."""
    with tempfile.TemporaryDirectory(prefix="talaia-soak-") as folder:
        World.description += ALARM
        world = World(Path(folder))
        try:
            return asyncio.run(soak(world, options))
        finally:
            world.close()


if __name__ == "__main__":
    sys.exit(main())
