"""What a night wrote is there after a crash at any point, and never guessed where it is damaged."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from talaia.gateway.errors import SpoolError
from talaia.gateway.night.night_store import NightStore
from talaia.gateway.night.night_values import ObservationChange
from talaia.gateway.night.observation_book import BookContent, ObservationBook
from talaia.model.observing.states import ObservationState

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.pure


def kept_book(folder: Path, names: str) -> tuple[ObservationBook, NightStore]:
    """Write one observation after the other."""
    book, store = ObservationBook(BookContent(), "site"), NightStore(folder)
    for name in names:
        observe(book, name)
        store.book_writer(book)()
    return book, store


def observe(book: ObservationBook, name: str) -> None:
    book.record_change(ObservationChange(name, ObservationState.COMPLETED, (1,)), 1.0)


def read_book(folder: Path) -> ObservationBook:
    return NightStore(folder).read_book("site")


def test_what_was_written_behind_the_book_is_read_with_it(tmp_path: Path) -> None:
    book, _ = kept_book(tmp_path, "abc")
    assert len((tmp_path / "observations.log").read_bytes().split()) == 2
    assert read_book(tmp_path).content == book.content


def test_a_line_that_a_power_cut_broke_off_is_passed_over_and_the_next_goes_on(
    tmp_path: Path,
) -> None:
    kept_book(tmp_path, "abc")
    log = tmp_path / "observations.log"
    log.write_bytes(log.read_bytes()[:-20])
    book = read_book(tmp_path)
    assert book.ended == {"a", "b"}
    # The first of a run writes all of it anew.
    observe(book, "d")
    NightStore(tmp_path).book_writer(book)()
    assert read_book(tmp_path).ended == {"a", "b", "d"}
    assert not log.exists()


def test_entries_that_the_whole_book_has_already_are_passed_over(tmp_path: Path) -> None:
    book, store = kept_book(tmp_path, "abc")
    log = tmp_path / "observations.log"
    left = log.read_bytes()
    book.write_whole()
    store.book_writer(book)()
    # Killed between the two: the book is new, and the entries are still there.
    log.write_bytes(left)
    assert read_book(tmp_path).content == book.content


def test_an_entry_that_is_damaged_in_the_middle_is_not_guessed(tmp_path: Path) -> None:
    kept_book(tmp_path, "abcd")
    log = tmp_path / "observations.log"
    log.write_bytes(log.read_bytes().replace(b'"b"', b'"b', 1))
    with pytest.raises(SpoolError, match="update 2 is missing or damaged"):
        read_book(tmp_path)


def test_nothing_is_written_behind_what_the_disk_did_not_take(tmp_path: Path) -> None:
    book, store = kept_book(tmp_path, "ab")
    log = tmp_path / "observations.log"
    left = log.read_bytes()
    # A folder in its place takes no line.
    log.unlink()
    log.mkdir()
    for name in "cd":
        observe(book, name)
        with pytest.raises(OSError, match=r"directory|not written"):
            store.book_writer(book)()
    log.rmdir()
    log.write_bytes(left)
    observe(book, "e")
    with pytest.raises(OSError, match="not written"):
        store.book_writer(book)()
    assert read_book(tmp_path).ended == {"a", "b"}
    book.write_whole()
    store.book_writer(book)()
    assert read_book(tmp_path).ended == set("abcde")


def test_nothing_is_written_behind_a_book_that_the_disk_did_not_take_whole(tmp_path: Path) -> None:
    book, store = kept_book(tmp_path, "ab")
    (tmp_path / "observations.json.new").mkdir()
    observe(book, "c")
    book.write_whole()
    writers = [store.book_writer(book)]
    # Asked for before anybody knows that the whole one fails.
    observe(book, "d")
    writers.append(store.book_writer(book))
    for write in writers:
        with pytest.raises(OSError, match=r"directory|not written"):
            write()
    assert read_book(tmp_path).ended == {"a", "b"}
