"""A source is one of its connection's kind, also where it says nothing."""

from __future__ import annotations

from pathlib import Path

from msgspec.structs import replace

from talaia.model.checks.site_checks import check_site
from talaia.model.connection import VideoSource
from talaia.model.yaml_text.load import read_site

EXAMPLE = Path(__file__).parents[3] / "examples/agv/site.yaml"


def test_an_empty_source_of_another_kind_is_refused_for_written_it_would_be_nothing() -> None:
    site = read_site(EXAMPLE)
    base = site.devices["base"]
    speed = replace(base.signals["speed"], source=VideoSource())
    base = replace(base, signals={**base.signals, "speed": speed})
    (finding,) = check_site(replace(site, devices={**site.devices, "base": base}))
    assert finding.where == "$.devices.base.signals.speed.source"
    assert finding.problem == "a connection of kind ros2 knows no such source"
    assert finding.remedy.startswith("write as: ")
