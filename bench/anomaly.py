"""Score every detector with the standard profile of the Numenta Anomaly Benchmark.

    python bench/anomaly.py [WHERE] [--detectors NAMES] [--files]

``WHERE`` holds ``windows.json`` and ``data/``; without it ``TALAIA_NAB``, or ``../shared/data/nab``
beside the project. Every detector sees one sample at a time, knows nothing of the future, of a
file's length or of its range, and has one setting for all files. What counts as a detection is
what a person is told: the sample with which an anomaly begins (`Episodes`, one rest for all
detectors, and as quiet at the beginning as each is at the hub). The threshold is that with the
best total, as the benchmark has it.

Last, the hub's share of a core for a thousand signals at 1 Hz: a hundred of them are fed to its
own `AnomalyService`, with all that stands between a batch and a score that pages and history get.

The settings were chosen looking at every other file (A); the threshold found there is also
scored on the files between them (B). A limit that is missed makes the exit code 1.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import importlib.util
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import nab
import numpy as np

from talaia.clock import SystemClock
from talaia.hub.anomaly.base import AnomalyDetector
from talaia.hub.anomaly.episodes import Episodes, EpisodeTurn
from talaia.hub.anomaly.kinds import KINDS
from talaia.hub.live.detection.anomaly_service import AnomalyService
from talaia.hub.live.pages.fanout import Fanout
from talaia.hub.live.sites import Sites
from talaia.model.yaml_text.load import load_site
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from collections.abc import Sequence

ROOT = Path(__file__).resolve().parent.parent
GOALS = {"nearest": 55.0, "together": 70.0}
MOST_US = 1000.0
# Thresholds that are tried: these parts of all scores lie above.
PARTS = np.geomspace(1e-4, 3e-2, 60)
FINER = 21
# Limits and missing data have no opinion on these files: no limits are given, no data are missing.
SKIPPED = ("limits",)


# Of a core, for a thousand signals at 1 Hz.
MOST_CORE = 0.5
SIGNALS, LEARNED, LOOKED = 100, 1_000, 100


class Row(NamedTuple):
    """One detector's figures."""

    name: str
    all: nab.Scored
    chosen: nab.Scored
    rest: nab.Scored
    microseconds: float


class Peer(AnomalyDetector, kw_only=True):
    """PyPI's KNN-CAD with a fixed probation, where it is installed; for comparison."""

    def __post_init__(self) -> None:
        """Make the model."""
        import pysad.models

        global _PEER
        _PEER = pysad.models.KNNCAD(186)

    def see(self, time_us: int, value: float) -> float:
        """Score one sample; a matrix without an inverse scores 0."""
        try:
            with contextlib.redirect_stdout(None):
                return float(_PEER.fit_score_partial(np.array([value])))
        except np.linalg.LinAlgError:
            return 0.0


_PEER: object = None


def run(
    kind: type[AnomalyDetector], series: Sequence[nab.Series]
) -> tuple[dict[str, np.ndarray], float]:
    """Give all scores of a detector, and the time a sample takes (µs)."""
    scores, began, count = {}, time.process_time(), 0
    for one in series:
        detector = kind()
        scores[one.name] = np.array(
            [
                detector.see(*each)
                for each in zip(one.times.tolist(), one.values.tolist(), strict=True)
            ]
        )
        count += len(one.values)
    return scores, (time.process_time() - began) / count * 1e6


def told(
    name: str, series: Sequence[nab.Series], scores: dict[str, np.ndarray], bar: float
) -> dict[str, np.ndarray]:
    """Leave of the scores those with which an anomaly begins."""
    left = {}
    known = KINDS.get(name)
    quiet, learning = (known.quiet, known.learning) if known is not None else (0, 0)
    for one in series:
        mine = scores[one.name]
        episodes = Episodes(bar=bar, quiet=quiet, learning=learning)
        kept = np.zeros(len(mine))
        for at, (moment, score) in enumerate(zip(one.times.tolist(), mine.tolist(), strict=True)):
            turn = episodes.update_score(moment, score)
            if turn is EpisodeTurn.BEGAN:
                kept[at] = score
            elif turn is EpisodeTurn.ENDED:
                episodes.end_episode()
        left[one.name] = kept
    return left


def bars(series: Sequence[nab.Series], scores: dict[str, np.ndarray]) -> np.ndarray:
    """Name the thresholds that are tried."""
    counting = np.concatenate([scores[one.name][one.probation :] for one in series])
    return np.unique(np.quantile(counting, 1.0 - PARTS))


def measure(name: str, kind: type[AnomalyDetector], series: Sequence[nab.Series]) -> Row:
    """Score one detector on all files, and on each half with the threshold of the first."""
    scores, microseconds = run(kind, series)
    halves = (series, series[0::2], series[1::2])
    totals: list[tuple[nab.Scored, ...]] = []

    def try_out(tried: np.ndarray) -> None:
        for bar in tried[tried > 0.0].tolist():
            kept = told(name, series, scores, bar)
            totals.append(tuple(nab.score(half, kept, bar) for half in halves))

    coarse = bars(series, scores)
    try_out(coarse)
    for half in (0, 1):  # finer around the best, of all and of the first half
        if totals:
            best = max(totals, key=lambda each: each[half].score)[half].threshold
            near = int(np.searchsorted(coarse, best))
            low, high = coarse[max(near - 1, 0)], coarse[min(near + 1, len(coarse) - 1)]
            try_out(np.linspace(low, high, FINER))
    silent = nab.Scored(0.0, float("inf"), 0, sum(len(one.windows) for one in series), 0)
    if not totals:
        return Row(name, silent, silent, silent, microseconds)
    whole = max((each[0] for each in totals), key=lambda scored: scored.score)
    _, chosen, rest = max(totals, key=lambda each: each[1].score)
    return Row(name, whole, chosen, rest, microseconds)


def place(given: str) -> Path:
    """Find the series, or end with a message that says what to do."""
    where = Path(given or os.environ.get("TALAIA_NAB", "") or ROOT.parent / "shared/data/nab")
    if not (where / "windows.json").is_file():
        raise SystemExit(
            f"No NAB series at {where}: give the folder that holds windows.json and data/ as "
            "argument or in TALAIA_NAB. It is a part of github.com/numenta/NAB."
        )
    return where


class Nowhere:
    """Takes what is written and knows nothing; what a database costs is measured elsewhere."""

    async def append_samples(self, *_what: object) -> None:
        """Take scores."""

    async def states_of(self, _site: str) -> dict[tuple[str, str], bytes]:
        """Know of nothing that was learned."""
        return {}

    async def save_states(self, _rows: object) -> None:
        """Take what was learned."""


async def core_for_a_thousand() -> float:
    """Give the share of a core that a thousand signals at 1 Hz take, once they are known."""
    signals = "".join(
        f"      s{at}: {{name: S, primary: true, source: {{topic: /s{at}, type:"
        " std_msgs/msg/Float64, field: data}}\n"
        for at in range(SIGNALS)
    )
    site = load_site(
        "talaia: 1\nsite: bench\nname: Bench\nros2: {}\nservices: {anomaly_detection: true}\n"
        f"devices:\n  base:\n    name: Base\n    signals:\n{signals}"
    )
    sites, clock, nowhere = Sites(), SystemClock(), Nowhere()
    live = sites.describe_site(site, "c")
    watching = AnomalyService(
        sites=sites, history=nowhere, learned=nowhere, fanout=Fanout(sites, clock), clock=clock
    )
    running = asyncio.create_task(watching.run())
    chance, began = np.random.default_rng(1), 0.0
    for second in range(LEARNED + LOOKED):
        if second == LEARNED:
            began = time.process_time()
        at = np.full(SIGNALS, (1_700_000_000 + second) * 1_000_000)
        values = chance.normal(0.0, 1.0, SIGNALS)
        watching.enqueue_samples(live, Columns(np.arange(SIGNALS, dtype=np.uint16), at, values, {}))
        while watching.waiting:
            await asyncio.sleep(0)
    took = time.process_time() - began
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    return took / LOOKED * 1_000 / SIGNALS


def show(row: Row) -> bool:
    """Print one row; tell whether it keeps its limits."""
    goal = GOALS.get(row.name)
    well = (goal is None or row.all.score >= goal) and row.microseconds <= MOST_US
    limit = "" if goal is None else f"{goal:5.0f}"
    print(
        f"{row.name:20}{row.all.score:7.1f}{limit:>7}{row.all.threshold:9.3f}"
        f"{row.all.found:5d}/{row.all.windows}{row.all.false:7d}"
        f"{row.chosen.score:8.1f}{row.rest.score:8.1f}{row.microseconds:9.0f}"
        f"{'' if well else '   OVER ITS LIMIT'}",
        flush=True,
    )
    return well


def main() -> int:
    """Print all figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("where", nargs="?", default="")
    parser.add_argument("--detectors", default="", help="only these, separated by commas")
    asked = parser.parse_args()
    series = nab.load(place(asked.where))
    kinds = {name: kind.make for name, kind in KINDS.items() if name not in SKIPPED}
    if importlib.util.find_spec("pysad") is not None:
        kinds["pysad KNNCAD"] = Peer
    if asked.detectors:
        kinds = {name: kinds[name] for name in asked.detectors.split(",")}
    print(f"{len(series)} files, {sum(len(one.values) for one in series)} samples")
    print(
        f"{'detector':20}{'score':>7}{'limit':>7}{'bar':>9}{'found':>8}{'false':>7}"
        f"{'A':>8}{'B':>8}{'µs':>9}"
    )
    well = [show(measure(name, kind, series)) for name, kind in kinds.items()]
    core = asyncio.run(core_for_a_thousand())
    bad = core > MOST_CORE
    print(
        f"a thousand signals at 1 Hz with together: {core:.2f} of a core, limit {MOST_CORE:g}"
        f"{'   OVER ITS LIMIT' if bad else ''}"
    )
    return 0 if all(well) and not bad else 1


if __name__ == "__main__":
    sys.exit(main())
