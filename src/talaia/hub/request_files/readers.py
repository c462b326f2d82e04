"""Which reader a file's kind has."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING

from talaia.hub.request_files.csv_list import read_csv
from talaia.hub.request_files.ekos_list import read_ekos
from talaia.hub.request_files.lco_json import read_lco
from talaia.hub.request_files.nina_json import read_nina

if TYPE_CHECKING:
    from talaia.hub.request_files.imported import ImportDefaults, ImportedGroups

__all__ = ["FileKind", "read_request_file"]


class FileKind(StrEnum):
    """Whose file it is."""

    LCO = "lco"
    CSV = "csv"
    NINA = "nina"
    EKOS = "ekos"


_READERS = {
    FileKind.LCO: read_lco,
    FileKind.CSV: read_csv,
    FileKind.NINA: read_nina,
    FileKind.EKOS: read_ekos,
}


def read_request_file(kind: FileKind, text: str, defaults: ImportDefaults) -> ImportedGroups:
    """Read a file: what it asks, and what of it could not be read."""
    return _READERS[kind](text, defaults)
