"""Packages of ROS as they are installed, made in a folder for tests."""

from __future__ import annotations

from pathlib import Path

__all__ = ["make_ament_package", "make_ros1_package"]


def make_ament_package(prefix: Path, package: str, files: dict[str, bytes]) -> Path:
    """Install a package of ROS 2 below a prefix; gives its share folder."""
    marks = prefix / "share" / "ament_index" / "resource_index" / "packages"
    marks.mkdir(parents=True, exist_ok=True)
    (marks / package).touch()
    return _fill(prefix / "share" / package, files)


def make_ros1_package(root: Path, folder: str, package: str, files: dict[str, bytes]) -> Path:
    """Put a package of ROS 1 into a workspace; its folder may have another name than it has."""
    text = f"<?xml version='1.0'?><package><name>{package}</name></package>"
    return _fill(root / folder, {"package.xml": text.encode(), **files})


def _fill(folder: Path, files: dict[str, bytes]) -> Path:
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    folder.mkdir(parents=True, exist_ok=True)
    return folder
