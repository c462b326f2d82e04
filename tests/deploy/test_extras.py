"""What an installation does not carry, by what the package asks for: nothing is installed here."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from deploy.linked_environment import needed_packages
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from talaia.deploy.locks import read_image_lock

pytestmark = pytest.mark.pure
ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
# Each larger than all of Talaia's own modules: PyAV, astropy, MuJoCo, ONNX Runtime, pandas,
# pyarrow, PySide and SciPy.
LARGE = {
    "av", "astropy", "mujoco", "onnxruntime", "pandas", "pyarrow", "pyside6-essentials", "scipy",
}  # fmt: skip
# Which extra brings what of it.
BROUGHT = {
    "arrow": {"pyarrow"},
    "camera": {"av"},
    "chats": set(),
    "client": {"pyarrow"},
    "cluster": set(),
    "configurator": {"pyside6-essentials"},
    "fast": set(),
    "gateway": set(),
    "hub": set(),
    "indi": set(),
    "mariadb": set(),
    "objects": {"onnxruntime"},
    "observatory": {"astropy", "scipy"},
    "planner": {"scipy"},
    "postgresql": set(),
    "recording": set(),
    "ros2": set(),
    "s3": set(),
    "sim": {"mujoco"},
}


def own_words() -> list[str]:
    """Give what Talaia asks for, as its wheel's metadata say it."""
    words = list(PROJECT["dependencies"])
    for extra, asked in PROJECT["optional-dependencies"].items():
        for each in asked:
            name, _, marker = each.partition(";")
            condition = f'extra == "{extra}"' + (f" and ({marker.strip()})" if marker else "")
            words.append(f"{name.strip()} ; {condition}")
    return words


@pytest.mark.parametrize("extra", sorted(set(PROJECT["optional-dependencies"]) - {"dev"}))
def test_an_extra_brings_none_of_the_large_packages_but_its_own(extra: str) -> None:
    found = needed_packages(own_words(), f"talaia[{extra}]")
    assert {canonicalize_name(each.name) for each in found} & LARGE == BROUGHT[extra]


@pytest.mark.parametrize(
    "extra", ["hub", "arrow", "chats", "fast", "gateway", "objects", "mariadb", "postgresql", "s3"]
)
def test_images_have_whatever_an_extra_asks_for(extra: str) -> None:
    locked = {canonicalize_name(each.name) for each in read_image_lock() if extra in each.groups}
    asked = [Requirement(word) for word in own_words()]
    wanted = {
        canonicalize_name(each.name)
        for each in asked
        if not each.name.startswith("talaia")
        and (each.marker is None or each.marker.evaluate({"extra": extra}))
    }
    assert wanted <= locked
