"""Which extensions are found beside talaia, and what becomes of those that are broken."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
import tomllib
from typing import TYPE_CHECKING

import pytest

import talaia.extend.adapter
import talaia.extend.detector
import talaia.extend.importer
import talaia.extend.notifier
from talaia.extend import API_VERSION
from talaia.extensions.declarations import NotifierExtension
from talaia.extensions.installed import installed_extensions

from .broken_packages import DETECTOR, write_package
from .conftest import EXAMPLES, PACKAGES

if TYPE_CHECKING:
    from pathlib import Path


def talaia_says(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "talaia", *words],
        env={**os.environ, "PYTHONPATH": str(folder)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip


def test_every_example_is_found_by_its_entry_point_and_none_is_broken(beside: Path) -> None:
    declared = set()
    for package in PACKAGES:
        points = tomllib.loads((package / "pyproject.toml").read_text())["project"]["entry-points"]
        declared |= {(group, name) for group, names in points.items() for name in names}
    assert declared
    assert {
        (each.group, each.name) for each in installed_extensions().list_extensions()
    } == declared
    assert installed_extensions().list_broken() == []


def test_the_command_lists_them_with_their_keys(target: Path) -> None:
    done = talaia_says(target, "extensions")
    assert done.returncode == 0, done.stderr
    assert "detector cusum: slow drift (CUSUM) (talaia-cusum 1.0)" in done.stdout
    assert (
        "  keys.slack (number, default 0.5): a deviation up to this is none, in standard"
        " deviations.\n"
    ) in done.stdout
    assert "notifier irc" in done.stdout


@pytest.mark.parametrize("package", PACKAGES, ids=lambda each: each.name)
def test_an_example_is_at_most_two_files_and_imports_only_what_is_public(package: Path) -> None:
    files = [each for each in package.iterdir() if each.is_file()]
    assert len([each for each in files if each.name != "pyproject.toml"]) <= 2
    public = {
        f"talaia.extend.{module.__name__.rpartition('.')[2]}": set(module.__all__)
        for module in (
            talaia.extend.adapter, talaia.extend.detector,
            talaia.extend.importer, talaia.extend.notifier,
        )
    } | {"talaia.extend": set(talaia.extend.__all__)}  # fmt: skip
    for path in package.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                assert not [each.name for each in node.names if each.name.startswith("talaia")]
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("talaia"):
                assert node.module in public
                assert {each.name for each in node.names} <= public[node.module]


BROKEN = {
    "an import that raises": ("1 / 0", "it cannot be imported: ZeroDivisionError"),
    "an import that ends the program": ("raise SystemExit(3)", "SystemExit: 3"),
    "no such name": ("other = 1", "it cannot be imported: AttributeError"),
    "something else": ("extension = 5", "names a int, not a DetectorExtension"),
    "another version": (
        DETECTOR.format(see="return 0.0").replace("api=1", "api=99"),
        f"version 99 of talaia.extend, and this Talaia has version {API_VERSION}",
    ),
    "keys that are no shape": (
        DETECTOR.format(see="return 0.0").replace("make=D", "make=D, keys=dict"),
        "is no subclass of ExtensionKeys",
    ),
}


@pytest.mark.parametrize("how", BROKEN)
def test_a_broken_extension_is_named_once_and_takes_no_other_with_it(
    how: str, tmp_path: Path, beside: Path, monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:  # fmt: skip
    code, expected = BROKEN[how]
    write_package(tmp_path, f"broken_{abs(hash(how))}", "talaia.detectors", "broken_one", code)
    monkeypatch.syspath_prepend(str(tmp_path))
    found = installed_extensions()
    assert "cusum" in found.detectors_by_name()
    assert "broken_one" not in found.detectors_by_name()
    (broken,) = found.list_broken()
    assert (broken.group, broken.name) == ("talaia.detectors", "broken_one")
    assert broken.package.startswith("x-broken")
    assert expected in broken.problem
    found.detectors_by_name()
    found.list_extensions()
    said = [each for each in caplog.messages if "broken_one" in each]
    assert len(said) == 1


def test_the_command_names_a_broken_one_and_says_so_by_its_exit_code(
    tmp_path: Path, target: Path
) -> None:
    write_package(tmp_path, "broken_cli", "talaia.notifiers", "broken_cli", "import no_such_thing")
    done = talaia_says(tmp_path, "extensions")
    assert done.returncode == 1
    assert "the extension 'broken_cli' (talaia.notifiers) of x-broken_cli 1.0 is broken: it" in (
        done.stderr
    )
    assert "No module named 'no_such_thing'" in done.stderr
    checked = talaia_says(tmp_path, "check", "examples/agv/site.yaml")
    assert checked.returncode == 0


def test_of_two_with_one_name_the_second_is_broken(
    tmp_path: Path, beside: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = DETECTOR.format(see="return 0.0")
    write_package(tmp_path, "twice", "talaia.detectors", "cusum", code)
    monkeypatch.syspath_prepend(str(tmp_path))
    assert "cusum" in installed_extensions().detectors_by_name()
    (broken,) = installed_extensions().list_broken()
    assert "brings one of the same name" in broken.problem


def test_a_failure_while_it_is_used_is_named_with_its_package(beside: Path) -> None:
    installed_extensions().note_failure(NotifierExtension, "irc", "it fails")
    installed_extensions().note_failure(NotifierExtension, "irc", "it fails")
    assert [str(each) for each in installed_extensions().list_broken()] == [
        "the extension 'irc' (talaia.notifiers) of talaia-irc 1.0 is broken: it fails"
    ]


def test_the_schema_knows_the_keys_of_what_is_installed(target: Path) -> None:
    with_them = json.loads(talaia_says(target, "schema").stdout)
    keys = with_them["$defs"]["Watch.cusum"]["properties"]
    assert keys["slack"]["description"].startswith("a deviation up to this is none")
    assert {"if", "then"} == set(with_them["$defs"]["Watch"]["allOf"][0])


def test_the_examples_folder_holds_nothing_but_packages_and_tiles() -> None:
    packages = [path for path in EXAMPLES.iterdir() if path.is_dir() and path.name != "tiles"]
    assert packages != []
    assert all((path / "pyproject.toml").exists() for path in packages)
    tiles = [path for path in (EXAMPLES / "tiles").iterdir() if path.is_dir()]
    assert tiles != []
    assert all((path / "tile.json").exists() for path in tiles)
