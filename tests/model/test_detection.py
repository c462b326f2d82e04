"""Cameras that detect: what a description implies, and what does not fit."""

from __future__ import annotations

import msgspec
import pytest

from talaia.model.checks.site_checks import check_site
from talaia.model.derived_signals import counts_of, with_counts
from talaia.model.site import Visibility
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.model.yaml_text.save import save_into_text

TEXT = """\
talaia: 1
site: yard
name: Yard
ros2: {}
devices:
  base:
    name: Base
    drive:
      topic: /cmd_vel
      max_speed: 1
      max_turn: 1
      max_acceleration: 1
      max_turn_acceleration: 1
    signals:
      speed: {name: Speed, source: {topic: /speed, type: std_msgs/msg/Float64, field: data}}
      in_path:   # within two metres
        name: In the way
        max_age: 1
        source: {stream: front, sees: person, within: [0.3, 0.5, 0.7, 1.0]}
    streams:
      front:
        name: Front camera
        visibility: public
        source: {topic: /front, type: sensor_msgs/msg/Image}
        detect: {classes: [person, traffic light]}
      rear:
        name: Rear camera
        source: {topic: /rear, type: sensor_msgs/msg/Image}
interlocks:
  path:
    name: Person in the way
    when: [{signal: base/in_path, above: 0}]
    refuse: [base/drive]
alarms:
  light: {name: Light, kind: limit, signal: base/front_traffic_light, above: 0}
"""


def found(text: str) -> list[str]:
    return [str(each) for each in check_site(load_site(text))]


def changed(old: str, new: str, text: str = TEXT) -> list[str]:
    assert old in text
    return found(text.replace(old, new))


def test_each_class_of_a_camera_that_detects_has_a_signal_that_counts() -> None:
    assert found(TEXT) == []
    site = with_counts(load_site(TEXT))
    signals = site.devices["base"].signals
    assert list(signals) == ["speed", "in_path", "front_person", "front_traffic_light"]
    light = signals["front_traffic_light"]
    assert (light.name, light.minimum, light.decimals) == ("Traffic light, Front camera", 0, 0)
    assert (light.source.stream, light.source.sees) == ("front", "traffic light")
    assert not light.primary
    assert light.visibility is Visibility.PUBLIC
    assert with_counts(site) is site
    assert check_site(site) == []
    assert counts_of(site).keys() == {
        "base/in_path", "base/front_person", "base/front_traffic_light",
    }  # fmt: skip


def test_what_the_hub_is_told_is_read_there_as_the_same() -> None:
    site = with_counts(load_site(TEXT))
    assert with_counts(load_site(dump_site(site))) == site


def test_persons_text_stays_free_of_what_it_implies() -> None:
    site = load_site(TEXT)
    base = site.devices["base"]
    changed_base = msgspec.structs.replace(base, name="Vehicle")
    after = save_into_text(TEXT, msgspec.structs.replace(site, devices={"base": changed_base}))
    assert after == TEXT.replace("name: Base", "name: Vehicle")


def test_signal_of_the_same_source_takes_the_place_of_the_implied_one() -> None:
    own = "people: {name: People, max_age: 2, source: {stream: front, sees: person}}"
    text = TEXT.replace("    streams:\n", f"      {own}\n    streams:\n")
    assert found(text) == []
    assert "front_person" not in with_counts(load_site(text)).devices["base"].signals


def test_implied_signal_steps_aside_for_one_of_its_name() -> None:
    own = "front_person: {name: X, source: {topic: /x, type: std_msgs/msg/Float64, field: data}}"
    text = TEXT.replace("    streams:\n", f"      {own}\n    streams:\n")
    signals = with_counts(load_site(text)).devices["base"].signals
    assert signals["front_person"].source.topic == "/x"
    assert signals["front_person_2"].source.sees == "person"


def test_service_makes_every_camera_detect_what_is_usual() -> None:
    site = with_counts(load_site(TEXT + "services: {object_detection: true}\n"))
    streams = site.devices["base"].streams
    assert streams["front"].detect == load_site(TEXT).devices["base"].streams["front"].detect
    assert streams["rear"].detect is not None
    assert "rear_dog" in site.devices["base"].signals


def test_site_without_cameras_that_detect_is_left_alone() -> None:
    site = load_site(TEXT.replace("        detect: {classes: [person, traffic light]}\n", ""))
    assert "front_person" not in with_counts(site).devices["base"].signals


@pytest.mark.parametrize(
    ("old", "new", "where", "said"),
    [
        ("[person, traffic", "[persn, traffic", "streams.front.detect.classes[0]", "'person'?"),
        ("[person, traffic", "[person, person, traffic", "detect.classes[1]", "twice"),
        ("traffic light]}", "traffic light], confidence: 1.5}", "detect.confidence", "0 to 1"),
        ("traffic light]}", "traffic light], confidence: .nan}", "detect.confidence", "0 to 1"),
        ("traffic light]}", "traffic light], max_rate: 0}", "detect.max_rate", "more than 0"),
        ("traffic light]}", "traffic light], model: mine}", "detect.model", "object_models"),
        ("0.3, 0.5, 0.7, 1.0", "0.7, 0.5, 0.3, 1.0", "source.within", "left, top, right"),
        ("0.3, 0.5, 0.7, 1.0", "0.3, 0.5, 0.7, 1.1", "source.within", "0 to 1"),
        ("{stream: front, sees", "{sees", "source.stream", "which camera"),
        ("{stream: front, sees: person", "{stream: front", "source.sees", "counted"),
        ("{stream: front, sees", "{stream: frond, sees", "source.stream", "'front'?"),
        ("{stream: front, sees", "{stream: rear, sees", "source.stream", "nothing is detected"),
        ("sees: person,", "sees: persons,", "source.sees", "'person'?"),
        ("sees: person,", "sees: person, topic: /x,", "source.topic", "nowhere else"),
        ("max_age: 1\n", "type: text\n", "in_path.source", "counts nothing"),
        ("traffic light]}", "traffic light], at: hub}", "interlocks.path.when[0].signal", "hub"),
        ("{topic: /rear, ", "{topic: /rear, sees: dog, ", "rear.source.sees", "counts what"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_said_where_it_stands(
    old: str, new: str, where: str, said: str
) -> None:
    problems = changed(old, new)
    assert any(where in each.split(": ")[0] and said in each for each in problems), problems


MODEL = """\
object_models:
  helmets:
    file: models/helmets.onnx
    kind: yolo
    classes: [head, helmet]
"""


def test_detector_of_ones_own_brings_its_own_classes() -> None:
    text = (TEXT + MODEL).replace(
        "detect: {classes: [person, traffic light]}", "detect: {classes: [helmet], model: helmets}"
    )
    text = text.replace("sees: person", "sees: head").replace("front_traffic_light", "front_helmet")
    assert found(text) == []
    assert any("classes[0]" in each for each in found(text.replace("[helmet]", "[person]")))
    assert any(
        "'helmets'?" in each for each in found(text.replace("model: helmets", "model: helmet"))
    )


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ("file: models/helmets.onnx", "file: ''", "helmets.file"),
        ("[head, helmet]", "[]", "helmets.classes"),
        ("[head, helmet]", "[head, head]", "helmets.classes[1]"),
        ("kind: yolo", "kind: yolo\n    side: 417", "helmets.side"),
        ("kind: yolo", "kind: yolo\n    spread: [1, 0, 1]", "helmets.spread[1]"),
        ("  helmets:", "  Helmets:", "object_models.Helmets"),
    ],
)
def test_what_is_wrong_with_a_detector_is_said_where_it_stands(
    old: str, new: str, where: str
) -> None:
    assert any(where in each.split(": ")[0] for each in changed(old, new, TEXT + MODEL))


@pytest.mark.parametrize(
    ("blur", "said"),
    [
        ("{}", ""),
        ("{looks: 5, hold: 0.3}", ""),
        ("{faces: false}", "nothing is to be blurred; write faces: true"),
        ("{plates: ours}", "plates: there is no model 'ours'; describe it in object_models"),
        ("{confidence: 1}", "confidence: expected 0.05 to 0.9, found 1.0"),
        ("{confidence: .nan}", "confidence: expected 0.05 to 0.9, found nan"),
        ("{looks: 5, hold: 0.1}", "forgotten after 0.1 s; write: hold: 0.3, or more"),
        ("{side: 500}", "a multiple of 32, found 500; 480 is usual"),
    ],
)
def test_what_is_to_be_blurred_is_checked(blur: str, said: str) -> None:
    problems = changed("name: Rear camera", f"name: Rear camera\n        blur: {blur}")
    assert len(problems) == bool(said)
    assert said in "".join(problems)
    assert "streams.rear.blur" in "".join(problems) or not said


ZONED = TEXT.replace(
    "traffic light]}",
    "traffic light], "
    "zones: {mat: {name: Mat, points: [[0.1, 0.5], [0.5, 0.5], [0.5, 1]]}}, "
    "lines: {door: {name: Door, points: [[0.1, 0.9], [0.4, 0.6]]}}, "
    "floor: {picture: [[0.3, 0.5], [0.7, 0.5], [1, 1], [0, 1]], "
    "metres: [[0, 4], [2, 4], [2, 0], [0, 0]]}}",
)
COUNTS = "within: [0.3, 0.5, 0.7, 1.0]"


@pytest.mark.parametrize(
    "source",
    [
        "zone: mat",
        "zone: mat, measure: dwell",
        "line: door, measure: left",
        "line: door, measure: right, over: 60",
        "measure: speed",
    ],
)
def test_what_signals_measure_on_a_camera_with_zones_lines_and_floor_fits(source: str) -> None:
    site = load_site(ZONED.replace(COUNTS, source))
    assert check_site(site) == []
    assert "front_person" in with_counts(site).devices["base"].signals


@pytest.mark.parametrize(
    ("old", "new", "where", "said"),
    [
        (COUNTS, "zone: mad", "source.zone", "'mat'?"),
        (COUNTS, "line: dor, measure: left", "source.line", "'door'?"),
        (COUNTS, "line: door", "source.measure", "which side"),
        (COUNTS, "measure: left", "source.line", "which line"),
        (COUNTS, "measure: dwell", "source.zone", "which zone"),
        (COUNTS, f"zone: mat, {COUNTS}", "source.within", "exclude"),
        (COUNTS, "zone: mat, over: 60", "source.over", "crossings"),
        (COUNTS, "line: door, measure: left, over: -1", "source.over", "0 to 86400"),
        ("[[0.1, 0.5], [0.5, 0.5], ", "[[0.5, 0.5], ", "zones.mat.points", "3 to 64"),
        ("[[0.1, 0.9], [0.4", "[[0.1, 1.9], [0.4", "lines.door.points[0]", "0 to 1"),
        ("[0.7, 0.5], [1, 1]", "[0.5, 0.5], [0.7, 0.5]", "floor.picture", "one line"),
        ("[2, 4], [2, 0]", "[1, 4], [2, 4]", "floor.metres", "one line"),
        ("[2, 4], [2, 0]", "[.inf, 4], [2, 4]", "floor.metres[1]", "finite"),
    ],
)
def test_what_does_not_fit_of_zones_and_lines_is_said_where_it_stands(
    old: str, new: str, where: str, said: str
) -> None:
    assert old in ZONED
    found = [str(one) for one in check_site(load_site(ZONED.replace(old, new)))]
    assert any(where in each.split(": ")[0] and said in each for each in found), found


def test_speed_needs_a_floor() -> None:
    found = check_site(load_site(TEXT.replace(COUNTS, "measure: speed")))
    assert any("floor" in str(one) for one in found)
