"""What stands in the place of the description's file is read, refused or waited for."""

from __future__ import annotations

import os
import threading
from typing import TYPE_CHECKING

import pytest

from talaia.gateway.reload.description_file import DescriptionFile
from talaia.model.errors import NotReadable

if TYPE_CHECKING:
    from pathlib import Path


def test_a_changed_file_is_given_once_and_only_when_it_is_written_no_more(tmp_path: Path) -> None:
    path = tmp_path / "site.yaml"
    path.write_text("one")
    file = DescriptionFile(path)
    assert file.read_change() is None
    path.write_text("two parts")
    assert file.read_change() is None
    path.write_text("two parts of it")
    assert [file.read_change() for _ in range(3)] == [None, "two parts of it", None]


def test_a_pipe_in_the_place_of_the_file_is_refused_and_the_file_is_read_again(
    tmp_path: Path,
) -> None:
    path = tmp_path / "site.yaml"
    path.write_text("one")
    file = DescriptionFile(path)
    path.unlink()
    os.mkfifo(path)
    assert file.read_change() is None
    # In a thread: to read a pipe that nobody writes into would never end.
    found: list[BaseException] = []

    def look() -> None:
        try:
            file.read_change()
        except NotReadable as error:
            found.append(error)

    looking = threading.Thread(target=look, daemon=True)
    looking.start()
    looking.join(10.0)
    assert "is not a file" in str(found)
    path.unlink()
    path.write_text("two")
    assert [file.read_change() for _ in range(2)] == [None, "two"]


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir])
def test_a_gateway_does_not_start_on_what_is_no_file(make, tmp_path: Path) -> None:
    make(tmp_path / "site.yaml")
    with pytest.raises(NotReadable, match="is not a file"):
        DescriptionFile(tmp_path / "site.yaml")
