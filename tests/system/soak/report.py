"""The figures of a soak, each with its limit, as a table. Pure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypedDict

from .slopes import Point, Slope, Verdict, by_minute, judge, slope_of

__all__ = ["BOUNDS", "FIGURES", "Judged", "Sample", "passed", "table", "warm_s"]

# What may be added for each hour, after warm-up. Memory: what a process could go on with for a
# month (3 GiB); a count may not grow at all, and gets what its own noise needs.
MEMORY = 4.0
# In a short run much is there for the first time: code, connections, pages of the database.
MEMORY_WHILE_WARMING = 60.0
FIGURES: Mapping[str, float] = {
    **{f"{each}: memory (RSS), MiB": MEMORY for each in ("hub", "gateway")},
    **{f"{each}: memory (anonymous), MiB": MEMORY for each in ("hub", "gateway")},
    **{f"{each}: descriptors": 1.0 for each in ("hub", "gateway")},
    **{f"{each}: threads": 1.0 for each in ("hub", "gateway")},
    **{f"{each}: tasks": 1.0 for each in ("hub", "gateway")},
    "hub: WAL, MiB": 1.0,
    "hub: database, MiB": 8.0,
    "gateway: spool, MiB": 1.0,
    "gateway: all else it keeps, MiB": 1.0,
    "/dev/shm, MiB": 1.0,
    "/dev/shm, files": 1.0,
    "logs, MiB": 4.0,
}
# Rows of the database: the history is kept in blocks; all else follows what people do.
ROWS_EACH_HOUR = 5_000.0
# What goes up and down by hours: not its slope is judged but the most of it. The journal keeps up
# to 630 000 samples until those of its slowest signal are saved, and a row holds six of this load.
# What was read of the history is kept up to a million samples, which takes longer than a run; so
# memory is judged without it.
CACHE = "hub: cache of what was read, MiB"
BOUNDS: Mapping[str, float] = {"rows of history_hot": 120_000.0, CACHE: 16.0}
# Runs that are shorter cannot tell such small slopes from noise; what is unclear there passes.
WHOLE_H = 2.0
OF_DISK = ("WAL", "database", "spool", "keeps")


class Sample(TypedDict):
    """One look at all of it.

    Attributes:
        s: since the beginning.
        figures: by name; one of a process begins with its name.
        rows: of each table of the hub's database, once in a while.
        lives: how often each process has been killed so far.
        ages: how long each process has been ready (s).
        done: how often what was done so far.
        errors: what must not have happened so far.
        cpu_s: processor time of all processes so far.

    """

    s: float
    figures: dict[str, float]
    rows: dict[str, int]
    lives: dict[str, int]
    ages: dict[str, float]
    done: dict[str, int]
    errors: list[str]
    cpu_s: float


class Judged(NamedTuple):
    """A figure, what was seen of it after warm-up, and its verdict; limit: what it was held to."""

    name: str
    values: list[float]
    slope: Slope | None
    limit: str
    verdict: Verdict


def warm_s(hours: float) -> float:
    """Give what is left out at the beginning of each life of a process (s)."""
    return min(1800.0, hours * 900)


def limit_of(name: str, *, whole: bool) -> float:
    """Give what may be added each hour."""
    if "memory" in name and not whole:
        return MEMORY_WHILE_WARMING
    return FIGURES.get(name, ROWS_EACH_HOUR)


def judged(samples: Sequence[Sample]) -> list[Judged]:
    """Judge each figure, and the rows of each table that changed."""
    points = _points(samples)
    tables = sorted(
        name for name, found in points.items()
        if name.startswith("rows of ") and len({each.value for each in found}) > 1
    )  # fmt: skip
    whole = _is_whole(samples)
    cache = [CACHE] if CACHE in points else []
    names = [*FIGURES, *cache, *tables]
    return [_judged(name, points.get(name, []), whole=whole) for name in names]


def _is_whole(samples: Sequence[Sample]) -> bool:
    return samples[-1]["s"] >= WHOLE_H * 3600 - 60


def _judged(name: str, points: Sequence[Point], *, whole: bool) -> Judged:
    values, slope = [each.value for each in points], slope_of(by_minute(points))
    if name in BOUNDS:
        bound = BOUNDS[name]
        verdict = Verdict.BROKEN if max(values, default=0.0) > bound else Verdict.HOLDS
        return Judged(name, values, slope, f"most {bound:,.0f}", verdict)
    limit = limit_of(name, whole=whole)
    return Judged(name, values, slope, f"{limit:+,.0f}", judge(slope, limit))


def _points(samples: Sequence[Sample]) -> dict[str, list[Point]]:
    """Give the points of each figure, without those of warming up."""
    warm = warm_s(samples[-1]["s"] / 3600)
    points: dict[str, list[Point]] = {}
    for sample in samples:
        rows = {f"rows of {name}": number for name, number in sample["rows"].items()}
        cached = sample["figures"].get(CACHE, 0.0)
        for name, all_of_it in {**sample["figures"], **rows}.items():
            value = all_of_it - cached if name.startswith("hub: memory") else all_of_it
            whom = name.partition(":")[0]
            lives = whom in sample["lives"] and not any(word in name for word in OF_DISK)
            age = sample["ages"][whom] if lives else sample["s"]
            if age >= warm:
                life = sample["lives"][whom] if lives else 0
                points.setdefault(name, []).append(Point(sample["s"] / 3600, value, life))
    return points


def passed(samples: Sequence[Sample]) -> bool:
    """Tell whether nothing was broken, and in a whole run nothing unclear."""
    bad = {Verdict.BROKEN} | ({Verdict.UNCLEAR} if _is_whole(samples) else set())
    return not samples[-1]["errors"] and not any(e.verdict in bad for e in judged(samples))


def table(samples: Sequence[Sample]) -> str:
    """Write the table, in Markdown."""
    last = samples[-1]
    lines = [
        f"{last['s'] / 3600:.2f} h, of which the first {warm_s(last['s'] / 3600) / 60:.0f} min of"
        f" each life of a process are left out; {last['cpu_s'] / max(1.0, last['s']):.0%} of one"
        " core for hub, gateway, robot and load together.",
        "",
        "| figure | first | last | most | slope each hour (95 %) | limit | |",
        "| --- | --: | --: | --: | --: | --: | --- |",
    ]
    for name, values, slope, limit, verdict in judged(samples):
        ends = (values[0], values[-1], max(values)) if values else ()
        shown = " | ".join(f"{each:,.1f}" for each in ends) or "– | – | –"
        said = "–"
        if slope:
            said = f"{slope.each_hour:+,.2f} ({slope.low:+,.2f} to {slope.high:+,.2f})"
        lines.append(f"| {name} | {shown} | {said} | {limit} | {verdict} |")
    done = ", ".join(f"{name} {count:,}" for name, count in sorted(last["done"].items()))
    lines += ["", f"Done meanwhile: {done}.", ""]
    lines += [f"- error: {each}" for each in last["errors"]] or ["Errors: none."]
    return "\n".join([*lines, ""])
