"""Topics, payloads and discovery messages, as any names and values may make them."""

from __future__ import annotations

import contextlib
import json
import math

import pytest
from hypothesis import given, strategies as st

from talaia.model.yaml_text.load import load_site
from talaia.wire.errors import PeerError
from talaia.wire.mqtt.home_assistant import DiscoveryWriter
from talaia.wire.mqtt.payloads import ValueQuality, encode_value, read_command_payload
from talaia.wire.mqtt.topic_tree import CommandTopic, TopicTree

WORDS = st.from_regex(r"[a-z][a-z0-9_]{0,20}", fullmatch=True)
TREE = TopicTree("my/prefix")


@given(WORDS, WORDS, WORDS)
def test_topic_of_a_command_is_read_back_and_no_value_asks_for_anything(site, device, name) -> None:
    asked = TREE.command_ask(site, device, name)
    assert TREE.read_command(asked) == CommandTopic(site, device, name)
    assert TREE.read_command(TREE.stop_ask(site, device)) == CommandTopic(site, device, "")
    for topic in (
        TREE.channel_value(site, f"{device}/{name}"),
        TREE.channel_value(site, f"{device}/{name}.x"),
        TREE.command_answer(site, device, name),
        TREE.device_state(site, device),
        f"other/{site}/{device}/$do/{name}",
    ):
        assert TREE.read_command(topic) is None


@given(st.text(max_size=60))
def test_any_topic_is_read_without_harm(topic) -> None:
    assert TREE.read_command(topic) is None
    TREE.read_command(f"my/prefix/{topic}")


@given(st.floats() | st.text(), st.integers(-(2**62), 2**62))
def test_any_value_is_json_that_others_read(value, time_us) -> None:
    said = json.loads(encode_value(value, unit="°C", time_us=time_us, quality=ValueQuality.GOOD))
    number = isinstance(value, float) and not math.isfinite(value)
    assert said["value"] == (None if number else value)
    assert said["unit"] == "°C"


@given(st.binary(max_size=300))
def test_any_bytes_are_a_command_or_are_refused(payload) -> None:
    with contextlib.suppress(PeerError):
        assert read_command_payload(payload).time_us >= 0


@pytest.mark.parametrize(
    ("said", "time_us"),
    [
        ('{"time": 1767225600.5}', 1_767_225_600_500_000),
        ('{"time": "2026-01-01T00:00:00.5Z"}', 1_767_225_600_500_000),
        ('{"time": "2026-01-01T01:00:00.5+01:00"}', 1_767_225_600_500_000),
    ],
)
def test_time_of_asking_is_a_number_or_iso_8601(said, time_us) -> None:
    assert read_command_payload(said.encode()).time_us == time_us


SITE = load_site(
    """
talaia: 1
site: obs
name: Observatory
ros2: {}
devices:
  dome:
    name: Dome
    signals:
      heat:
        name: Heat
        unit: °C
        decimals: 1
        source: {topic: /a, type: std_msgs/msg/Float64, field: data}
      shutter:
        name: Shutter
        type: state
        states: [closed, open]
        source: {topic: /b, type: std_msgs/msg/Float64, field: data}
    commands:
      shut: {name: Shut, target: /shut, type: std_srvs/srv/Trigger}
"""
)
WRITER = DiscoveryWriter("homeassistant", TopicTree("t"), "1.0")
STATES = [{"topic": "t/$state"}, {"topic": "t/obs/$state"}, {"topic": "t/obs/dome/$state"}]


def described(at: int):
    topic, payload = WRITER.describe_sensor(SITE, SITE.channels()[at])
    return topic, json.loads(payload)


def test_number_is_a_sensor_with_its_unit_and_class() -> None:
    topic, said = described(0)
    assert topic == "homeassistant/sensor/t_obs_dome/heat/config"
    availability = said.pop("availability")
    assert availability[:3] == STATES
    assert availability[3]["topic"] == said["state_topic"] == "t/obs/dome/heat"
    said.pop("origin")
    assert said == {
        "name": "Heat",
        "state_topic": "t/obs/dome/heat",
        "value_template": "{{ value_json.value }}",
        "state_class": "measurement",
        "unit_of_measurement": "°C",
        "device_class": "temperature",
        "suggested_display_precision": 1,
        "unique_id": "talaia_t_obs_dome_heat",
        "availability_mode": "all",
        "device": {
            "identifiers": ["talaia_t_obs_dome"],
            "name": "Observatory Dome",
            "model": "other",
        },
    }


def test_state_is_a_sensor_with_its_words_and_a_command_is_a_button_that_says_when() -> None:
    _, said = described(1)
    assert (said["device_class"], said["options"]) == ("enum", ["closed", "open"])
    assert "state_class" not in said
    topic, payload = WRITER.describe_button(SITE, "dome", "shut")
    button = json.loads(payload)
    assert topic == "homeassistant/button/t_obs_dome/do_shut/config"
    assert button["command_topic"] == "t/obs/dome/$do/shut"
    assert button["retain"] is False
    # As its templates write it there.
    sent = button["command_template"].replace("{{ now().timestamp() }}", "1767225600.25")
    assert read_command_payload(sent.encode()).time_us == 1_767_225_600_250_000
