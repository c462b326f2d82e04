"""Discovery messages of all example sites, judged by Home Assistant's own schemas.

It wants a Python and versions of its own, some hundred packages, and cannot be a part of these
tests' environment: `make proofs ONLY=home-assistant` makes one for it below ``build/`` and names
its Python in ``TALAIA_HOME_ASSISTANT``.
"""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import pytest

from talaia.model.yaml_text.load import load_site
from talaia.wire.mqtt.home_assistant import DiscoveryWriter
from talaia.wire.mqtt.topic_tree import TopicTree

PYTHON = os.environ.get("TALAIA_HOME_ASSISTANT", "")
EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*/site.yaml"))
JUDGE = Path(__file__).with_name("home_assistant_judge.py")
WRITER = DiscoveryWriter("homeassistant", TopicTree("talaia"), "1.0")

pytestmark = pytest.mark.skipif(
    not PYTHON, reason="Home Assistant is judged by in make proofs ONLY=home-assistant"
)


def messages_of(path: Path) -> list[tuple[str, bytes]]:
    """Write all messages of a site: a sensor for each channel, a button for each command."""
    site = load_site(path.read_text())
    found = [WRITER.describe_sensor(site, channel) for channel in site.channels()]
    for name, device in site.devices.items():
        found += [
            WRITER.describe_button(site, name, command)
            for command, about in device.commands.items()
            if not about.arguments
        ]
        if device.drive is not None:
            found.append(WRITER.describe_stop(site, name))
    return found


def refusals(messages: list[tuple[str, object]]) -> list[str]:
    lines = "".join(json.dumps(message) + "\n" for message in messages)
    judged = subprocess.run(
        [PYTHON, str(JUDGE)], input=lines, capture_output=True, text=True, check=False
    )
    assert judged.returncode == 0, judged.stderr[-2000:]
    return judged.stdout.splitlines()


def test_every_message_of_every_example_is_taken_by_home_assistant() -> None:
    assert len(EXAMPLES) > 1
    written = [message for path in EXAMPLES for message in messages_of(path)]
    assert len(written) > 100
    assert refusals([(topic, json.loads(payload)) for topic, payload in written]) == []
    # For the table of the proof.
    print(f"\n{len(written)} messages of {len(EXAMPLES)} sites: none was refused.")  # noqa: T201


def test_message_that_is_wrong_is_found() -> None:
    topic, payload = messages_of(EXAMPLES[0])[0]
    wrong = {**json.loads(payload), "device_class": "no such class"}
    assert len(refusals([(topic, wrong)])) == 1
