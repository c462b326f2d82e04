"""Talaia's own wheels, packed anew from where they are installed.

So an image holds the very Talaia that wrote its recipe, and no index is asked for it.
"""

from __future__ import annotations

import base64
import hashlib
import zipfile
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import TYPE_CHECKING

import talaia
from talaia.cli.errors import CliError

if TYPE_CHECKING:
    from importlib.metadata import PackagePath

__all__ = ["MODELS", "pack_own_wheel"]

# The wheel of the detectors' files.
MODELS = "talaia-models"
# What pip writes about an installation, and no wheel holds.
_OF_PIP = ("INSTALLER", "RECORD", "REQUESTED", "direct_url.json")
# The oldest time that a zip file can say: the same installation makes the same wheel.
_WHEN = (1980, 1, 1, 0, 0, 0)


def pack_own_wheel(folder: Path, name: str = "talaia") -> Path | None:
    """Write a wheel, and give where; none where it is not installed, or runs from a checkout.

    Args:
        folder: that it is written into.
        name: of the package.

    Raises:
        CliError: a file is not what was installed.

    """
    try:
        found = distribution(name)
    except PackageNotFoundError:
        return None
    files = [file for file in found.files or [] if _is_packed(file)]
    # The Talaia that runs may be another than the one that is installed.
    here = Path(talaia.__file__).resolve().parent
    if not any(here in Path(str(file.locate())).resolve().parents for file in files):
        return None
    target = folder / f"{name.replace('-', '_')}-{found.version}-py3-none-any.whl"
    _write_wheel(target, found, files)
    return target


def _is_packed(file: PackagePath) -> bool:
    # What lies outside are programs, which pip makes from the entry points.
    return not (
        file.parts[0] == ".."
        or "__pycache__" in file.parts
        or (file.parts[0].endswith(".dist-info") and file.name in _OF_PIP)
    )


def _write_wheel(target: Path, found: Distribution, files: list[PackagePath]) -> None:
    # Of the list of all files that a wheel ends with; it names no hash of itself.
    rows = []
    (folder,) = {file.parts[0] for file in files if file.parts[0].endswith(".dist-info")}
    # Beside it first: a wheel that was begun and not ended is never built from.
    half = target.with_suffix(".half")
    with zipfile.ZipFile(half, "w", zipfile.ZIP_DEFLATED) as packed:
        for file in sorted(files):
            content = Path(str(found.locate_file(file))).read_bytes()
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
            if file.hash is None or file.hash.value != digest:
                half.unlink()
                raise CliError(
                    f"{file.locate()}: was changed since Talaia was installed; install it anew, or "
                    "give its wheel (--wheel)"
                )
            packed.writestr(zipfile.ZipInfo(str(file), _WHEN), content, zipfile.ZIP_DEFLATED)
            rows.append(f"{file},sha256={digest},{len(content)}\n")
        record = f"{folder}/RECORD"
        packed.writestr(zipfile.ZipInfo(record, _WHEN), "".join([*rows, f"{record},,\n"]))
    # At one blow: whoever builds meanwhile has the one before, or this.
    half.replace(target)
