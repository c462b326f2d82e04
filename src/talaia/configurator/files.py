"""A document out of its file and back: whole or not at all, and never over another's changes."""

from __future__ import annotations

import contextlib
import os
import stat
from typing import TYPE_CHECKING

from talaia.configurator.document import Document
from talaia.configurator.errors import FileChanged, NotWritten
from talaia.model.checks.text_checks import check_text
from talaia.model.errors import DescriptionError
from talaia.model.yaml_text.load import read_site, text_of, with_files

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["open_document", "opening_problems", "save_document"]


def open_document(file: Path) -> Document:
    """Open a description, or a founding observatory's command file as a new description.

    Raises:
        DescriptionError: it cannot be read, or is neither.

    """
    whole = read_site(file)
    # It is saved as a new YAML file: the observatory goes on to use its own.
    if file.suffix == ".json":
        return Document(whole)
    return Document.of_text(file.read_text(), whole.devices)


def opening_problems(file: Path) -> list[str]:
    """Say all that is wrong in a file that `open_document` refuses, each with its line.

    Empty where it is no text of a description: then the refusal says all there is.
    """
    if file.suffix == ".json":
        return []
    try:
        report = check_text(text_of(file), complete=lambda site: with_files(site, file.parent))
    except DescriptionError:
        return []
    return [
        f"line {one.line}: {one.problem}" + (f"; {one.remedy}" if one.remedy else "")
        for one in report.mistakes
    ]


def save_document(document: Document, file: Path, *, over: bool = False) -> None:
    """Write the document to its file, or to another one.

    Args:
        document: what to write.
        file: where to.
        over: write over what somebody else has written there.

    Raises:
        FileChanged: the file is not as it was opened.
        NotWritten: the file or its folder cannot be written; it is as before.
        DescriptionError: see `Document.to_yaml`.

    """
    text = document.to_yaml()
    try:
        # Compared by text, not by time: a file that was only copied or touched is the same.
        there = file.read_text() if file.exists() else document.opened
        if not over and document.opened and there != document.opened:
            raise FileChanged(f"{file.name} was changed by somebody else since it was opened")
        # Kept: a description may be readable by one user only.
        mode = stat.S_IMODE(file.stat().st_mode) if file.exists() else 0o644
        # In the same folder, for a rename works only within a file system.
        new = file.with_name(f".{file.name}.new")
        try:
            new.write_text(text)
            new.chmod(mode)
            os.replace(new, file)
        finally:
            with contextlib.suppress(FileNotFoundError):
                # There is none any more when it was renamed.
                new.unlink()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise NotWritten(f"{file} cannot be written: {reason}") from error
    # Only now: a document that could not be written stays changed.
    document.was_saved(text)
