"""Writes an older site description as it is written today."""

from __future__ import annotations

import contextlib
import difflib
import os
import sys
from typing import TYPE_CHECKING

from talaia.cli.errors import CliError
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site, text_of
from talaia.model.yaml_text.upgrade import upgrade_text

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["upgrade_file"]


def upgrade_file(path: Path, *, write: bool) -> bool:
    """Upgrade one file; tell whether something is left to do."""
    before = text_of(path)
    after, changes = upgrade_text(before)
    if not changes:
        print(f"{path}: is of the newest format already", file=sys.stderr)
        return False
    if not write:
        name = str(path)
        rows = difflib.unified_diff(
            before.splitlines(keepends=True), after.splitlines(keepends=True), name, name
        )
        print("".join(rows), end="")
    for change in changes:
        print(f"{path}: {change}", file=sys.stderr)
    # The new text is read again, so that a mistake of the upgrade itself is told before it is
    # written.
    findings = check_site(load_site(after))
    for finding in findings:
        print(f"{path}: {finding}", file=sys.stderr)
    if write:
        # The file that a link leads to: replacing the link would leave two files.
        _replace_file(path.resolve(), after)
        return bool(findings)
    print(f"{path}: not changed; --write changes it", file=sys.stderr)
    return True


def _replace_file(path: Path, text: str) -> None:
    """Write the whole file or nothing of it; it stays whose and how readable it was."""
    # In the same folder, for a rename works only within a file system.
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        mode = path.stat().st_mode & 0o777
        fresh.touch(mode=mode)
        fresh.chmod(mode)
        with fresh.open("w", encoding="utf-8", newline="") as file:
            file.write(text)
            file.flush()
            # Before the rename: after a power cut the name must not lead to an empty file.
            os.fsync(file.fileno())
        fresh.replace(path)
    except OSError as error:
        raise CliError(f"{path} cannot be written: {error.strerror}") from error
    finally:
        with contextlib.suppress(OSError):
            # After the rename there is nothing of that name; that is no error.
            fresh.unlink()
