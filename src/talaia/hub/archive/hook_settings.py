"""The file that says to what each new picture is handed over: read once, at the start.

It lies on the hub's own machine, and nothing that comes over the network can change it: no
description, no gateway, no upload and no page (security.md, "Parts of others").
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated
from urllib.parse import urlsplit

import msgspec
import yaml
from msgspec import Meta

from talaia.hub.errors import CannotStart

__all__ = ["ArchiveHookSettings", "read_archive_hook"]

_MOST_FILE = 64 * 1024
_Word = Annotated[str, Meta(min_length=1, max_length=4000)]


class ArchiveHookSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All of the file: a command or an address.

    Attributes:
        command: program, by its whole path, and its arguments; no shell reads them.
        url: to which the picture's facts are posted (JSON).
        token_file: holds a token that goes with them (``Authorization: Bearer``).
        timeout: a command that runs longer is ended and counts as failed (s).

    """

    command: Annotated[list[_Word], Meta(max_length=100)] = []
    url: Annotated[str, Meta(max_length=2000)] = ""
    token_file: str = ""
    timeout: Annotated[float, Meta(gt=0, le=86_400)] = 300.0


def read_archive_hook(path: Path) -> ArchiveHookSettings:
    """Read the file; the token's is meant from its folder on.

    Raises:
        CannotStart: it cannot be read, or names neither or both.

    """
    advice = "see: talaia docs the-archive"
    try:
        with path.open("rb") as file:
            text = file.read(_MOST_FILE)
    except OSError as error:
        why = f"--archive-hook {path} cannot be read: {error.strerror or error}"
        raise CannotStart(why, advice) from error
    try:
        read = msgspec.convert(yaml.safe_load(text), ArchiveHookSettings)
    except (yaml.YAMLError, msgspec.ValidationError, RecursionError, ValueError) as error:
        raise CannotStart(f"--archive-hook {path}: {error}", advice) from error
    if bool(read.command) == bool(read.url):
        raise CannotStart(f"--archive-hook {path}: give either a command or a url", advice)
    if read.command:
        _check_command(path, Path(read.command[0]), advice)
    elif urlsplit(read.url).scheme not in {"http", "https"}:
        raise CannotStart(f"--archive-hook {path}: url: expected https:// or http://", advice)
    if not read.token_file:
        return read
    return msgspec.structs.replace(read, token_file=str(path.parent / read.token_file))


def _check_command(path: Path, program: Path, advice: str) -> None:
    # By its whole path: what stands first in some PATH is nobody's choice.
    if not program.is_absolute() or not os.access(program, os.X_OK):
        why = f"--archive-hook {path}: command: expected the whole path of a program, {program}"
        raise CannotStart(why, advice)
