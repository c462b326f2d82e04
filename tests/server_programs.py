"""Servers that tests judge by, each a Debian package of its name: where they are, or no test."""

from __future__ import annotations

import os
import shutil

import pytest


def find_server(name: str) -> str | None:
    """Find a server's program, also where only root's path leads."""
    return shutil.which(name, path=f"{os.environ.get('PATH', '')}:/usr/sbin:/usr/bin")


def server_or_skip(name: str) -> str:
    """Find it, or skip; where all tests are required, fail."""
    program = find_server(name)
    if program is None:
        said = f"{name} is missing (apt install {name})"
        (pytest.fail if os.environ.get("TALAIA_REQUIRE_ALL") == "1" else pytest.skip)(said)
    return program or ""
