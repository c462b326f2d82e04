"""What images install, by version and hash: the part of one lock file that their extras need.

`make lock` writes ``images.lock``, with the versions that the tests run with.
"""

from __future__ import annotations

import re
from importlib.resources import files
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["BUILD", "UV", "LockedPackage", "built_packages", "read_image_lock", "write_lock"]

# Groups beside those of Talaia's extras: what builds a package from its source, and uv.
BUILD, UV = "build", "uv"
# It has no wheel. It is built by what is locked, never by what pip would fetch for it.
_SOURCE_ONLY = {"empy"}
# A line of the groups that need it, then the package with its hashes.
_BLOCK = re.compile(
    r"^# (?P<groups>[a-z0-9 ]+)\n(?P<text>(?P<name>\S+?)==[^\\\n]*(?:\\\n +--hash=\S+ ?)+)$", re.M
)


class LockedPackage(NamedTuple):
    """A package of the lock file.

    Attributes:
        name: as the index has it.
        text: its lines, as pip reads them.
        groups: extras of Talaia's that need it, or `BUILD` or `UV`.

    """

    name: str
    text: str
    groups: frozenset[str]

    @property
    def is_conditional(self) -> bool:
        """Whether it is for some machines only."""
        return ";" in self.text.partition("\n")[0]


def read_image_lock() -> list[LockedPackage]:
    """Read the lock file that comes with Talaia."""
    text = files("talaia.deploy").joinpath("images.lock").read_text("utf-8")
    return [
        LockedPackage(found["name"], found["text"], frozenset(found["groups"].split()))
        for found in _BLOCK.finditer(text)
    ]


def write_lock(groups: Iterable[str]) -> str:
    """Write what `pip install --require-hashes -r` reads, for some extras."""
    wanted = set(groups)
    found = [package for package in read_image_lock() if package.groups & wanted]
    # One extra may need a package on some machines only, and another everywhere.
    everywhere = {package.name for package in found if not package.is_conditional}
    return "".join(
        f"{package.text}\n"
        for package in found
        if not package.is_conditional or package.name not in everywhere
    )


def built_packages(groups: Iterable[str]) -> list[str]:
    """Name what some extras need and no index has a wheel of."""
    wanted = set(groups)
    # Whatever its version: the lock file has one for each Python.
    found = {package.name for package in read_image_lock() if package.groups & wanted}
    return sorted(found & _SOURCE_ONLY)
