"""The example extensions as a user gets them: built and installed, into a folder of their own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from talaia.extensions.installed import installed_extensions

if TYPE_CHECKING:
    from collections.abc import Iterator

EXAMPLES = Path(__file__).parents[2] / "examples" / "extensions"
PACKAGES = sorted(each.parent for each in EXAMPLES.glob("*/pyproject.toml"))


@pytest.fixture(scope="session")
def target(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install every example package with pip, without a network."""
    folder = tmp_path_factory.mktemp("installed")
    subprocess.run(
        [
            sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index",
            "--no-build-isolation", "--disable-pip-version-check", "--target", str(folder),
            *map(str, PACKAGES),
        ],
        check=True,
    )  # fmt: skip
    return folder


@pytest.fixture
def beside(target: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Have the example packages beside talaia, here and in processes that are started here."""
    monkeypatch.syspath_prepend(str(target))
    before = os.environ.get("PYTHONPATH")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(target), *([before] if before else [])]))
    installed_extensions.cache_clear()
    yield target
    installed_extensions.cache_clear()
