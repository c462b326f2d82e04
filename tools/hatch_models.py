"""Build hook of talaia-models: the detectors' files are made when they are missing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

TREE = Path(__file__).resolve().parent.parent
MODELS = "src/talaia/objects/models"
# What sees objects and what finds faces, each by the script that makes it.
DETECTORS = {"nanodet.onnx": "make_detector.py", "centerface.onnx": "make_face_detector.py"}


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


class ModelsHook(BuildHookInterface):  # type: ignore[type-arg]
    """See the module."""

    PLUGIN_NAME = "talaia-models"

    def dependencies(self) -> list[str]:
        """Ask the front end for what makes what is missing: NumPy, pip, Node if there is none."""
        missing = _missing_detectors()
        wanted = ["numpy>=2.0", "pip>=24"] if missing else []
        if "nanodet.onnx" in missing:
            sys.path.insert(0, str(TREE / "tools"))
            import node

            if node.machine_npm() is None:
                wanted.append(str(node.PACKAGE))
        return wanted

    def initialize(self, _version: str, _build_data: dict[str, Any]) -> None:
        """Make what is missing.

        Raises:
            DetectorNotMade: a detector's file could not be made.

        """
        for name in _missing_detectors():
            done = subprocess.run(
                [sys.executable, str(TREE / "tools" / DETECTORS[name])],
                check=False, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            )  # fmt: skip
            if done.returncode:
                raise DetectorNotMade(name, done.stdout)


def _missing_detectors() -> list[str]:
    return [name for name in DETECTORS if not (TREE / MODELS / name).is_file()]
