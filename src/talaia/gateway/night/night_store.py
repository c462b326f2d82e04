"""What a night keeps on disk: who armed it, what is asked, what was done. Blocks on the disk."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import msgspec

from talaia.gateway.errors import SpoolError
from talaia.gateway.night.arming import NightArming
from talaia.gateway.night.observation_book import BookContent, BookEntry, ObservationBook
from talaia.gateway.night.request_intake import RequestSet
from talaia.gateway.persistence import append_lines, read_whole, write_whole

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

__all__ = ["NightStore"]

T = TypeVar("T")
# Beside the file of the whole book.
_ENTRIES = "observations.log"


class NightStore:
    """Three files in one folder, each written whole, and one of entries behind the book's.

    From one thread.

    Raises:
        SpoolError: a file is damaged; it is not guessed who armed a roof.

    """

    def __init__(self, folder: Path) -> None:
        """Use ``folder``, which is made when something is written first."""
        self._folder = folder
        # Entries may be written behind the book's file: all before them are there.
        self._goes_on = False

    def read_arming(self) -> NightArming:
        """Give who has armed it."""
        return self._read("arming", NightArming)

    def read_requests(self) -> RequestSet:
        """Give what is asked."""
        return self._read("requests", RequestSet)

    def read_book(self, gateway: str) -> ObservationBook:
        """Give what was done: the book, and what was written behind it.

        ``gateway`` is part of the ids of what comes.
        """
        content = self._read("observations", BookContent)
        return ObservationBook(content, gateway, self._read_entries(content.number))

    def _read_entries(self, number: int) -> Iterator[BookEntry]:
        """Read what follows an update; a line that a power cut broke off was never told."""
        path = self._folder / _ENTRIES
        try:
            lines = path.read_bytes().split(b"\n")
        except FileNotFoundError:
            return
        for line in filter(None, lines):
            try:
                entry = msgspec.json.decode(line, type=BookEntry)
            except (msgspec.DecodeError, UnicodeError):
                continue
            if entry.update is not None:
                # Of before the book was written whole.
                if entry.update.number <= number:
                    continue
                number += 1
                if entry.update.number != number:
                    raise SpoolError(
                        f"{path} cannot be read: update {number} is missing or damaged; it guards"
                        " what the hub is told, so it is not guessed: restore it, or remove the"
                        " folder of the night when its hub has heard everything"
                    )
            yield entry

    def write_arming(self, arming: NightArming) -> None:
        """Keep it; raises `OSError` when the disk does not take it."""
        self._write("arming", msgspec.json.encode(arming))

    def write_requests(self, requests: RequestSet) -> None:
        """Keep it; raises `OSError` when the disk does not take it."""
        self._write("requests", msgspec.json.encode(requests))

    def book_writer(self, book: ObservationBook) -> Callable[[], None]:
        """Give what writes a book as it stands now; it raises `OSError` when the disk does not.

        Encoded at once: the book goes on changing while the disk is busy.
        """
        pages = book.take_pages()
        if pages.whole is not None:
            whole = msgspec.json.encode(pages.whole)
            return lambda: self._write_whole_book(whole)
        lines = b"".join(msgspec.json.encode(entry) + b"\n" for entry in pages.entries)
        return lambda: self._write_entries(lines)

    def _write_whole_book(self, whole: bytes) -> None:
        self._goes_on = False
        self._write("observations", whole)
        # A crash before this leaves entries that the book has already: their numbers say so.
        (self._folder / _ENTRIES).unlink(missing_ok=True)
        self._goes_on = True

    def _write_entries(self, lines: bytes) -> None:
        if not self._goes_on:
            raise OSError("what came before it is not written")
        # Until it is there nothing may stand behind it.
        self._goes_on = False
        append_lines(self._folder / _ENTRIES, lines)
        self._goes_on = True

    def _read(self, name: str, kind: type[T]) -> T:
        return read_whole(self._folder / f"{name}.json", kind, kind)

    def _write(self, name: str, data: bytes) -> None:
        self._folder.mkdir(exist_ok=True, mode=0o700)
        write_whole(self._folder / f"{name}.json", data)
