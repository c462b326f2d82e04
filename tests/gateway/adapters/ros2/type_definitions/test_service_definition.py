"""Hashes of services, judged by those that ROS's own generator installed."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import pytest

from talaia.gateway.adapters.ros2.type_definitions.definition_finder import DefinitionFinder

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("rclpy") is None, reason="needs ROS 2's packages"
)


def test_every_installed_service_has_ros_own_hash() -> None:
    finder, seen = DefinitionFinder(None), 0
    for path in sorted(Path(sys.prefix, "share").glob("*/srv/*.json")):
        told = json.loads(path.read_bytes())
        name = told["type_description_msg"]["type_description"]["type_name"]
        hashes = {each["type_name"]: each["hash_string"] for each in told["type_hashes"]}
        _, found = finder.find_service(name, "a test")
        assert found == hashes[name], name
        seen += 1
    assert seen > 20
