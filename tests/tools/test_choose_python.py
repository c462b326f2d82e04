"""Which Python a tree's virtual environment is made with."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from choose_python import choose_python, measure_python  # noqa: E402


def _program(folder: Path, name: str, prints: str, code: int = 0) -> Path:
    """Make what answers a trial as a Python would that takes so long."""
    path = folder / name
    path.write_text(f"#!/bin/sh\necho '{prints}'\nexit {code}\n")
    path.chmod(0o755)
    return path


def test_the_systems_python_is_chosen_where_it_is_much_quicker(tmp_path):
    named, system = _program(tmp_path, "named", "0.02"), _program(tmp_path, "system", "0.014")
    assert choose_python(str(named), system) == str(system)


@pytest.mark.parametrize("seconds", ["0.019", "0.02", "0.03"])
def test_the_named_python_stays_where_the_systems_is_hardly_quicker_or_slower(tmp_path, seconds):
    named, system = _program(tmp_path, "named", "0.02"), _program(tmp_path, "system", seconds)
    assert choose_python(str(named), system) == str(named)


def test_a_system_whose_python_is_too_old_or_makes_no_environment_leaves_the_named(tmp_path):
    named = _program(tmp_path, "named", "0.02")
    assert choose_python(str(named), _program(tmp_path, "system", "", code=1)) == str(named)
    assert choose_python(str(named), tmp_path / "none") == str(named)


def test_a_real_python_says_how_long_the_trial_took_it():
    taken = measure_python(sys.executable)
    assert taken is not None
    assert 0.0 < taken < 10.0
