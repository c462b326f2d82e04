"""Let a judge of other make play nights against `talaia plan drive`, and print its figures.

    PYTHONPATH=src .venv/bin/python bench/night_judge.py SCORE.PY FOLDER [--match GLOB] [--fair]
        [--clear] [--jobs 1]

SCORE.PY is the judge of the format `talaia-night/1` (`score.py drive NIGHT -- COMMAND`): it has a
sky of its own (astropy), knows weather and arrivals, and holds every block to its constraints
minute by minute. Its figures stand beside the *must* of the design. Times are those of the judge's
clock, pipes included: a busy machine makes them longer.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np


def judge_night(score: Path, night: Path, words: list[str], *, clear: bool) -> dict[str, Any]:
    """Play one night; gives what the judge prints, and `alone`: see `waits_alone`."""
    planner = [sys.executable, "-m", "talaia", "plan", "drive", *words]
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log.json"
        command = [sys.executable, str(score), "drive", str(night), *(["--clear"] if clear else [])]
        done = subprocess.run(
            [*command, "--log", str(log), "--", *planner],
            capture_output=True,
            text=True,
            env=os.environ,
            check=False,
        )
        if not done.stdout:
            raise RuntimeError(f"{night.name}: {done.stderr[-2000:]}")
        found = dict(json.loads(done.stdout))
        blocks = json.loads(log.read_text())["log"]
    found["alone"] = waits_alone(json.loads(night.read_text())["requests"], blocks, found["too"])
    return found


def waits_alone(
    requests: list[dict[str, Any]], blocks: list[dict[str, Any]], judged: list[int | None]
) -> list[int]:
    """Give the waits of those rapid requests that had no other one before or beside them (s).

    A rapid request does not interrupt another one: what waits for it says nothing of the chain.
    ``judged`` are the waits that the judge counts, of those that could be observed when they came.
    """
    first: dict[str, int] = {}
    last: dict[str, int] = {}
    for block in blocks:
        first.setdefault(block["request"], block["start"])
        last[block["request"]] = block["end"]
    rapid = [request for request in requests if request["kind"] == "rapid"]
    left, alone = list(judged), []
    for one in rapid:
        begins = first.get(one["id"])
        wait = None if begins is None else begins - one["arrives"]
        if not left or left[0] != wait:
            continue
        left.pop(0)
        if wait is None or begins is None:
            continue
        others = [each for each in rapid if each is not one and each["id"] in first]
        if all(begins <= each["arrives"] or last[each["id"]] <= one["arrives"] for each in others):
            alone.append(wait)
    return alone


def size_of(path: Path) -> int:
    """Count the requests of a night."""
    return len(json.loads(path.read_text())["requests"])


def print_table(size: int, rows: list[dict[str, Any]]) -> None:
    """Print the figures of the nights of one size, in the mean."""
    gaps = np.array([row["gap"] for row in rows])
    error = gaps.std(ddof=1) / len(gaps) ** 0.5 if len(gaps) > 1 else float("nan")
    too = [wait for row in rows for wait in row["too"] if wait is not None]
    alone = [wait for row in rows for wait in row["alone"]]
    missed = sum(wait is None for row in rows for wait in row["too"])
    releases = [wait for row in rows for wait in row["release"]]
    limit = 0.5 if size <= 1000 else 1.0
    must = {100: 12, 1000: 18, 10_000: 23}.get(
        min((100, 1000, 10_000), key=lambda n: abs(n - size))
    )
    lines = [
        ("nights", f"{len(rows)} of about {size} requests", ""),
        ("gap, mean", f"{gaps.mean():.1f} ± {error:.1f} %, worst {gaps.max():.1f}", f"{must} %"),
        ("open shutter / usable", f"{np.mean([row['shutter'] for row in rows]):.3f}", "0.82"),
        ("unfair (of that by too much)", f"{np.mean([row['unfair'] for row in rows]):.3f}"
         f" ({np.mean([row['over'] for row in rows]):.3f})", "0.12"),
        ("decision, p50 / p95 of a night, in the mean",
         " / ".join(f"{np.mean([row['decide_ms_p50_p95_max'][n] for row in rows]) / 1000:.3f}"
                    for n in (0, 1)) + " s", f"p95 {limit} s"),
        ("rapid -> first exposure, p50 / p95",
         (f"{np.percentile(too, 50):.0f} / {np.percentile(too, 95):.0f} s of {len(too)},"
          f" {missed} never" if too else "none came"), ""),
        ("the same of those alone",
         f"{np.percentile(alone, 50):.0f} / {np.percentile(alone, 95):.0f} s of {len(alone)}"
         if alone else "none came", "p95 60 s"),
        ("release -> exposure, p50 / p95",
         " / ".join(f"{np.percentile(releases, n):.0f}" for n in (50, 95)) + " s"
         if releases else "none", "unpark + settle + acquire + 1 s"),
        ("time-critical done", f"{np.mean([row['tc'] for row in rows]):.2f}", ""),
        ("violations; refused decisions", f"{sum(row['violations'] for row in rows)};"
         f" {sum(row['refused'] for row in rows)}", "0; 0"),
    ]  # fmt: skip
    for name, found, wanted in lines:
        print(f"| {name} | {found} | {wanted} |")
    print()


def main() -> int:
    """Judge every night of a folder; 1 where anything was violated or refused."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("score", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--match", default="*.json")
    parser.add_argument("--fair", action="store_true")
    parser.add_argument("--clear", action="store_true")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    fair = ["--fair"] if options.fair else []
    nights = sorted(options.folder.glob(options.match))
    by_size: dict[int, list[dict[str, Any]]] = {}
    with ThreadPoolExecutor(options.jobs) as pool:
        found = pool.map(
            lambda path: judge_night(options.score, path, fair, clear=options.clear), nights
        )
        for path, row in zip(nights, found, strict=True):
            print(
                path.name,
                *(f"{name} {row[name]:.3g}" for name in ("gap", "shutter", "unfair", "refused")),
                flush=True,
            )
            size = 10 ** round(np.log10(size_of(path)))
            by_size.setdefault(size, []).append(row)
    for size, rows in sorted(by_size.items()):
        print_table(size, rows)
    wrong = any(row["violations"] or row["refused"] for rows in by_size.values() for row in rows)
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
