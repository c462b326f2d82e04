"""Models that tell no boxes: what a description says of them, and what does not fit."""

from __future__ import annotations

import pytest

from talaia.model.checks.site_checks import check_site
from talaia.model.derived_signals import camera_meaning, counts_of, with_counts
from talaia.model.picture_models.model_signals import model_cameras
from talaia.model.yaml_text.load import dump_site, load_site

TEXT = """\
talaia: 1
site: house
name: House
ros2: {}
object_models:
  ground: {file: g.onnx, kind: segmentation, classes: [other, floor], side: 512}
  room: {file: r.onnx, kind: classification, classes: [hall, bath], side: 224}
  pose: {file: p.onnx, kind: keypoints, classes: [person]}
  hand: {file: h.onnx, kind: keypoints, classes: [hand], points: [tip, wrist], bones: [[tip, wrist]]}
  far: {file: f.onnx, kind: depth, scale: metres, side: 518}
  near: {file: n.onnx, kind: depth, side: 518}
  boxes: {file: b.onnx, kind: yolo, classes: [floor]}
devices:
  base:
    name: Base
    signals:
      free: {name: Free, unit: "%", source: {stream: front, model: ground, sees: floor, measure: share, zone: path}}
      ahead: {name: Ahead, source: {stream: front, model: ground, sees: floor, measure: ahead, within: [0, 0.5, 1, 1]}}
      hall: {name: Hall, unit: "%", source: {stream: front, model: room, sees: hall, measure: probability}}
      room: {name: Room, type: text, source: {stream: front, model: room, measure: surest}}
      state: {name: Room, type: state, states: [hall, bath], source: {stream: front, model: room, measure: surest}}
      people: {name: People, source: {stream: front, model: pose, sees: person}}
      wrists: {name: Hands up, source: {stream: front, model: pose, sees: left wrist, within: [0, 0, 1, 0.5]}}
      tips: {name: Tips, source: {stream: front, model: hand, sees: tip}}
      metres: {name: Nearest, unit: m, source: {stream: front, model: far, measure: nearest}}
      nearness: {name: Near, unit: "%", source: {stream: front, model: near, measure: nearest}}
    streams:
      front:
        name: Front camera
        source: {topic: /front, type: sensor_msgs/msg/Image}
        models:
          ground: {max_rate: 4, zones: {path: {name: Path, points: [[0.3, 0.6], [0.7, 0.6], [1, 1]]}}}
          room: {}
          pose: {confidence: 0.6}
          hand: {}
          far: {}
          near: {}
      rear:
        name: Rear camera
        source: {topic: /rear, type: sensor_msgs/msg/Image}
        detect: {model: boxes, classes: [floor]}
"""  # noqa: E501 - a row for each


def found(old: str = "", new: str = "") -> list[str]:
    assert old in TEXT
    return [str(finding) for finding in check_site(load_site(TEXT.replace(old, new, 1)))]


def test_models_of_all_kinds_stand_beside_each_other_and_beside_a_detector() -> None:
    assert found() == []
    site = with_counts(load_site(TEXT))
    assert load_site(dump_site(site)) == site
    assert {camera.name: list(camera.signals) for camera in model_cameras(site)} == {
        "ground": ["base/free", "base/ahead"],
        "room": ["base/hall", "base/room", "base/state"],
        "pose": ["base/people", "base/wrists"],
        "hand": ["base/tips"],
        "far": ["base/metres"],
        "near": ["base/nearness"],
    }
    # No detector counts them.
    assert set(counts_of(site)) == {"base/rear_floor"}


def test_another_model_or_another_place_is_another_meaning_for_safety() -> None:
    before = camera_meaning(load_site(TEXT), "base", "front")
    for old, new in (("side: 512", "side: 256"), ("[0.3, 0.6]", "[0.4, 0.6]")):
        assert camera_meaning(load_site(TEXT.replace(old, new)), "base", "front") != before
    same = TEXT.replace("name: Front camera", "name: In front")
    assert camera_meaning(load_site(same), "base", "front") == before


@pytest.mark.parametrize(
    ("old", "new", "where", "said"),
    [
        ("classes: [other, floor]", "classes: [floor]", "object_models.ground.classes", "2 to 250"),
        ("classes: [hall, bath]", "classes: []", "object_models.room.classes", "1 to 1000"),
        ("classes: [person]", "classes: [a, b]", "object_models.pose.classes", "the one class"),
        ("kind: depth, side", "kind: depth, classes: [a], side", "near.classes", "has no classes"),
        ("kind: yolo,", "kind: yolo, points: [a],", "boxes.points", "only keypoints have points"),
        ("kind: yolo,", "kind: yolo, scale: metres,", "boxes.scale", "only depth has a scale"),
        ("kind: yolo,", "kind: yolo, side: 100,", "boxes.side", "a multiple of 32"),
        ("points: [tip, wrist], ", "", "hand.bones", "of points that are named"),
        ("[tip, wrist],", "[tip, tip],", "hand.points[1]", "there twice"),
        ("[[tip, wrist]]", "[[tip, wrst]]", "hand.bones[0]", "did you mean 'wrist'"),
        ("room: {}", "rooms: {}", "front.models.rooms", "did you mean 'room'"),
        ("room: {}", "boxes: {}", "front.models.boxes", "detect: {model: boxes}"),
        ("confidence: 0.6", "confidence: .nan", "models.pose.confidence", "expected 0 to 1"),
        ("max_rate: 4", "max_rate: 0", "models.ground.max_rate", "more than 0 to 60 Hz"),
        ("confidence: 0.6", "hold: -1", "models.pose.hold", "expected 0 to 60 s"),
        ("[[0.3, 0.6],", "[[1.3, 0.6],", "zones.path.points[0]", "0 to 1"),
        ("model: boxes", "model: ground", "rear.detect.model", "tells no boxes"),
        ("model: room, sees", "model: rooms, sees", "hall.source.model", "did you mean 'room'"),
        ("stream: front, model: near", "stream: rear, model: near", "model", "models: {near: {}}"),
        ("measure: ahead", "measure: nearest", "ahead.source.measure", "share, ahead, left_edge"),
        ("sees: floor, measure: share", "measure: share", "free.source.sees", "sees: other"),
        ("sees: floor, measure: share", "sees: flor, measure: share", "sees", "mean 'floor'"),
        ("sees: left wrist", "sees: left rist", "wrists.source.sees", "mean 'left wrist'"),
        ("measure: surest", "sees: hall, measure: surest", "room.source.sees", "not of one class"),
        ("zone: path", "zone: pth", "free.source.zone", "did you mean 'path'"),
        ("zone: path", "zone: path, within: [0, 0, 1, 1]", "free.source.within", "exclude each"),
        ("within: [0, 0.5, 1, 1]", "zone: path", "", ""),
        ("measure: probability", "measure: probability, zone: a", "hall.source.zone", "whole"),
        ("sees: person}", "sees: person, line: a}", "people.source.line", "only what is tracked"),
        ("sees: person}", "sees: person, over: 3}", "people.source.over", "only what is tracked"),
        ("unit: m,", "unit: cm,", "metres.unit", "told in m, found cm"),
        ("type: text", "type: number", "room.type", "is a text or a state"),
        ("states: [hall, bath]", "states: [bath, hall]", "state.states", "[hall, bath]"),
        ("name: Free, unit: \"%\"", "name: Free, type: text", "free.type", "is a number"),
        ("name: Free,", "name: Free, max_age: 0.1,", "free.source", "old after 0.1 s"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_told_with_its_place_and_what_to_do(old, new, where, said) -> None:
    problems = found(old, new)
    if not said:
        assert problems == []
        return
    assert any(where in problem and said in problem for problem in problems), problems


def test_plates_are_found_by_a_detector_and_a_detectors_signal_tells_no_share() -> None:
    text = TEXT.replace(
        "detect: {model: boxes", "blur: {plates: ground}\n        detect: {model: boxes"
    )
    assert any("rear.blur.plates" in str(one) for one in check_site(load_site(text)))
    text = TEXT.replace("model: ground, sees: floor, measure: ahead", "sees: floor, measure: ahead")
    text = text.replace("stream: front, sees: floor", "stream: rear, sees: floor")
    (problem,) = [str(one) for one in check_site(load_site(text))]
    assert "a detector tells no ahead; one of: count, dwell" in problem
