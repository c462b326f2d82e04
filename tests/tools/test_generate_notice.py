"""NOTICE names what the pages carry, and refuses a package that does not say its licence."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from generate_notice import LicenceMissing, bundled_packages, licence_of  # noqa: E402

pytestmark = pytest.mark.pure


def test_what_only_developers_install_is_not_carried() -> None:
    lock = {
        "packages": {
            "": {"name": "web"},
            "node_modules/vite": {"dev": True},
            "node_modules/fsevents": {"optional": True},
            "node_modules/@types/three": {},
            "node_modules/uplot/node_modules/lit": {},
        }
    }
    assert list(bundled_packages(lock)) == ["node_modules/uplot/node_modules/lit"]


def test_a_package_without_a_licence_text_is_refused_unless_it_has_ours(tmp_path: Path) -> None:
    with pytest.raises(LicenceMissing, match="'MIT'"):
        licence_of(tmp_path, "MIT")
    assert "LICENSE" in licence_of(tmp_path, "Apache-2.0")
    (tmp_path / "LICENSE").write_text("Do as you like\r\n")
    assert licence_of(tmp_path, "MIT") == "Do as you like"


def test_every_package_that_the_pages_ask_for_is_named() -> None:
    notice = (ROOT / "NOTICE").read_text()
    asked = json.loads((ROOT / "web/package.json").read_text())["dependencies"]
    assert [name for name in asked if f"\n{name} " not in notice] == []
