"""What samples can be taken away as. Pure, and cheap to import: no pyarrow."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

__all__ = ["MEDIA_TYPES", "SUFFIXES", "ExportColumn", "FileForm"]


class FileForm(StrEnum):
    """A kind of file."""

    CSV = "csv"
    PARQUET = "parquet"
    ARROW = "arrow"


MEDIA_TYPES = {
    FileForm.CSV: "text/csv; charset=utf-8",
    FileForm.PARQUET: "application/vnd.apache.parquet",
    FileForm.ARROW: "application/vnd.apache.arrow.stream",
}
SUFFIXES = {FileForm.CSV: "csv", FileForm.PARQUET: "parquet", FileForm.ARROW: "arrows"}


class ExportColumn(NamedTuple):
    """A channel as a column of a file.

    Attributes:
        unit: goes into the column's heading (CSV) or metadata.
        states: what each whole number means, for a state; it is written as that word.
        text: the channel holds texts.

    """

    address: str
    unit: str = ""
    states: tuple[str, ...] = ()
    text: bool = False

    @property
    def worded(self) -> bool:
        """Whether its cells are words."""
        return self.text or bool(self.states)
