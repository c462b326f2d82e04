"""How often a healthy site cries when it may once a week, and which planted faults are found.

    PYTHONPATH=src:bench python bench/false_alarms.py --seeds 1-30 --kept FILE [--faults 5]

The signals are made (see `made_sites`): a row every second, or every ``TALAIA_BENCH_STEP_S``
seconds, which is quicker. A site learns for seven days; its thresholds are set from these by the
same code as at the hub, and again after each hour. Every signal has `together`, every device a
group of all its signals with a row every three seconds, which learns what is usual from the first
day. A false alarm is an anomaly of a healthy site after the seven days; anomalies that overlap, or
begin within a minute of each other, are one alarm.

A fault counts from the moment at which it has changed a signal by more than three times its noise
(the spread around a mean of five minutes, before the fault). It is found if an alarm begins between
its beginning and 60 s after that moment. Beside it stands how often as long a stretch of the
healthy site would have been called so: an alarm that has nothing to do with the fault.

With ``--only residuals`` nothing but what each signal does against the others (`SignalResiduals`)
is judged, with the budget for itself, which takes a tenth of the time.

Each site's result is a line of ``FILE``; what stands there is not played again.
"""

from __future__ import annotations

import argparse
import copy
import json
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from made_sites import DAY_S, FAULTS, STEP_S, Fault, MadeSite, make_site

from talaia.hub.anomaly.budget.score_tail import ScoreTail
from talaia.hub.anomaly.budget.thresholds import site_thresholds
from talaia.hub.anomaly.episodes import Episodes
from talaia.hub.anomaly.groups.group_runner import GroupRunner
from talaia.hub.anomaly.runner import DetectorRunner
from talaia.model.alarms.anomaly import DetectorKind, SignalGroup, Watch
from talaia.model.alarms.signal_groups import GroupSignals

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.hub.anomaly.episode_runner import EpisodeRunner

    Floats = NDArray[np.float64]

_LEARNED_DAYS = 7
# A group has a row every so many seconds: what is usual is learned from the first day, which holds
# all that the site does, and that many rows may be learned from.
_GROUP_S = max(3, STEP_S)
_LEARN_ROWS = DAY_S // _GROUP_S
_FOUND_WITHIN_S, _FAULT_S = 60, 600
_ONE_CAUSE_S = 60
_ROWS = 512


@dataclass
class _Site:
    """All detectors of a site, as the switch makes them."""

    made: MadeSite
    singles: list[DetectorRunner] = field(default_factory=list)
    # With the columns of its signals.
    groups: list[tuple[GroupRunner, list[int]]] = field(default_factory=list)
    # When anomalies of residuals alone begin and end, for each group; empty: all is judged.
    alone: list[Episodes] = field(default_factory=list)

    def runners(self) -> list[EpisodeRunner]:
        return [*self.singles, *(runner for runner, _ in self.groups)]


def _new_site(made: MadeSite, *, only_residuals: bool) -> _Site:
    site = _Site(made)
    watch = Watch(detector=DetectorKind.TOGETHER)
    if not only_residuals:
        site.singles = [DetectorRunner(name, "", watch) for name in made.names]
    for device in dict.fromkeys(name.partition("/")[0] for name in made.names):
        of_it = [at for at, name in enumerate(made.names) if name.startswith(f"{device}/")]
        signals = tuple(made.names[at] for at in of_it)
        group = SignalGroup(device=device, modes=4, learn=_LEARN_ROWS, step=float(_GROUP_S))
        beside = [at for at in range(len(made.names)) if at not in of_it]
        others = tuple(made.names[at] for at in beside)
        asked = GroupSignals(device, group, signals, signals, device, beside=others)
        site.groups.append((GroupRunner(asked), of_it + beside))
        if only_residuals:
            site.alone.append(Episodes(bar=0.5, rest=1))
    for runner in site.runners():
        runner.tail = ScoreTail()
    return site


@dataclass
class _Rated:
    """What a detector said of rows: times (n,), scores (n,), magnitudes (n, m)."""

    runner: EpisodeRunner
    episodes: Episodes
    times: NDArray[np.int64]
    scores: Floats
    magnitudes: Floats

    def part(self, from_us: int, to_us: int) -> _Rated:
        """Give a stretch of it (µs)."""
        at = slice(*np.searchsorted(self.times, (from_us, to_us)))
        return _Rated(
            self.runner, self.episodes, self.times[at], self.scores[at], self.magnitudes[at]
        )


def _rate_rows(site: _Site, first: int, upto: int, instead: Floats | None = None) -> list[_Rated]:
    """Show rows (or others instead) to all detectors; what they say knows of no threshold."""
    times = site.made.time_s[first:upto] * 1_000_000
    values = site.made.values[first:upto] if instead is None else instead
    found = []
    for column, runner in enumerate(site.singles):
        said = [
            runner.detector.rate_many(times[at : at + _ROWS], values[at : at + _ROWS, column])
            for at in range(0, len(times), _ROWS)
        ]
        scores, rated = (np.concatenate(one) for one in zip(*said, strict=True))
        found.append(_Rated(runner, runner.episodes, times, scores, rated))
    # Of several values in a step the last one counts.
    by = _GROUP_S // STEP_S
    times = times[by - 1 :: by]
    for place, (runner, columns) in enumerate(site.groups):
        rows = values[by - 1 :: by, columns]
        scores, distances = np.zeros((2, len(rows)))
        if not site.alone and not runner.group.is_single:
            own = rows[:, : len(runner.members)]
            scores, distances = np.array(runner.detector.see_rows(times, own, [-1] * len(rows)))
        rated = np.column_stack((distances, runner.residuals.see_rows(times, rows)))
        episodes = site.alone[place] if site.alone else runner.episodes
        found.append(_Rated(runner, episodes, times, scores, rated))
    return found


def _follow(said: _Rated) -> list[tuple[int, str, bool]]:
    """Do with what a detector said what the hub does: tell whose anomalies turned, and when.

    True where one began.
    """
    runner, times, rated = said.runner, said.times, said.magnitudes
    if isinstance(runner, GroupRunner):
        return _follow_group(said)
    learned = min(runner.learning, len(times))
    strong = said.scores >= said.episodes.bar
    runner.tail.record_many(times[learned:], strong[learned:], rated[learned:])
    enough = np.ones(len(times), bool)
    if runner.needs:
        enough = (rated >= np.array(runner.needs)).any(axis=1)
    turns, done = [], 0
    while done < len(times):
        if said.episodes.began_us < 0:
            coming = np.flatnonzero(strong[done:] & enough[done:])
            calm = int(coming[0]) if len(coming) else len(times) - done
            said.episodes.pass_calm(calm)
            done += calm
            if done == len(times):
                break
        turn = said.episodes.update_score(
            int(times[done]), float(said.scores[done]), may_begin=bool(enough[done])
        )
        if turn is not None:
            turns.append((int(times[done]), runner.address, turn == "began"))
            if turn == "ended":
                said.episodes.end_episode()
        done += 1
    return turns


def _follow_group(said: _Rated) -> list[tuple[int, str, bool]]:
    """Do what `GroupRunner` does with a distance and residuals, all at once."""
    runner, times, rated = said.runner, said.times, said.magnitudes
    runner.tail.record_many(times, (rated > 0.0).any(axis=1), rated)
    bar, episodes = said.episodes.bar, said.episodes
    needs = np.full(rated.shape[1], np.inf)
    needs[: len(runner.needs)] = np.maximum(runner.needs, 1e-300)
    if runner.needs and not runner.residuals.trusted:
        raise SystemExit("residuals have thresholds before they have learned")
    excess = (rated / needs)[:, 1:].max(axis=1)
    may_begin = (rated >= needs).any(axis=1) if runner.needs else np.ones(len(times), bool)
    coming = (np.maximum(said.scores, _score_of_excess(excess, bar)) >= bar) & may_begin
    # One that is on goes on down to half of the threshold.
    goes_on = np.maximum(said.scores, _score_of_excess(2.0 * excess, bar))
    turns, at = [], 0
    while at < len(times):
        if episodes.began_us < 0:
            found = np.flatnonzero(coming[at:])
            calm = int(found[0]) if len(found) else len(times) - at
            episodes.pass_calm(calm)
            at += calm
            if at == len(times):
                break
        # That it may begin is known: its score counts only while it is on.
        score = 1.0 if episodes.began_us < 0 else float(goes_on[at])
        turn = episodes.update_score(int(times[at]), score)
        if turn is not None:
            turns.append((int(times[at]), runner.address, turn == "began"))
            if turn == "ended":
                episodes.end_episode()
        at += 1
    return turns


def _score_of_excess(excess: Floats, bar: float) -> Floats:
    beyond = bar + (1.0 - bar) * (1.0 - 1.0 / np.maximum(excess, 1.0))
    return np.where(excess < 1.0, bar * excess, beyond)


def _live(
    site: _Site, first: int, upto: int, instead: Floats | None = None
) -> list[tuple[int, str, bool]]:
    """Show rows (or others instead) as live, with the thresholds that there are."""
    return [turn for said in _rate_rows(site, first, upto, instead) for turn in _follow(said)]


def _copy(site: _Site) -> _Site:
    """Copy what has learned, and not what the signals were."""
    return copy.deepcopy(site, {id(site.made): site.made})


def _adjust(site: _Site, a_week: float) -> str:
    tails = {(runner.address, runner.word): runner.tail for runner in site.runners()}
    found = site_thresholds(tails, a_week)
    for runner in site.runners():
        runner.set_needs(found.of.get((runner.address, runner.word), ()))
    return found.basis


def _alarms(turns: list[tuple[int, str, bool]]) -> list[tuple[int, list[str]]]:
    """Count what overlaps, or begins within a minute, as one alarm."""
    alarms: list[tuple[int, list[str]]] = []
    on: set[str] = set()
    free_us = -1
    for time_us, who, began in sorted(turns):
        if not began:
            on.discard(who)
            free_us = time_us + _ONE_CAUSE_S * 1_000_000
            continue
        if on or time_us < free_us:
            alarms[-1][1].append(who)
        else:
            alarms.append((time_us, [who]))
        on.add(who)
        free_us = max(free_us, time_us + _ONE_CAUSE_S * 1_000_000)
    return alarms


def _noise(before: Floats) -> Floats:
    """Give each signal's spread around a mean of five minutes."""
    width = 300 // STEP_S
    means = np.apply_along_axis(
        lambda column: np.convolve(column, np.ones(width) / width, "same"), 0, before
    )
    return np.maximum((before - means)[width:-width].std(axis=0), 1e-6)


def _try_fault(site: _Site, fault: Fault, first: int, seed: int) -> str:
    """Plant a fault; tell how it was found: a delay in seconds, ``missed``, or ``no effect``."""
    rows = _FAULT_S // STEP_S
    healthy = site.made.values[first : first + rows]
    rng = np.random.default_rng([seed, FAULTS.index(fault)])
    faulty = fault.plant(healthy.copy(), site.made.names, rng)
    noise = _noise(site.made.values[first - 3600 // STEP_S : first])
    large = np.flatnonzero((np.abs(faulty - healthy) > 3 * noise).any(axis=1))
    before = _began(_copy(site), healthy, first)
    turns = _began(_copy(site), faulty, first)
    if not len(large):
        # Nothing counts as found that moved no signal enough; whether it was told stands beside.
        began_us = int(site.made.time_s[first]) * 1_000_000
        told = f"told after {(turns[0][0] - began_us) // 1_000_000} s" if turns else "not told"
        return f"no effect, {told}"
    effect_us = int(site.made.time_s[first + int(large[0])]) * 1_000_000
    by_chance = " by chance" if _is_in_time(before, effect_us) else ""
    if not turns:
        return "missed"
    late_s = (turns[0][0] - effect_us) // 1_000_000
    return ("" if _is_in_time(turns, effect_us) else "late ") + f"{late_s}{by_chance}"


def _began(site: _Site, values: Floats, first: int) -> list[tuple[int, str]]:
    """Show a stretch of values; tell when anomalies began, and whose."""
    turns = sorted(_live(site, first, first + len(values), values))
    return [(time_us, who) for time_us, who, on in turns if on]


def _is_in_time(began: list[tuple[int, str]], effect_us: int) -> bool:
    return bool(began) and began[0][0] <= effect_us + _FOUND_WITHIN_S * 1_000_000


def _place_of(made: MadeSite, fault: Fault, begin: int) -> int:
    """Find where the machine runs in the fault's way and goes on so for a while."""
    stays = (
        np.convolve(made.mode[begin:] == fault.mode, np.ones(750 // STEP_S), "valid")
        >= 750 // STEP_S - 1
    )
    first = begin + int(np.flatnonzero(stays)[0]) + 100 // STEP_S
    # Where a group's row begins.
    return first - first % (_GROUP_S // STEP_S)


def _run(kind: str, seed: int, asked: argparse.Namespace) -> dict[str, object]:
    day, began_s = DAY_S // STEP_S, time.process_time()
    days = _LEARNED_DAYS + 7 * asked.weeks
    made = make_site(kind, seed, days + 2)
    site = _new_site(made, only_residuals=asked.only == "residuals")
    _live(site, 0, _LEARNED_DAYS * day)
    turns = []
    for one in range(_LEARNED_DAYS, days):
        # What detectors say is found for a day at once; what comes of it, hour by hour.
        said = _rate_rows(site, one * day, (one + 1) * day)
        begin_us = int(made.time_s[one * day]) * 1_000_000
        for hour in range(24):
            _adjust(site, asked.a_week)
            from_us, to_us = (begin_us + at * 3_600_000_000 for at in (hour, hour + 1))
            turns += [turn for part in said for turn in _follow(part.part(from_us, to_us))]
    alarms = _alarms(turns)
    _adjust(site, asked.a_week)
    found = _try_faults(site, kind, seed, days * day) if seed <= asked.faults else []
    whose = [
        f"day {(time_us / 1e6 - int(made.time_s[0])) / DAY_S:.2f}: {', '.join(sorted(set(who)))}"
        for time_us, who in alarms
    ]
    return {
        "kind": kind, "seed": seed, "step_s": STEP_S, "alarms": whose, "found": found,
        "cpu_s": round(time.process_time() - began_s),
    }  # fmt: skip


def _try_faults(site: _Site, kind: str, seed: int, done: int) -> list[tuple[str, str]]:
    """Plant each fault of a kind of site on the day after, each in a copy of the site."""
    results: list[tuple[str, str]] = []
    faults = [fault for fault in FAULTS if fault.site == kind]
    places = sorted(
        (_place_of(site.made, one, done + (DAY_S // 3 + at * 180) // STEP_S), at)
        for at, one in enumerate(faults)
    )
    for first, at in places:
        if first > done:
            _live(site, done, first)
            done = first
        results.append((faults[at].name, _try_fault(site, faults[at], first, seed)))
    return results


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", default="1-5")
    parser.add_argument("--faults", type=int, default=5, help="seeds up to this have faults")
    parser.add_argument("--a-week", type=float, default=1.0)
    parser.add_argument("--weeks", type=int, default=1)
    parser.add_argument("--only", choices=("residuals",))
    parser.add_argument("--sites", default="vehicle,observatory")
    parser.add_argument("--kept", type=Path, help="file that results are read from and added to")
    asked = parser.parse_args()
    low, _, high = asked.seeds.partition("-")
    results = []
    if asked.kept and asked.kept.exists():
        results = [json.loads(line) for line in asked.kept.read_text().splitlines()]
    done = {(one["kind"], one["seed"]) for one in results}
    for seed in range(int(low), int(high or low) + 1):
        for kind in asked.sites.split(","):
            if (kind, seed) in done:
                continue
            results.append(_run(kind, seed, asked))
            print(json.dumps(results[-1]), flush=True)
            if asked.kept:
                with asked.kept.open("a") as file:
                    file.write(json.dumps(results[-1]) + "\n")
    _print_tables(results, asked)


def _print_tables(results: list[dict[str, Any]], asked: argparse.Namespace) -> None:
    for kind in asked.sites.split(","):
        counts = [len(one["alarms"]) for one in results if one["kind"] == kind]
        rate = sum(counts) / (len(counts) * asked.weeks)
        print(f"{kind}: {rate:.2f} false alarms a week, budget {asked.a_week:g}; {counts}")
    found: dict[str, list[str]] = {}
    for name, how in (pair for one in results for pair in one["found"]):
        found.setdefault(name, []).append(how)
    every = [how for hows in found.values() for how in hows]
    for name, hows in found.items():
        print(f"| {name} | {sum(map(_is_found, hows))}/{len(hows)} | {', '.join(hows)} |")
    chance = sum("by chance" in how for how in every)
    print(
        f"found: {sum(map(_is_found, every))}/{len(every)}, {chance} of them maybe by chance;"
        f" {sum(map(_has_effect, every))} of them had an effect by the model's truth"
    )


def _is_found(how: str) -> bool:
    return how.removesuffix(" by chance").lstrip("-").isdigit()


def _has_effect(how: str) -> bool:
    return not how.startswith("no effect")


if __name__ == "__main__":
    sys.exit(main())
