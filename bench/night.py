"""Play the nights of a folder: the planner beside two dispatchers, each against the same bound.

    .venv/bin/python bench/night.py FOLDER [--clear] [--match GLOB] [--only NAME]

FOLDER holds files of `talaia-night/1` (docs/how-to/plan-a-night.md). Feasibility is the planner's
own here; a judge of other make plays against `talaia plan drive`. Times are processor time, so
that a busy machine does not change them. `--clear` leaves weather and rapid requests out.
`--astroplan` plays astroplan's scheduler, too (`night_astroplan.py` says how it is installed).
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, Protocol

import msgspec
import night_astroplan
import numpy as np
from night_events import take_event

from talaia.planner.between.overheads import overheads_from
from talaia.planner.bound import bound_value
from talaia.planner.dispatch import Choice, choose_now, rank_now, soonest_start
from talaia.planner.drive import DrivenNight
from talaia.planner.fairness import EVEN_HANDED, INDIFFERENT
from talaia.planner.night_file import (
    NightFile,
    NightRequest,
    make_problem,
    read_night,
)
from talaia.planner.night_problem import RAPID
from talaia.planner.progress import NightProgress
from talaia.planner.sky import MARK_S


class Planner(Protocol):
    """A planner that answers a judge's lines."""

    def answer_line(self, line: bytes) -> dict[str, object]:
        """Answer one line."""
        ...


class DispatchOnly:
    """Plain dispatch: what is worth most by a minute, now; rapid requests interrupt."""

    def answer_line(self, line: bytes) -> dict[str, object]:
        """Answer one line, as `talaia plan drive` does."""
        asked = json.loads(line)
        if asked["type"] == "night":
            self._problem = make_problem(msgspec.convert(asked["night"], NightFile))
            self._progress = NightProgress(self._problem)
            return {}
        progress = self._progress
        for name in asked.get("completed", []):
            progress.complete_visit(self._problem.table.index[name])
        for event in asked["events"]:
            take_event(self._problem, progress, event)
        if asked["type"] == "interrupt":
            return {"interrupt": True}
        choice = self.choose(asked["t"])
        if choice is None:
            start = soonest_start(progress, asked["t"])
            return {"wait": max(asked["t"] + 60, min(start, self._problem.length_s))}
        return {"observe": self._problem.table.visits[choice.row].id, "not_before": choice.start}

    def choose(self, second: int) -> Choice | None:
        """Choose what is worth most by a minute, the time that leads to it counted."""
        return choose_now(self._progress, second)


class ScoredDispatch(DispatchOnly):
    """Dispatch as telescopes have it: veto what cannot begin now, then score times priority.

    The score is the sine of the altitude (0 to 1); how long a visit takes, and what leads to it, is
    no part of it. The design's prototype was compared with one of this kind.
    """

    def choose(self, second: int) -> Choice | None:
        """Choose the visit of the highest score; none where nothing may begin now."""
        progress, table = self._progress, self._problem.table
        rows = progress.released(progress.candidates(second))
        if not rows.size:
            return None
        start, rate, overhead = rank_now(progress, second, rows)
        sky, mark = self._problem.sky, min(second // MARK_S, progress.feasibility.marks - 1)
        directions = sky.star_directions(table.ra[rows], table.dec[rows])
        score = (directions @ sky.zenith[:, mark]) * table.priority[rows]
        score = np.where((rate > 0.0) & (start - second - overhead <= MARK_S), score, -1.0)
        best = int(np.argmax(score))
        if score[best] <= 0.0:
            return None
        end = int(start[best] + table.block_s[rows[best]])
        return Choice(int(rows[best]), int(start[best]), end, int(overhead[best]), 0.0, 0.0)


class Score(NamedTuple):
    """What came of one night."""

    gap: float
    shutter: float
    unfair: float
    p95_ms: float
    slowest_too: int
    refused: int


class NightPlay:
    """Plays one night: only this knows the weather and what is going to arrive."""

    def __init__(self, night: NightFile) -> None:
        """Hold a night with all its requests."""
        self.night = night
        everything = [msgspec.structs.replace(request, arrives=0) for request in night.requests]
        self.problem = make_problem(msgspec.structs.replace(night, requests=everything))
        self.progress = NightProgress(self.problem)
        self.closed = [(begin, end) for begin, end, _ in night.truth.closed]
        self.coming = sorted((r for r in night.requests if r.arrives), key=lambda r: r.arrives)
        self.events: list[dict[str, object]] = []
        self.first: dict[str, int] = {}
        self.seconds: list[float] = []
        self.refused = 0

    def ask(self, planner: Planner, **line: object) -> dict[str, object]:
        """Ask, and count the time."""
        text = msgspec.json.encode(line)
        before = time.process_time()
        answer = planner.answer_line(text)
        if line["type"] == "decide":
            self.seconds.append(time.process_time() - before)
        return answer

    def play(self, planner: Planner) -> None:
        """Play from evening to morning."""
        begin = msgspec.structs.replace(
            self.night, requests=[r for r in self.night.requests if not r.arrives]
        )
        self.ask(planner, type="night", night=begin)
        second, completed = 0, []
        while second < self.night.end_s:
            closing = next((c for c in self.closed if c[1] > second), (1 << 30, 1 << 30))
            if closing[0] <= second:
                second, self.progress.pointing = closing[1], None
                self.events.append({"type": "released", "t": second})
                continue
            self.reveal(second)
            answer = self.ask(
                planner, type="decide", t=second, events=self.events, completed=completed
            )
            self.events, completed = [], []
            if "wait" in answer:
                until = max(second + 1, int(answer["wait"]))
                arrival = self.coming[0].arrives if self.coming else 1 << 30
                second = min(until, closing[0], max(arrival, second + 1), self.night.end_s)
                continue
            second, completed = self.observe(planner, second, answer, closing[0])

    def reveal(self, second: int) -> list[NightRequest]:
        """Let requests arrive."""
        new = [r for r in self.coming if r.arrives <= second]
        self.coming = [r for r in self.coming if r.arrives > second]
        if new:
            self.events.append({"type": "arrived", "t": second, "requests": new})
        return new

    def observe(
        self, planner: Planner, second: int, answer: dict[str, object], closing: int
    ) -> tuple[int, list[str]]:
        """Let a block begin, and end where it is done, stopped or closed upon."""
        name = str(answer["observe"])
        row, table = self.problem.table.index[name], self.problem.table
        lead = int(overheads_from(self.problem, self.progress.pointing, np.array([row]), second)[0])
        start = max(second + lead, int(answer["not_before"]))
        end = start + int(table.block_s[row])
        if row not in self.progress.candidates(second) or not self.progress.feasibility.may_start(
            row, start
        ):
            self.refused += 1
            self.events.append({"type": "refused", "t": second, "request": name})
            return second + 60, []
        stop = min(end, closing)
        while self.coming and self.coming[0].arrives < stop:
            now = self.coming[0].arrives
            for rapid in self.reveal(now):
                line = {"t": now, "events": self.events, "request": rapid.id, "current": name}
                self.events = []
                urgent = rapid.kind == "rapid" and table.urgency[row] != RAPID
                if urgent and self.ask(planner, type="interrupt", **line)["interrupt"]:
                    stop = now
        if start < stop:
            self.first.setdefault(name, start)
            self.progress.pointing = self.progress.pointing_at(row)
        if stop == end:
            self.progress.complete_visit(row)
            return end, [name]
        frame = table.visits[row].runs[0].frame_s
        kept = int(max(0, stop - start) // frame * frame) if self.night.rules.resume else 0
        if kept:
            self.progress.shorten_visit(row, int(table.block_s[row]) - kept)
        left = int(table.block_s[row])
        self.events.append({"type": "aborted", "t": stop, "request": name, "block_s": left})
        return stop, []

    def score(self, bound: float) -> Score:
        """Count what was reached."""
        table, done = self.problem.table, self.progress.complete
        usable = (self.progress.feasibility.run_end >= 0).any(0)
        seconds = np.arange(len(usable)) * 60
        for begin, end in self.closed:
            usable &= ~((seconds >= begin) & (seconds < end))
        got = self.progress.shutter_s / max(self.progress.shutter_s.sum(), 1.0)
        due = np.array([proposal.share for proposal in self.problem.proposals])
        waited = [
            self.first[r.id] - r.arrives
            for r in self.night.requests
            if r.arrives and r.id in self.first
        ]
        return Score(
            gap=100.0 * (1.0 - float(table.value[done].sum()) / bound),
            shutter=float(table.shutter_s[done].sum()) / max(1.0, usable.sum() * 60.0),
            unfair=float(np.abs(got - due).max()),
            p95_ms=float(np.percentile(self.seconds, 95)) * 1000.0,
            slowest_too=max(waited, default=0),
            refused=self.refused,
        )


def clear_night(night: NightFile) -> NightFile:
    """Leave weather and what arrives later out."""
    return msgspec.structs.replace(
        night,
        requests=[request for request in night.requests if not request.arrives],
        truth=msgspec.structs.replace(night.truth, closed=[]),
    )


def main() -> int:
    """Play every night with every planner, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--clear", action="store_true")
    parser.add_argument("--match", default="*.json")
    parser.add_argument("--only", default="", help="of these planners: a part of their names")
    parser.add_argument("--astroplan", action="store_true")
    options = parser.parse_args()
    planners: dict[str, Callable[[], Planner]] = {
        "planner": lambda: DrivenNight(INDIFFERENT),
        "planner, fair": lambda: DrivenNight(EVEN_HANDED),
        "dispatch": DispatchOnly,
        "dispatch, score × priority": ScoredDispatch,
    }
    if options.astroplan and not night_astroplan.is_there():
        parser.error("astroplan is not installed: see bench/night_astroplan.py")
    if options.astroplan:
        planners["astroplan"] = night_astroplan.AstroplanOrder
    planners = {name: make for name, make in planners.items() if options.only in name}
    scores: dict[str, list[Score]] = {name: [] for name in planners}
    kept = 0
    for path in sorted(options.folder.glob(options.match)):
        night = read_night(path.read_bytes()).night
        kept += night.rules.resume
        if options.clear:
            night = clear_night(night)
        whole = NightPlay(night)
        bound = bound_value(whole.problem, whole.closed, whole.progress.feasibility)
        for name, make in planners.items():
            if name == "astroplan" and len(night.requests) > night_astroplan.MOST:
                continue
            play = NightPlay(night)
            play.play(make())
            scores[name].append(play.score(bound))
            print(path.stem, name, *(f"{k} {v:.3g}" for k, v in scores[name][-1]._asdict().items()))
    # The aims are of nights that resume: without it a block that a closing breaks off is lost.
    print(f"frames of broken blocks are kept (rules.resume) in {kept} of these nights")
    for name, rows in scores.items():
        if not rows:
            continue
        mean = np.mean(np.array(rows, float), axis=0)
        words = (f"{k} {v:.3f}" for k, v in zip(Score._fields, mean, strict=True))
        print(f"{name}, mean of {len(rows)}:", *words)
    gaps = {name: np.array([row.gap for row in rows]) for name, rows in scores.items()}
    for name in ("planner", "planner, fair"):
        for other in ("dispatch", "dispatch, score × priority", "astroplan"):
            if not len(gaps.get(name, ())) == len(gaps.get(other, ())) > 0:
                continue
            better = gaps[other] - gaps[name]
            error = better.std(ddof=1) / len(better) ** 0.5 if len(better) > 1 else float("nan")
            print(
                f"{name}: better than {other} by {better.mean():.1f} ± {error:.1f} points, paired"
            )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
