"""Write NOTICE: what others have made that the wheel and the pages carry; ``--check`` compares it.

.venv/bin/python tools/generate_notice.py [--check]

Libraries of Python are not in the wheel: each is installed by itself, with its own licence. Bundled
with the pages are the npm packages of `package.json`'s ``dependencies``, and what those need.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / "NOTICE"
WEB = ROOT / "web"
# Types are read by the compiler alone; the other is for servers that draw pages.
NOT_BUNDLED = ("@types/", "@lit-labs/ssr-dom-shim")
LICENCE_NAMES = ("LICENSE", "LICENSE.md", "LICENSE.txt", "LICENCE", "COPYING")
# Licences whose text need not be repeated, since the whole of it is in our own LICENSE.
OUR_OWN = "Apache-2.0"
# What is in the wheel besides, and where each says its authors and licence.
CARRIED = {
    "The detectors of objects and faces": "src/talaia/objects/CREDITS.md",
    "The star catalogue": "src/talaia/imaging/data/CREDITS.md",
    "The pictures that the simulated camera shows": "src/talaia/sim/vehicle/pictures/CREDITS.md",
    "The list of common passwords": "src/talaia/hub/auth/common_passwords.license.txt",
}
HEAD = """\
Talaia
Copyright The Talaia developers

Licensed under the Apache License, Version 2.0; see LICENSE.

This file is made by tools/generate_notice.py; do not edit it.
"""
LINE = "=" * 78


class LicenceMissing(Exception):
    """A package says neither its licence's text nor that it is ours."""


def bundled_packages(lock: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Give the packages that the pages carry, by their folder in ``web``."""
    return {
        folder: package
        for folder, package in sorted(lock["packages"].items())
        if folder
        and not package.get("dev")
        and not package.get("optional")
        and not folder.removeprefix("node_modules/").startswith(NOT_BUNDLED)
    }


def licence_of(folder: Path, licence: str) -> str:
    """Give the text of a package's licence.

    Raises:
        LicenceMissing: there is none.

    """
    for name in LICENCE_NAMES:
        if (file := folder / name).exists():
            return file.read_text(encoding="utf-8").replace("\r\n", "\n").strip()
    if licence == OUR_OWN:
        return f"Under the same licence as Talaia ({OUR_OWN}), whose text is in LICENSE."
    raise LicenceMissing(f"{folder} has no {' or '.join(LICENCE_NAMES)} for {licence!r}")


def write_notice() -> str:
    """Give the whole text."""
    parts = [HEAD, "The wheel carries, each under the licence that its file says:\n"]
    for what, where in CARRIED.items():
        if not (ROOT / where).exists():
            raise LicenceMissing(f"{where} is not there; {what.lower()} needs it")
        parts.append(f"- {what}: {where}")
    parts.append("\nThe pages carry these packages of npm:")
    lock = json.loads((WEB / "package-lock.json").read_text(encoding="utf-8"))
    for folder, package in bundled_packages(lock).items():
        name = folder.rpartition("node_modules/")[2]
        licence = package.get("license", "")
        text = licence_of(WEB / folder, licence)
        parts.append(f"\n{LINE}\n{name} {package['version']} ({licence})\n{LINE}\n\n{text}")
    return "\n".join(parts) + "\n"


def main(arguments: list[str]) -> int:
    """Write the file, or tell whether it is as it would be written."""
    text = write_notice()
    if "--check" in arguments:
        if TARGET.exists() and TARGET.read_text(encoding="utf-8") == text:
            return 0
        print("NOTICE is not what tools/generate_notice.py writes; run it and commit the file")
        return 1
    TARGET.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
