"""Builds the Python environment of a release from its wheels, without any network."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING

from talaia.updates.errors import UpdateError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

__all__ = ["build_environment"]

# On a memory card (s).
_BUILD_S = 1_800.0


def build_environment(wheels: Sequence[Path], slot: Path, *, system_packages: bool) -> None:
    """Make an environment in ``slot`` with exactly these wheels.

    Args:
        wheels: each was held against its hash.
        slot: an empty folder.
        system_packages: whether the system's own packages are seen, as for ROS from apt.

    Raises:
        UpdateError: Python or pip refuses.

    """
    shared = ["--system-site-packages"] if system_packages else []
    _run_words([sys.executable, "-m", "venv", *shared, str(slot)])
    # No index and no dependencies: what is not in the release is not installed.
    pip = [str(slot / "bin" / "python"), "-m", "pip", "--disable-pip-version-check", "install"]
    _run_words([*pip, "--no-index", "--no-deps", "--no-cache-dir", *map(str, wheels)])
    # All of it on disk before anybody says that it is whole.
    os.sync()


def _run_words(words: Sequence[str]) -> None:
    # The robot may be driven meanwhile.
    nice = shutil.which("nice")
    first = [nice, "-n", "19"] if nice else []
    try:
        done = subprocess.run(  # noqa: S603 - our own interpreter
            [*first, *words], capture_output=True, text=True, timeout=_BUILD_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise UpdateError(f"{' '.join(words[:3])}: {error}") from error
    if done.returncode:
        said = (done.stderr.strip().splitlines() or ["it says nothing"])[-1]
        raise UpdateError(f"{' '.join(words[:3])}: {said}")
