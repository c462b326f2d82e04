"""What NAB says of detectors as they ship, and with bars chosen on other folders.

    PYTHONPATH=src:bench python bench/anomaly_folders.py FOLDER --detectors together,iqr

For each detector: the standard profile's score at its shipped bar; and with the bar that is best on
all other folders, leaving out each folder in turn. The folder holds NAB's series and
`windows.json`; they are not part of the project. Fails when one of them scores below 0 at its
shipped bar, or `together` below 73 with the bars of other folders.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import anomaly
import nab
import numpy as np

from talaia.hub.anomaly.kinds import KINDS

LEAST_TOGETHER = 73.0
# Limits are a person's; of the others each is tried.
TRIED = [name for name in KINDS if name != "limits"]
# Bars that are tried: so many quantiles of the scores near their greatest.
TAIL = np.unique(np.concatenate([np.geomspace(2e-5, 0.05, 40), [0.1, 0.2]]))


def folder_of(name: str) -> str:
    """Give the folder that a series lies in."""
    return name.split("/", 1)[0]


def with_bars(
    name: str, series: list[nab.Series], scores: dict[str, np.ndarray]
) -> tuple[nab.Scored, nab.Scored]:
    """Score a detector at its shipped bar, and with bars chosen on other folders."""
    shipped = anomaly.told(name, series, scores, KINDS[name].bar)
    counting = np.concatenate([scores[one.name][one.probation :] for one in series])
    bars = np.unique(np.quantile(counting, 1.0 - TAIL))
    told = {bar: anomaly.told(name, series, scores, bar) for bar in bars[bars > 0.0].tolist()}
    chosen: dict[str, np.ndarray] = {}
    for folder in sorted({folder_of(one.name) for one in series}):
        others = [one for one in series if folder_of(one.name) != folder]
        best = max(told, key=lambda bar: nab.score(others, told[bar], bar).score)
        for one in series:
            if folder_of(one.name) == folder:
                # 1 where it tells of one: bars differ between folders.
                chosen[one.name] = (told[best][one.name] >= best).astype(float)
    return nab.score(series, shipped, KINDS[name].bar), nab.score(series, chosen, 1.0)


def main() -> int:
    """Print a table; 1 when a limit is missed."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("where", type=Path, help="NAB's folder data and windows.json")
    parser.add_argument("--detectors", default=",".join(TRIED), help="separated by commas")
    options = parser.parse_args()
    series, good = nab.load(options.where), True
    print("| detector | bar | score | found | false | bars of other folders | found | false |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for name in options.detectors.split(","):
        scores, _ = anomaly.run(KINDS[name].make, series)
        shipped, others = with_bars(name, series, scores)
        print(
            f"| `{name}` | {KINDS[name].bar:.2f} | {shipped.score:.1f} |"
            f" {shipped.found}/{shipped.windows} | {shipped.false} | {others.score:.1f} |"
            f" {others.found}/{others.windows} | {others.false} |",
            flush=True,
        )
        good = good and shipped.score > 0.0
        good = good and (name != "together" or others.score >= LEAST_TOGETHER)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
