"""A word in the data folder that its hub keeps files elsewhere."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["read_mark", "write_mark"]

_LOG = logging.getLogger(__name__)
_NAME = "files.url"


def read_mark(data: Path) -> str:
    """Give where the last hub on a data folder kept its files; empty: there. Blocks."""
    try:
        return (data / _NAME).read_text().strip()
    except FileNotFoundError:
        return ""


def write_mark(data: Path, url: str) -> None:
    """Say where files are kept from now on; empty: in the data folder. Blocks."""
    before = read_mark(data)
    if before == url:
        return
    if before:
        _LOG.warning("files of before are in %s, where this hub does not look", before)
    if url:
        (data / _NAME).write_text(url + "\n")
    else:
        (data / _NAME).unlink(missing_ok=True)
