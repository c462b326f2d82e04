"""Measure what the product promises, and print each figure beside its limit.

    make bench                   all of it, about four minutes
    make bench ARGS="load page"  only some parts: load, idle, page, drive, drive-demo,
                                 size, demo, history, signin

The limits are those of the first slice. A figure over its limit is marked, and the exit code is
then 1; a shared or busy machine makes single runs noisy, so look twice before you believe one.
"""

from __future__ import annotations

import argparse
import asyncio
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import clients
import numpy as np
import pages
import signin
import stack

TOPICS, RATE = 20, 100.0
ROOT = Path(__file__).resolve().parent.parent


class Figure(NamedTuple):
    """One measured number, its limit and its unit."""

    what: str
    measured: float
    limit: float
    unit: str


def percentiles(what: str, ages: np.ndarray, p50: float, p99: float) -> list[Figure]:
    """Give the two figures of a distribution of ages in ms."""
    if not ages.size:
        raise SystemExit(f"{what}: nothing arrived")
    return [
        Figure(f"{what}, p50 of {ages.size}", float(np.percentile(ages, 50)), p50, "ms"),
        Figure(f"{what}, p99", float(np.percentile(ages, 99)), p99, "ms"),
    ]


async def load() -> list[Figure]:
    """20 Float64 topics at 100 Hz: what gateway and hub cost, and how old a sample arrives."""
    figures = []
    async with stack.running(TOPICS) as here, stack.publisher(here, TOPICS, RATE):
        session = await clients.cookie(here)
        await asyncio.sleep(3)
        gateway = stack.cpu_percent(here.gateway, 15)
        alone = stack.cpu_percent(here.hub, 15)
        for name, used, limit in (
            ("gateway, 20 × 100 Hz", await gateway, 12.0),
            ("hub, 20 × 100 Hz, no browser", await alone, 25.0),
        ):
            figures.append(Figure(f"CPU of the {name}", used, limit, "% of a core"))
        ages = await clients.listen(here, session, TOPICS, 0, 15)
        figures += percentiles("ROS → WebSocket client of the hub", ages, 15, 30)
        many = [
            asyncio.create_task(clients.listen(here, session, TOPICS, 50, 20)) for _ in range(10)
        ]
        await asyncio.sleep(3)
        used = await stack.cpu_percent(here.hub, 14)
        figures.append(Figure("CPU of the hub, ten browsers", used, 25.0, "% of a core"))
        await asyncio.gather(*many)
    return figures


async def idle() -> list[Figure]:
    """What an unwatched camera costs the gateway beyond what it stores, and a silent robot."""
    plain, unwatched = [], []
    async with stack.running(TOPICS, camera=True) as here:
        await asyncio.sleep(3)
        silent = await stack.cpu_percent(here.gateway, 12)
        for _ in range(3):  # in turn, since the machine's speed drifts
            for more, into in (((), plain), (("--camera",), unwatched)):
                async with stack.publisher(here, TOPICS, RATE, *more):
                    await asyncio.sleep(3)
                    into.append(await stack.cpu_percent(here.gateway, 8))
    beyond = float(np.median(np.array(unwatched) - np.array(plain)))
    return [
        Figure("gateway, a camera nobody watches, beyond 20 × 100 Hz", beyond, 3.0,
               "% of a core"),
        Figure("gateway, silent robot", silent, 1.0, "% of a core"),
    ]  # fmt: skip


async def page() -> list[Figure]:
    """A sample's way from ROS to the painted chart in Chromium, at 2 000 samples/s."""
    async with stack.running(TOPICS) as here, stack.publisher(here, TOPICS, RATE):
        ages = await pages.painted(here, seconds=20)
    return percentiles("ROS → painted in Chromium", ages, 80, 150)


async def drive() -> list[Figure]:
    """A key press in Chromium until the vehicle has the command."""
    async with stack.running(1) as here:
        target = here.folder / "driven.txt"
        async with stack.publisher(here, 1, 20.0, "--listen", str(target)):
            ages = await pages.pressed(here, target, presses=120)
    return percentiles("key press → cmd_vel received", ages, 10, 10)


async def drive_demo() -> list[Figure]:
    """The same in the whole demo, camera drawn in software and shown: all cores are busy."""
    with tempfile.TemporaryDirectory() as folder:
        ages = await pages.pressed_in_demo(Path(folder), presses=200)
    return percentiles("key press → taken by the demo's vehicle", ages, 10, 30)


async def size() -> list[Figure]:
    """What the first pages weigh, and how soon they are painted."""
    async with stack.running(1) as here:
        kilobytes, paint = await pages.first_paint(here)
    return [
        Figure("JavaScript of sign-in and home, gzip", kilobytes, 200, "kB"),
        Figure("first paint of the dashboard", paint, 1000, "ms"),
    ]


async def demo() -> list[Figure]:
    """How soon the demo is ready on a warm machine."""
    seconds = [await asyncio.to_thread(pages.demo_seconds) for _ in range(3)]
    return [Figure("demo ready, median of 3", float(np.median(seconds)), 10, "s")]


async def history() -> list[Figure]:
    """The history store beside one row a sample; prints its own table."""
    script = str(ROOT / "bench" / "history.py")
    done = await asyncio.to_thread(subprocess.run, [sys.executable, script], check=False)
    return [Figure("limits of the history that are missed", done.returncode, 0, "limits")]


async def signin_() -> list[Figure]:
    """Whether a refused sign-in tells by its time that there is a person of that name."""
    known, other = await signin.refusals(60)
    middle = float(np.median(known))
    beyond = abs(middle - float(np.median(other))) / middle * 100
    # Two halves of the same: what the machine alone makes of it.
    noise = abs(float(np.median(known[::2])) - float(np.median(known[1::2]))) / middle * 100
    return [
        Figure("known and unknown name, medians apart", beyond, 10.0, "%"),
        Figure("the same name twice, medians apart (noise)", noise, 10.0, "%"),
    ]


PARTS = {
    "load": load, "idle": idle, "page": page, "drive": drive, "drive-demo": drive_demo,
    "size": size, "demo": demo, "history": history, "signin": signin_,
}  # fmt: skip


def main() -> int:
    """Run the parts asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("part", nargs="*", help=f"of: {', '.join(PARTS)} (all)")
    chosen = parser.parse_args().part or list(PARTS)
    over = 0
    for name in chosen:
        print(f"── {name}: {(PARTS[name].__doc__ or '').strip()}", flush=True)
        for figure in asyncio.run(PARTS[name]()):
            fits = figure.measured <= figure.limit
            over += not fits
            ratio = figure.measured / figure.limit if figure.limit else 0.0
            mark = "" if fits else "   OVER"
            print(
                f"   {figure.what:<56} {figure.measured:8.2f} {figure.unit:<11}"
                f" limit {figure.limit:6.1f}  ratio {ratio:5.2f}{mark}",
                flush=True,
            )
    return 1 if over else 0


if __name__ == "__main__":
    raise SystemExit(main())
