"""Build hook: what is made travels in the wheel and in the sdist, so that users need no Node.

The pages are built when their sources are here and the built ones are missing or older, and the
version is written down. An editable install makes nothing: a developer has `make setup`,
`make pages` and the development server, and a checkout's version is git's.
"""

from __future__ import annotations

import importlib.util
import subprocess
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import ModuleType

SOURCES = ("src", "public", "index.html", "package.json", "package-lock.json", "vite.config.ts")
# Where it is in what is built; read by `talaia.own_version`.
VERSION_FILES = {"wheel": "talaia/version.txt", "sdist": "src/talaia/version.txt"}


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


class MadeHook(BuildHookInterface):  # type: ignore[type-arg]
    """See the module."""

    PLUGIN_NAME = "talaia-made"

    def dependencies(self) -> list[str]:
        """Ask the front end for Node, where the pages have to be built and there is none."""
        node = self._node()
        builds = not self._fresh() and self._web.is_dir()
        return [str(node.PACKAGE)] if builds and node.machine_npm() is None else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Make what is missing, or nothing where that is not wanted.

        Raises:
            PagesMissing: nothing to build the pages from.
            PagesNotBuilt: npm failed.

        """
        if version == "editable":
            return
        written = self._written = Path(tempfile.mkstemp(suffix=".txt")[1])
        written.write_text(f"{self.metadata.version}\n", "ascii")
        # `mkstemp` makes it for its owner alone, and the mode goes into the archive.
        written.chmod(0o644)
        build_data["force_include"][str(written)] = VERSION_FILES[self.target_name]
        if self._fresh():
            return
        if not self._web.is_dir():
            raise PagesMissing
        npm = self._node().find_npm()
        # What a developer has installed is left as it is.
        if not (self._web / "node_modules" / "vite").is_dir():
            self._run(npm, "ci", "--no-audit", "--no-fund")
        self._run(npm, "run", "build")

    def finalize(self, version: str, _build_data: dict[str, Any], _artifact: str) -> None:
        """Remove what was written for the build alone."""
        if version != "editable":
            self._written.unlink(missing_ok=True)

    @property
    def _web(self) -> Path:
        return Path(self.root) / "web"

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
