"""Packages of extensions that are broken, each in a way of its own, written as pip leaves them."""

from __future__ import annotations

from pathlib import Path

DETECTOR = """
from talaia.extend.detector import AnomalyDetector, DetectorExtension
class D(AnomalyDetector, kw_only=True):
    def see(self, time_us, value):
        {see}
extension = DetectorExtension(api=1, summary="test", make=D)
"""


def write_package(folder: Path, name: str, group: str, entry: str, code: str) -> None:
    """Write a package of one module that brings one extension."""
    module = f"x_{name}"
    (folder / f"{module}.py").write_text(code)
    info = folder / f"x_{name}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: x-{name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{group}]\n{entry} = {module}:extension\n")
