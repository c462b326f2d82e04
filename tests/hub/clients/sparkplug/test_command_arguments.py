"""Arguments of a command that a host writes as JSON: read, and never more than arguments."""

from __future__ import annotations

import pytest

from talaia.hub.clients.sparkplug.device_metrics import ControlMetric
from talaia.hub.clients.sparkplug.site_metrics import command_payload
from talaia.wire.errors import PeerError
from talaia.wire.mqtt.payloads import read_command_payload
from talaia.wire.sparkplug.payloads import ReadMetric, SparkplugType

CONTROL = ControlMetric("slew", SparkplugType.STRING)


def written(text: str, time_ms: int | None = 1_767_225_600_500) -> bytes:
    return command_payload(CONTROL, ReadMetric("Device Control/slew", None, time_ms, text))


def test_arguments_and_the_time_of_asking_are_read() -> None:
    asked = read_command_payload(written('{"angle": 90}'))
    assert (asked.args, asked.time_us) == ({"angle": 90}, 1_767_225_600_500_000)


@pytest.mark.parametrize("text", ['{"angle": 90}, "time": 1e9', "{", "[1]", "9", "[" * 5000])
def test_what_is_no_set_of_arguments_is_refused(text: str) -> None:
    with pytest.raises(PeerError):
        read_command_payload(written(text))


def test_command_without_a_time_is_refused() -> None:
    with pytest.raises(PeerError, match="time"):
        read_command_payload(written("{}", None))
