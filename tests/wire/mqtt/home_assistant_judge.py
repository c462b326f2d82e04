"""Judges discovery messages by Home Assistant's own schemas; run by a Python that has it.

Reads lines of JSON, ``[topic, payload]``, and prints a line for each that is refused.
"""

from __future__ import annotations

import importlib
import json
import sys


def judge(topic: str, payload: object) -> str:
    """Give what Home Assistant says against a message; empty: nothing."""
    component = topic.split("/")[1]
    module = importlib.import_module(f"homeassistant.components.mqtt.{component}")
    try:
        module.DISCOVERY_SCHEMA(payload)
    # Whatever it raises is its refusal: its errors have no base of their own.
    except Exception as error:  # noqa: BLE001
        return f"{topic}: {type(error).__name__}: {error}"
    return ""


if __name__ == "__main__":
    for line in sys.stdin:
        if said := judge(*json.loads(line)):
            sys.stdout.write(f"{said}\n")
