"""What programs send in events: values as they mean them, sensors by name, pictures."""

from __future__ import annotations

import base64

import pytest
import simplejpeg
from hypothesis import given, strategies as st

from talaia.gateway.adapters.cloudconnect import parse_metric
from talaia.gateway.adapters.socketio.event_data import (
    data_of,
    event_key,
    payload_of,
    pixels_of_event,
    place_of,
    sensors_in,
)
from talaia.gateway.errors import FieldError
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site

from ...video.scenes import psnr, scene

pytestmark = pytest.mark.pure

JPEG = simplejpeg.encode_jpeg(scene(), 95)
TEXT = base64.b64encode(JPEG).decode()


@pytest.mark.parametrize(
    "args",
    [
        [{"name": "speed1", "magnitude": 1.4}],
        ["{'name': 'speed1', 'magnitude': 1.4}"],
        ['{"name": "speed1", "magnitude": 1.4}'],
        [[{"name": "speed1", "magnitude": 1.4}]],
        [["{'name': 'speed1', 'magnitude': 1.4}"]],
        [{"data": "{'name': 'speed1', 'magnitude': 1.4}"}],
    ],
)
def test_sensor_is_found_however_it_is_packed(args: list[object]) -> None:
    [(name, payload)] = sensors_in(data_of(args))
    assert name == "speed1"
    assert payload.value == {"name": "speed1", "magnitude": 1.4}


def test_list_of_sensors_is_each_of_them_and_no_more_than_a_thousand() -> None:
    said = [{"name": f"speed{number}", "magnitude": number} for number in range(2000)]
    found = [name for name, _ in sensors_in(data_of([said]))]
    assert found == [f"speed{number}" for number in range(1000)]


@given(st.text(min_size=1, max_size=20).filter(str.strip), st.floats(-1e9, 1e9))
def test_texts_of_the_founding_nodes_mean_what_their_topic_means(name: str, value: float) -> None:
    text = str({"name": name, "magnitude": value})
    metric = parse_metric(text)
    [(found, payload)] = sensors_in(data_of([text]))
    assert (found, payload.value["magnitude"]) == (metric.name, metric.magnitude)


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary(),
        lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    )
)
def test_whatever_comes_is_read_or_left(value: object) -> None:
    payload_of(data_of([value]))
    list(sensors_in(data_of([value])))
    list(sensors_in(data_of([str(value)])))


def test_code_in_a_text_is_not_run_and_long_ones_are_left() -> None:
    assert data_of(["[__import__('os').getcwd()]"]) == "[__import__('os').getcwd()]"
    deep = "[" * 5000 + "]" * 5000
    assert data_of([deep]) == deep


@pytest.mark.parametrize(
    ("said", "path"),
    [
        (JPEG, ""),
        (TEXT, ""),
        (f"data:image/jpeg;base64,{TEXT}", ""),
        (f"b'{TEXT}'", ""),
        ([JPEG], ""),
        ({"camera": {"image": TEXT}}, "camera.image"),
    ],
)
def test_picture_is_read_as_bytes_and_as_base64(said: object, path: str) -> None:
    assert psnr(pixels_of_event(said, path).data, scene()) > 25


def test_picture_that_claims_to_be_huge_is_not_made() -> None:
    start = JPEG.index(b"\xff\xc0") + 5
    bomb = JPEG[:start] + b"\xf0\x00\xf0\x00" + JPEG[start + 4 :]
    with pytest.raises(FieldError, match="61440x61440 pixels are more than"):
        pixels_of_event(bomb, "")


@pytest.mark.parametrize("said", [None, 5, "no picture", b"", b"GIF89a", JPEG[:50], {"image": 1}])
def test_what_is_no_picture_is_told(said: object) -> None:
    with pytest.raises(FieldError):
        pixels_of_event(said, "image" if isinstance(said, dict) else "")


def test_both_spellings_are_one_namespace_and_no_two_keys_are_the_same() -> None:
    assert place_of("/sensedata") == place_of("sensedData") == "sensedData"
    assert place_of("/") == place_of("") == "/"
    assert event_key("a", "b' name='c") != event_key("a", "b", "c")


DESCRIPTION = """
talaia: 1
site: test
name: Test
connections:
  programs: {kind: socketio, port: 8300, token_file: token%s}
devices:
  vehicle:
    name: Vehicle
    signals:
      speed: {name: Speed, source: {%s}}
"""


@pytest.mark.parametrize(
    ("more", "source", "where", "says"),
    [
        (", host: 0.0.0.0", "name: speed1", "host", "could be read on its way"),
        (", host: robot.local", "name: speed1", "host", "is not an address"),
        (", token_env: A", "name: speed1", "token_env", "token_file is given, too"),
        (", certificate: a.pem", "name: speed1", "key", "certificate and key go together"),
        ("", "", "source", "which sensor is it"),
        ("", "namespace: 'a,b'", "namespace", "is not the name of a namespace"),
        ("", "topic: /metric", "topic", "knows no topic"),
    ],
)
def test_description_that_does_not_fit_is_told_where(
    more: str, source: str, where: str, says: str
) -> None:
    findings = check_site(load_site(DESCRIPTION % (more, source)))
    [found] = [finding for finding in findings if finding.where.endswith(f".{where}")]
    assert says in found.problem


def test_vehicle_cannot_be_driven_by_it() -> None:
    drive = (
        DESCRIPTION % ("", "name: speed1")
        + "    drive: {topic: /control, max_speed: 1, max_turn: 1}\n"
    )
    problems = [finding.problem for finding in check_site(load_site(drive))]
    assert "a connection of kind socketio cannot drive" in problems
