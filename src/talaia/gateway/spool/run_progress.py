"""How far this run came, kept for the run that follows it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.gateway.spool.progress_mark import MarkFile, ProgressMark

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from talaia.gateway.spool.gaps import SpoolGaps

__all__ = ["RunProgress"]

# A wall clock that is that far off was set (µs).
_JUMP_US = 5_000_000


class RunProgress:
    """The mark of this run takes the place of the former one's, but never too early.

    What the former run lost is known by its mark alone until that is on disk as gaps. So as long
    as the disk does not take those, its mark stays, and this run leaves none.

    Attributes:
        former: what the run before this one left of itself; none where there was none.

    """

    def __init__(
        self,
        path: Path,
        boot: str,
        *,
        gaps: SpoolGaps,
        acked: Mapping[str, int],
        now: Callable[[], float],
        began_us: int,
        machine: str,
    ) -> None:
        """Read what the run before left.

        Args:
            path: of the file that holds the mark.
            boot: this run's name.
            gaps: what is lost, of former runs too.
            acked: by boot: below which sample all is stored for good; kept up to date by others.
            now: a clock that never jumps (s).
            began_us: when this run began (µs, UTC).
            machine: see `ProgressMark.machine`.

        """
        self._file = MarkFile(path)
        self._gaps = gaps  # Asked whether what the former run lost is on disk.
        self._acked = acked  # Shared with `Spool`, which writes to it.
        self._now = now  # Monotonic (s), for the mark's `mono_s`.
        self.former = self._file.former
        # The former run's mark is in the file still.
        self._former_stands = self.former is not None
        # What the file says, or would say if the disk had taken it.
        deaf_us = began_us if self.former is not None else 0
        self._mark = ProgressMark(boot, began_us=began_us, deaf_us=deaf_us, machine=machine)

    def save_progress(self, end: int, heard_us: int) -> None:
        """Leave word that samples below ``end`` are in the spool, heard up to ``heard_us``."""
        # The gaps first: they are made of the former mark, and with it gone nothing else tells of
        # them.
        if self._gaps.dirty and self._former_stands:
            self._gaps.write_gaps()
            if self._gaps.dirty:
                return
        self._former_stands = False
        mark, acked = self._mark, self._acked.get(self._mark.boot, 0)
        # A clock that was set back a long way is believed; one that wavers is not.
        if abs(mark.heard_us - heard_us) < _JUMP_US:
            heard_us = max(mark.heard_us, heard_us)
        # `max`: sync hands in no number, and a record that was lost has been counted already.
        self._mark = replace(
            mark, end=max(mark.end, end), acked=acked, heard_us=heard_us, mono_s=self._now()
        )
        self._file.write_mark(self._mark)

    def count_lost(self, end: int) -> None:
        """Count samples below ``end`` in that are lost; the next word that is left says so."""
        # Not written at once: the next record, or the next `sync`, writes it.
        self._mark = replace(self._mark, end=max(self._mark.end, end))

    def all_heard(self) -> None:
        """Note that every channel that speaks has been heard, or is told as a gap."""
        self._mark = replace(self._mark, deaf_us=0)

    def save_acked(self) -> None:
        """Leave word of what the hub has, before it goes from the disk.

        Otherwise the next run would take it for lost.
        """
        # Asked first: it is called for every segment that goes, and mostly nothing is new.
        if self._acked.get(self._mark.boot, 0) > self._mark.acked:
            self.save_progress(self._mark.end, self._mark.heard_us)

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()
