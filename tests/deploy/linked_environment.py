"""A clean virtual environment with what some extras need, as hard links: no index is asked.

What is linked are the packages of the environment that the tests run in, and of these only what
Talaia's own wheel asks for; so what it does not ask for is missing, as in a new environment.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from email.parser import Parser
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

__all__ = ["make_linked_environment", "needed_packages"]

_PROGRAMS = "../../../bin/"


def make_linked_environment(place: Path, wheel: Path, wanted: str, *more: str) -> None:
    """Make an environment at ``place`` with what ``wanted`` of ``wheel`` needs, but not itself.

    Args:
        place: folder that is made.
        wheel: Talaia's own.
        wanted: as `pip install` is told it, ``talaia[hub]==1.2.3``.
        more: names of packages beside what it needs.

    """
    subprocess.run(
        [sys.executable, "-m", "venv", "--without-pip", str(place)], check=True, timeout=60
    )
    packages = place / f"lib/python{sys.version_info.major}.{sys.version_info.minor}/site-packages"
    with zipfile.ZipFile(wheel) as packed:
        (name,) = (each for each in packed.namelist() if each.endswith(".dist-info/METADATA"))
        words = Parser().parsestr(packed.read(name).decode()).get_all("Requires-Dist", [])
    for found in [*needed_packages(words, wanted), *map(distribution, more)]:
        _link(found, packages)


def needed_packages(
    words: list[str], wanted: str, machine: dict[str, str] | None = None
) -> list[Distribution]:
    """Give what is needed, followed through the packages' own words.

    Args:
        words: what Talaia itself asks for, as its wheel says it.
        wanted: see `make_linked_environment`.
        machine: markers of another machine (``platform_machine``); those of this one for the rest.

    """
    asked = Requirement(wanted)
    itself = canonicalize_name(asked.name)
    found: dict[str, Distribution] = {}
    seen: set[tuple[str, frozenset[str]]] = set()

    def follow(requires: list[str], extras: set[str]) -> None:
        for requirement in map(Requirement, requires):
            marker = requirement.marker
            if marker and not any(
                marker.evaluate({**(machine or {}), "extra": extra}) for extra in extras | {""}
            ):
                continue
            key = canonicalize_name(requirement.name)
            if (key, frozenset(requirement.extras)) in seen:
                continue
            seen.add((key, frozenset(requirement.extras)))
            if key == itself:
                follow(words, requirement.extras)
                continue
            try:
                found[key] = distribution(key)
            except PackageNotFoundError:
                # What is missing is told by pip, which is asked next.
                continue
            follow(found[key].requires or [], requirement.extras)

    follow([str(asked)], set())
    return list(found.values())


def _link(found: Distribution, packages: Path) -> None:
    """Link a package's files, also what was compiled of them; its programs name another Python."""
    for file in found.files or []:
        source, target = Path(str(found.locate_file(file))), packages / file
        if str(file).startswith(_PROGRAMS) or not source.is_file() or target.exists():
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            os.link(source, target)
        except OSError:
            # On another disk.
            shutil.copy2(source, target)
