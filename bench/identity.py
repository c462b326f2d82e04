"""Are things that a camera sees the same? Trackers against the simulator's truth.

    MUJOCO_GL=egl .venv/bin/python bench/identity.py            ten scenes, about ten minutes
    .venv/bin/python bench/identity.py --kept FOLDER            pictures drawn before are not again

IDF1 by `motmetrics` (requirements/bench.txt): the share of boxes that are given the right person
throughout (Ristani et al. 2016). A person of whom less than a quarter is visible is not asked for.
Rows: the shipped detector on the drawn pictures, and truth with noise (each box missed one time in
eight, moved by 4 % of its size, and one false box on every tenth picture).

Scenes 0 to 9 were used for choosing; 100 to 109 only for judging (``--seeds 100 110``).
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import identity_scenes as scenes
import motmetrics
import numpy as np

from talaia.model.detection import Detect, DetectionSource, Measured, PictureLine
from talaia.objects.detection import Detection
from talaia.objects.floor_lines import LineCounter
from talaia.objects.movements import Movements
from talaia.objects.tracker import Tracker, TrackerRule

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

Box = tuple[float, float, float, float]
# What joins: things, time and colours in, numbers out.
Joins = Any
SAME_BOX = 0.5


class Scene(NamedTuple):
    """Truth and detections of one scene, as they are kept in a file."""

    times: list[int]
    truth: list[dict[str, Box]]
    found: list[list[tuple[float, ...]]]
    colours: list[list[list[float] | None]]


def draw_scene(seed: int, file: str = "") -> Scene:
    """Draw a scene, and show it to the shipped detector, or to another ``file``."""
    import onnxruntime

    from talaia.model.coco_classes import COCO
    from talaia.objects.detector import NANODET, Detector
    from talaia.objects.tracker import colours_of
    from talaia.objects.worker import OWN_FILE

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(file or str(OWN_FILE), options)
    name = session.get_inputs()[0].name
    detector = Detector(NANODET, COCO, lambda shown: session.run(None, {name: shown}))
    times, truth, found, colours = [], [], [], []
    for moment in scenes.play(seed):
        boxes = [
            box for box in detector.detect_objects(moment.picture, 0.3)
            if COCO[box.label] == "person"
        ]  # fmt: skip
        things = [Detection("person", *(float(one) for one in box[1:])) for box in boxes]
        looks = [colours_of(moment.picture, thing) for thing in things]
        times.append(moment.time_us)
        truth.append({str(at): tuple(map(float, box)) for at, box in moment.boxes.items()})
        found.append([thing[1:] for thing in things])
        colours.append([None if look is None else look.tolist() for look in looks])
    return Scene(times, truth, found, colours)


def kept_scene(seed: int, folder: Path, file: str = "") -> Scene:
    """Give a scene, drawn once."""
    path = folder / f"scene{seed}.json"
    if not path.exists():
        path.write_text(json.dumps(draw_scene(seed, file)._asdict()))
        print(f"scene {seed} drawn", file=sys.stderr, flush=True)
    read = json.loads(path.read_text())
    return Scene(*(read[key] for key in Scene._fields))


def noisy(scene: Scene, seed: int) -> Scene:
    """Give what a detector would say that errs in a known way."""
    rng = np.random.default_rng([seed, 7])
    found = []
    for boxes in scene.truth:
        said = []
        for box in boxes.values():
            if rng.random() < 0.125:
                continue
            size = np.array([box[2] - box[0], box[3] - box[1]] * 2)
            said.append((rng.uniform(0.4, 0.9), *(np.array(box) + rng.normal(0, 0.04, 4) * size)))
        if rng.random() < 0.1:
            x, y = rng.uniform(0, 0.9), rng.uniform(0.2, 0.7)
            said.append((rng.uniform(0.3, 0.7), x, y, x + 0.07, y + 0.25))
        found.append(said)
    colours: list[Any] = [[None] * len(said) for said in found]
    return scene._replace(found=found, colours=colours)


# ── what joins ──────────────────────────────────────────────────────────────────────────────────


def by_overlap(kept_s: float) -> Joins:
    """Join each box with the one of before that it overlaps most, if by 0.3; nothing is foretold.

    One that is not seen is kept for so long.
    """
    known: dict[int, tuple[int, Box]] = {}
    given = [0]

    def join(things: Sequence[Detection], at_us: int, _: Sequence[Any]) -> list[int]:
        for number in [one for one, (us, _) in known.items() if at_us - us > kept_s * 1e6]:
            del known[number]
        pairs = sorted(
            ((overlap_of(box, thing[2:]), number, at)
             for number, (_, box) in known.items()
             for at, thing in enumerate(things)),
            reverse=True,
        )  # fmt: skip
        numbers = [0] * len(things)
        for overlap, number, at in pairs:
            if overlap >= 0.3 and not numbers[at] and number not in numbers:
                numbers[at] = number
        for at, thing in enumerate(things):
            if not numbers[at] and thing.score >= 0.5:
                given[0] += 1
                numbers[at] = given[0]
            if numbers[at]:
                known[numbers[at]] = (at_us, thing[2:])
        return numbers

    return join


def own(**rule: float) -> Joins:
    """Talaia's tracker."""
    tracker = Tracker(TrackerRule(**rule))

    def join(things: Sequence[Detection], at_us: int, colours: Sequence[Any]) -> list[int]:
        looks = [None if look is None else np.array(look) for look in colours]
        tracked = tracker.add_picture(things, at_us, looks)
        join.moved = tracked, tracker  # type: ignore[attr-defined]
        return [one.track if one.hits >= 3 else 0 for one in tracked]

    return join


def own_without_colours(**rule: float) -> Joins:
    """The same by place and size alone."""
    seen = own(**rule)

    def join(things: Sequence[Detection], at_us: int, _: Sequence[Any]) -> list[int]:
        numbers = seen(things, at_us, [None] * len(things))
        join.moved = seen.moved  # type: ignore[attr-defined]
        return numbers

    return join


def by_norfair() -> Joins:
    """Norfair, if it is installed, with what its examples use for boxes."""
    from norfair import Detection as Said, Tracker as Norfair

    tracker = Norfair("iou", 0.7, hit_counter_max=80, initialization_delay=2)

    def join(things: Sequence[Detection], _at_us: int, _: Sequence[Any]) -> list[int]:
        said = [
            Said(np.array([[640 * t.left, 480 * t.top], [640 * t.right, 480 * t.bottom]]),
                 scores=np.array([t.score] * 2), data=at)
            for at, t in enumerate(things) if t.score >= 0.4
        ]  # fmt: skip
        numbers = [0] * len(things)
        for track in tracker.update(said):
            if track.last_detection in said and track.id is not None:
                numbers[track.last_detection.data] = track.id
        return numbers

    return join


def by_motpy() -> Joins:
    """motpy, if it is installed."""
    from motpy import Detection as Said, MultiObjectTracker

    tracker = MultiObjectTracker(dt=0.1, tracker_kwargs={"max_staleness": 80})

    def join(things: Sequence[Detection], _at_us: int, _: Sequence[Any]) -> list[int]:
        boxes = np.array([[640 * t.left, 480 * t.top, 640 * t.right, 480 * t.bottom]
                          for t in things]).reshape(-1, 4)  # fmt: skip
        tracker.step([Said(box=box, score=t.score) for box, t in zip(boxes, things, strict=True)
                      if t.score >= 0.4])  # fmt: skip
        return nearest_numbers(
            boxes,
            [(track.box, hash(track.id) % 2**31 + 1)
             for track in tracker.active_tracks(max_staleness_to_positive_ratio=3.0)],
        )  # fmt: skip

    return join


def by_supervision(kind: str) -> Joins:
    """Trackers of `trackers` (ByteTrack, SORT, OC-SORT), which take supervision's detections."""
    import supervision
    import trackers

    tracker = getattr(trackers, kind)(frame_rate=10, lost_track_buffer=90)

    def join(things: Sequence[Detection], _at_us: int, _: Sequence[Any]) -> list[int]:
        boxes = np.array([[640 * t.left, 480 * t.top, 640 * t.right, 480 * t.bottom]
                          for t in things], dtype=float).reshape(-1, 4)  # fmt: skip
        said = supervision.Detections(
            xyxy=boxes, confidence=np.array([t.score for t in things], dtype=float),
            class_id=np.zeros(len(things), int),
        )  # fmt: skip
        done = tracker.update(said)
        ids = [] if done.tracker_id is None else done.tracker_id
        return nearest_numbers(
            boxes, [(box, int(n) + 1) for box, n in zip(done.xyxy, ids, strict=True) if n >= 0]
        )

    return join


def nearest_numbers(boxes: np.ndarray, tracks: Iterable[tuple[Any, int]]) -> list[int]:
    """Give each box the number of the track whose box is it, or overlaps it by half."""
    numbers = [0] * len(boxes)
    taken = [(overlap_of(tuple(box), tuple(has)), number, at)
             for has, number in tracks for at, box in enumerate(boxes)]  # fmt: skip
    for overlap, number, at in sorted(taken, key=lambda one: -one[0]):
        if overlap >= SAME_BOX and not numbers[at] and number not in numbers:
            numbers[at] = number
    return numbers


def overlap_of(one: Sequence[float], other: Sequence[float]) -> float:
    """Give the intersection over the union."""
    wide = min(one[2], other[2]) - max(one[0], other[0])
    high = min(one[3], other[3]) - max(one[1], other[1])
    if wide <= 0 or high <= 0:
        return 0.0
    areas = sum((box[2] - box[0]) * (box[3] - box[1]) for box in (one, other))
    return wide * high / (areas - wide * high)


# ── what judges ─────────────────────────────────────────────────────────────────────────────────


class Judged(NamedTuple):
    """What came of one scene: IDF1, switches of identity, crossings right of all, and ms each."""

    account: Any
    right: int
    wrong: int
    crossings: int
    milliseconds: float


def judge(scene: Scene, join: Joins, seed: int, line_from: float = 3.0) -> Judged:
    """Run one scene."""
    account = motmetrics.MOTAccumulator(auto_id=True)
    begin, end = scenes.LINE
    line = (scenes.project(line_from, begin[1]), scenes.project(*end))
    counter = LineCounter(line)
    movements = Movements(Detect(lines={"line": PictureLine(name="Line", points=line)}))
    crossings = scenes.true_crossings(seed, line_from)
    counts = {1: 0, -1: 0, 0: 0}
    took = 0.0
    for at_us, truth, found, colours in zip(
        scene.times, scene.truth, scene.found, scene.colours, strict=True
    ):
        things = [Detection("person", *box) for box in found]
        before = time.perf_counter()
        numbers = join(things, at_us, colours)
        took += time.perf_counter() - before
        shown = [(n, thing) for n, thing in zip(numbers, things, strict=True) if n]
        apart = np.array([[1 - overlap_of(box, thing[2:]) for _, thing in shown]
                          for box in truth.values()]).reshape(len(truth), len(shown))  # fmt: skip
        apart[apart > SAME_BOX] = np.nan
        account.update([int(at) for at in truth], [n for n, _ in shown], apart)
        if moved := getattr(join, "moved", None):
            tracked, tracker = moved
            movements.add_picture(tracked, at_us, tracker.in_sight_us, tracker.forgotten_us)
            continue
        for number, thing in shown:
            foot = ((thing.left + thing.right) / 2, thing.bottom)
            counts[counter.move_track(number, foot, at_us)] += 1
    for side, measure in ((1, Measured.LEFT), (-1, Measured.RIGHT)):
        source = DetectionSource(stream="", sees="person", line="line", measure=measure)
        counts[side] += round(movements.value_of(source))
    # From near to far, what is left of the line is greater y.
    wanted = {1: 0, -1: 0}
    for _, side in crossings:
        wanted[side] += 1
    right = sum(min(counts[side], wanted[side]) for side in wanted)
    wrong = sum(abs(counts[side] - wanted[side]) for side in wanted)
    return Judged(account, right, wrong, len(crossings), 1000 * took / len(scene.times))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kept", type=Path, help="folder for what is drawn")
    parser.add_argument("--seeds", type=int, nargs=2, default=(0, 10), metavar=("FIRST", "END"))
    parser.add_argument("--libraries", action="store_true", help="others, where installed")
    parser.add_argument("--line-from", type=float, default=3.0, help="where it begins (m)")
    asked = parser.parse_args()
    # NumPy 2 has it no more, and `motmetrics` 1.4 asks for it.
    np.asfarray = lambda some, dtype=float: np.asarray(some, dtype)  # type: ignore[attr-defined]
    with tempfile.TemporaryDirectory() as temporary:
        folder = asked.kept or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        seeds = range(*asked.seeds)
        kept = {seed: kept_scene(seed, folder) for seed in seeds}
    ways: dict[str, Any] = {
        "overlap alone": lambda: by_overlap(0.3),
        "overlap alone, kept 3 s": lambda: by_overlap(3.0),
        "Talaia, place and size": own_without_colours,
        "Talaia": own,
    }
    if asked.libraries:
        ways |= {
            "norfair": by_norfair,
            "motpy": by_motpy,
            "trackers: ByteTrack": lambda: by_supervision("ByteTrackTracker"),
            "trackers: SORT": lambda: by_supervision("SORTTracker"),
            "trackers: OC-SORT": lambda: by_supervision("OCSORTTracker"),
        }
    rows = {"shipped detector": kept}
    rows["truth with noise"] = {seed: noisy(scene, seed) for seed, scene in kept.items()}
    metrics = motmetrics.metrics.create()
    print(
        f"{'':18}{'':26}{'IDF1':>7}{'least':>7}{'switches':>9}{'crossings':>12}{'wrong':>6}{'ms':>7}"
    )
    for what, shown in rows.items():
        for way, make in ways.items():
            try:
                judged = [
                    judge(scene, make(), seed, asked.line_from) for seed, scene in shown.items()
                ]
            except ImportError as error:
                print(f"{what:18}{way:26} {error}")
                continue
            told = metrics.compute_many(
                [one.account for one in judged], metrics=["idf1", "num_switches"],
                names=[str(seed) for seed in shown], generate_overall=True,
            )  # fmt: skip
            each = told["idf1"]
            right, wrong, all_of = (sum(getattr(one, key) for one in judged)
                                    for key in ("right", "wrong", "crossings"))  # fmt: skip
            ms = np.mean([one.milliseconds for one in judged])
            print(f"{what:18}{way:26}{each['OVERALL']:7.3f}{each.iloc[:-1].min():7.2f}"
                  f"{int(told['num_switches']['OVERALL']):9d}{f'{right} of {all_of}':>12}"
                  f"{wrong:6d}{ms:7.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
