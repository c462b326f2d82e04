"""A site with a roof that nothing closes by itself says so."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from talaia.cli.checking.command_line import main
from talaia.cli.describing.describe_robot import _print_summary as tell_made
from talaia.cli.local_site.run_site import _print_greeting as greet_up, _Up
from talaia.model.discovery.command_file import site_of
from talaia.model.discovery.generate_description import DescriptionProposal
from talaia.model.interlocks.unguarded import unguarded_devices, unguarded_notice
from talaia.model.yaml_text.load import dump_site, read_site

ROOT = Path(__file__).parents[3]
CLASSIC = (ROOT / "tests" / "wire" / "recorded" / "observatory_commands.json").read_text()


def test_a_site_from_the_founding_command_file_says_that_nothing_closes_its_roof(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = unguarded_notice(site_of(CLASSIC, "observatory"))
    assert said.startswith("Dome and Telescope do not close or park by themselves")
    assert "the description has no interlocks and no enclosure" in said
    file = tmp_path / "site.yaml"
    file.write_text(dump_site(site_of(CLASSIC, "observatory")))
    assert main([str(file)]) == 0
    assert f"note: {said}" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["agv", "observatory", "clamshell", "indi"])
def test_examples_have_nothing_to_say(name: str) -> None:
    assert unguarded_notice(read_site(ROOT / "examples" / name / "site.yaml")) == ""


def test_interlocks_without_an_enclosure_close_no_roof() -> None:
    site = replace(read_site(ROOT / "examples" / "observatory" / "site.yaml"), enclosures={})
    assert "interlocks close no roof" in unguarded_notice(site)


def test_an_enclosure_of_one_dome_does_not_silence_the_notice_of_another() -> None:
    site = read_site(ROOT / "examples" / "observatory" / "site.yaml")
    assert unguarded_devices(site) == ()
    other = replace(site.devices["dome"], name="Second dome")
    both = replace(site, devices={**site.devices, "dome2": other})
    assert unguarded_devices(both) == ("dome2",)
    said = unguarded_notice(both)
    assert said.startswith("Second dome does not close or park by itself: no enclosure")


def test_a_description_that_was_made_says_what_nothing_closes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    site = site_of(CLASSIC, "observatory")
    tell_made(tmp_path / "site.yaml", DescriptionProposal(site, ()), shown=False)
    assert f"note: {unguarded_notice(site)}" in capsys.readouterr().err
    greet_up(_Up("http://here", ""), site, tmp_path, 1.0)
    assert f"note: {unguarded_notice(site)}" in capsys.readouterr().out
