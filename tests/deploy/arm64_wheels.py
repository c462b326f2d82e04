"""What a gateway on arm64 needs, as it is locked; and, as a program, the wheels of it at the index.

python -m deploy.arm64_wheels --table docs/arm64-table.md        (make proofs ONLY=arm64)
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

from deploy.linked_environment import needed_packages
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

__all__ = ["PYTHONS", "locked_pins"]

ROOT = Path(__file__).parents[2]
EXTRAS = "gateway,recording,camera,objects"
PYTHONS = ("3.11", "3.12", "3.13")
# Debian 12 and Ubuntu 22.04 have a younger C library than these ask for.
PLATFORMS = ("manylinux_2_28_aarch64", "manylinux_2_17_aarch64", "manylinux2014_aarch64")


def locked_pins(python: str) -> list[str]:
    """Give the locked versions of what a gateway on arm64 needs with a Python."""
    machine = {
        "platform_machine": "aarch64",
        "python_version": python,
        "python_full_version": f"{python}.0",
    }
    found = needed_packages(_own_words(), f"talaia[{EXTRAS}]", machine)
    names = {canonicalize_name(each.name) for each in found}
    lock = (ROOT / "requirements/dev.txt").read_text()
    pinned = [Requirement(row) for row in re.findall(r"^(\w[^\\\n]*)", lock, re.MULTILINE)]
    return sorted(
        f"{each.name}{each.specifier}"
        for each in pinned
        if canonicalize_name(each.name) in names
        and (each.marker is None or each.marker.evaluate(machine))
    )


def _own_words() -> list[str]:
    """What Talaia asks for, extras as markers, as its wheel would say it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    words = list(project["dependencies"])
    for extra, wanted in project["optional-dependencies"].items():
        for each in wanted:
            name, _, marker = each.partition(";")
            also = f"({marker}) and " if marker else ""
            words.append(f"{name} ; {also}extra == '{extra}'")
    return words


def wheels_for(python: str, folder: Path) -> dict[str, str]:
    """Ask pip for the wheels, and give their names by package; nothing is installed."""
    report, pins = folder / f"{python}.json", locked_pins(python)
    subprocess.run(
        [
            sys.executable, "-m", "pip", "install", "--dry-run", "--ignore-installed", "--quiet",
            "--no-deps", "--only-binary", ":all:", "--target", str(folder / "to"),
            # pip compares that with its own Python; the lock's markers have chosen already.
            "--ignore-requires-python", "--python-version", python, "--report", str(report),
            *(word for platform in PLATFORMS for word in ("--platform", platform)),
            *pins,
        ],
        check=True,
    )  # fmt: skip
    came = json.loads(report.read_text())["install"]
    assert len(came) == len(pins)
    return {
        each["metadata"]["name"]: each["download_info"]["url"].rsplit("/", 1)[-1] for each in came
    }


def main() -> None:
    table = Path(sys.argv[sys.argv.index("--table") + 1])
    with tempfile.TemporaryDirectory() as folder:
        found = {python: wheels_for(python, Path(folder)) for python in PYTHONS}
    names = sorted({name for files in found.values() for name in files}, key=str.lower)
    rows = [
        f"| {name} | {' | '.join(found[python].get(name, '—') for python in PYTHONS)} |"
        for name in names
    ]
    table.write_text(
        "# Wheels of a gateway on arm64\n\n"
        f"Made by `make proofs ONLY=arm64`: for each locked package of `talaia[{EXTRAS}]` the "
        f"wheel that pip chooses at the index for {', '.join(PLATFORMS)}. None of them was run.\n\n"
        f"| package | {' | '.join(f'Python {python}' for python in PYTHONS)} |\n|---|---|---|---|\n"
        + "\n".join(rows)
        + "\n"
    )


if __name__ == "__main__":
    main()
