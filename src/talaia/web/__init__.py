"""Where the built pages are; their sources live in ``web/`` at the root of the repository."""

from __future__ import annotations

from pathlib import Path

__all__ = ["static_dir"]


def static_dir() -> Path:
    """Give the folder of the built pages; it holds no ``index.html`` until they are built."""
    return Path(__file__).parent / "static"
