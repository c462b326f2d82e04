"""What a file to be imported gives: samples, how far it is read, and what is not matched."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.wire.columns import Columns

__all__ = ["Findings", "ImportSource", "Piece"]


@dataclass
class Findings:
    """What a person should know of a file beside its samples.

    Attributes:
        absent: signal or channel address to the reason why nothing was found for it.
        unread: topics or columns that nothing in the description reads, with the reason.
        notes: what else is worth a look.

    """

    absent: dict[str, str] = field(default_factory=dict)
    unread: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


class Piece(NamedTuple):
    """Some samples in the order of the file, and how much of it is read (0 to 1)."""

    # 0 where nobody knows; the last piece of a file says 1.
    done: float
    columns: Columns


class ImportSource(Protocol):
    """A file that is open. Its samples are read once."""

    # For people: "rosbag 2", "CSV", or an importer's title.
    kind: str
    # Complete only when all pieces were taken.
    findings: Findings

    def read_pieces(self) -> Iterator[Piece]:
        """Read the samples; ``columns.channel`` indexes the site's channels.

        Raises:
            BadFile: it cannot be read further, with the place.

        """
        ...

    def close(self) -> None:
        """Let go of the file."""
        ...
