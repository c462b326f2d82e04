"""Build hook: what is made travels in the wheel and in the sdist, so that users need no Node.

The pages are built when their sources are here and the built ones are missing or older; the
detectors' files are made when they are missing. An editable install makes nothing: a developer
has `make setup`, `make pages` and the development server.
"""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import ModuleType

SOURCES = ("src", "public", "index.html", "package.json", "package-lock.json", "vite.config.ts")
MODELS = "src/talaia/objects/models"
# What sees objects and what finds faces, each by the script that makes it.
DETECTORS = {"nanodet.onnx": "make_detector.py", "centerface.onnx": "make_face_detector.py"}


class PagesMissing(Exception):
    """Neither built pages nor their sources are here."""

    def __str__(self) -> str:
        """Say where they come from."""
        return (
            "src/talaia/web/static has no pages and there is no web/ to build them from; "
            "build from a checkout, or from a published source archive"
        )


class PagesNotBuilt(Exception):
    """npm failed."""

    def __init__(self, arguments: tuple[str, ...], said: str) -> None:
        """Keep what was run and what it said."""
        self.arguments = arguments
        self.said = said
        super().__init__(arguments, said)

    def __str__(self) -> str:
        """Show npm's own words."""
        return f"`npm {' '.join(self.arguments)}` failed in web/:\n{self.said}"


class DetectorNotMade(Exception):
    """A detector's file is not here and could not be made."""

    def __init__(self, name: str, said: str) -> None:
        """Keep which, and what was said."""
        self.name = name
        self.said = said
        super().__init__(name, said)

    def __str__(self) -> str:
        """Show the script's own words."""
        made_by = f"tools/{DETECTORS[self.name]}"
        return f"{MODELS}/{self.name} is missing, and {made_by} could not make it:\n{self.said}"


class MadeHook(BuildHookInterface):  # type: ignore[type-arg]
    """See the module."""

    PLUGIN_NAME = "talaia-made"

    def dependencies(self) -> list[str]:
        """Ask the front end for what makes what is missing: NumPy, pip, Node if there is none."""
        node = self._node()
        missing = self._missing_detectors()
        detector = "nanodet.onnx" in missing
        needs_npm = detector or (not self._fresh() and self._web.is_dir())
        wanted = ["numpy>=2.0"] if missing else []
        if "centerface.onnx" in missing:
            wanted.append("pip>=24")
        if needs_npm and node.machine_npm() is None:
            wanted.append(str(node.PACKAGE))
        return wanted

    def initialize(self, version: str, _build_data: dict[str, Any]) -> None:
        """Make what is missing, or nothing where that is not wanted.

        Raises:
            PagesMissing: nothing to build the pages from.
            PagesNotBuilt: npm failed.
            DetectorNotMade: a detector's file could not be made.

        """
        if version == "editable":
            return
        for name in self._missing_detectors():
            self._make_detector(name)
        if self._fresh():
            return
        if not self._web.is_dir():
            raise PagesMissing
        npm = self._node().find_npm()
        # What a developer has installed is left as it is.
        if not (self._web / "node_modules" / "vite").is_dir():
            self._run(npm, "ci", "--no-audit", "--no-fund")
        self._run(npm, "run", "build")

    @property
    def _web(self) -> Path:
        return Path(self.root) / "web"

    def _missing_detectors(self) -> list[str]:
        return [name for name in DETECTORS if not (Path(self.root) / MODELS / name).is_file()]

    def _make_detector(self, name: str) -> None:
        done = subprocess.run(
            [sys.executable, str(Path(self.root) / "tools" / DETECTORS[name])],
            check=False, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        if done.returncode:
            raise DetectorNotMade(name, done.stdout)

    def _run(self, npm: Any, *arguments: str) -> None:  # noqa: ANN401 - `Npm`, loaded by path
        done = subprocess.run(
            [*npm.command, *arguments],
            cwd=self._web, env=npm.env, check=False, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        if done.returncode:
            raise PagesNotBuilt(arguments, done.stdout)

    def _fresh(self) -> bool:
        """Tell whether the built pages are here and no source is newer."""
        built = Path(self.root) / "src" / "talaia" / "web" / "static" / "index.html"
        if not built.is_file():
            return False
        then = built.stat().st_mtime
        return all(path.stat().st_mtime <= then for path in self._sources())

    def _sources(self) -> Iterator[Path]:
        for name in SOURCES:
            path = self._web / name
            if path.is_file():
                yield path
            elif path.is_dir():
                yield from (inner for inner in path.rglob("*") if inner.is_file())

    def _node(self) -> ModuleType:
        # A hook is loaded by its path, so its neighbour has to be too.
        spec = importlib.util.spec_from_file_location(
            "talaia_tools_node", Path(self.root) / "tools" / "node.py"
        )
        if spec is None or spec.loader is None:
            raise PagesMissing
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module
