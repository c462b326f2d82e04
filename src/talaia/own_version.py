"""Which version of Talaia this is: as it was built, or as git says it of a checkout.

The build (`pyproject.toml`) asks the same function, so nothing needs to be installed for it but
the standard library.
"""

from __future__ import annotations

import re
import subprocess
from functools import lru_cache
from pathlib import Path

__all__ = ["UNKNOWN", "VERSION_FILE", "own_version", "version_of_tag"]

# Written by the build into wheels and source archives; a checkout has none.
VERSION_FILE = "version.txt"
# Of a tree that is neither built nor a checkout: the archive of a forge, a copied folder.
UNKNOWN = "0.0.0+unknown"
# Before the first tag.
_FIRST = "0.1.0"
# As git describes a commit: the newest tag, commits since, and the commit's name.
_DESCRIBED = re.compile(r"v(?P<tag>[^-]+)-(?P<since>\d+)-g(?P<commit>[0-9a-f]+)")
_LAST_NUMBER = re.compile(r"\d+\Z")
# git is asked at a start; a hanging network file system must not hang that (s).
_PATIENCE_S = 5.0


@lru_cache(maxsize=1)
def own_version() -> str:
    """Give the version of the Talaia that this file is a part of."""
    package = Path(__file__).resolve().parent
    try:
        return (package / VERSION_FILE).read_text("ascii").strip()
    except FileNotFoundError:
        return version_of_checkout(package.parent.parent)


def version_of_checkout(root: Path) -> str:
    """Give the version of a checkout: a tag, or how far it is from the last one.

    Args:
        root: of the checkout; a folder inside of another's checkout has no version of that.

    """
    # A folder, or in a worktree of git a file.
    if not (root / ".git").exists():
        return UNKNOWN
    described = _ask_git(root, "describe", "--tags", "--long", "--abbrev=8", "--match=v[0-9]*")
    if described:
        return version_of_tag(described)
    commit = _ask_git(root, "rev-parse", "--short=8", "HEAD")
    count = _ask_git(root, "rev-list", "--count", "HEAD")
    return f"{_FIRST}.dev{count}+g{commit}" if commit and count else UNKNOWN


def version_of_tag(described: str) -> str:
    """Give the version by what `git describe --long` says: ``v0.1.0-12-g8fd5cecf``.

    A commit behind a tag is on its way to the version after it: the last number is one more, and
    ``.dev`` with the number of commits makes it come before that.
    """
    found = _DESCRIBED.fullmatch(described)
    if found is None:
        return UNKNOWN
    tag, since = found["tag"], int(found["since"])
    if not since:
        return tag
    after = _LAST_NUMBER.sub(lambda number: str(int(number[0]) + 1), tag)
    return f"{after}.dev{since}+g{found['commit']}"


def _ask_git(root: Path, *words: str) -> str:
    """Give what git says; empty where it says no, or is not here."""
    try:
        done = subprocess.run(  # noqa: S603 - words of our own
            ["git", "-C", str(root), *words],  # noqa: S607 - wherever it is
            capture_output=True,
            text=True,
            check=False,
            timeout=_PATIENCE_S,
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
