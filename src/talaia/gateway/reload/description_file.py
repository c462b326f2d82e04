"""The file of the description: the gateway's own copy, which is the authority over the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.persistence import write_whole
from talaia.model.errors import NotReadable
from talaia.model.yaml_text.load import beside_of, text_of
from talaia.wire.sealing import digest_of

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.model.site import Site

__all__ = ["DescriptionFile"]

# A file's inode, length and time of change; none where there is no file.
_Mark = tuple[int, int, int] | None


class DescriptionFile:
    """A description's file and those that it takes in, watched by looking at them.

    Attributes:
        path: of the file.
        text: what counts now, as it stood in the file.

    """

    def __init__(self, path: Path) -> None:
        """Read the file.

        Raises:
            NotReadable: it cannot be read.

        """
        self.path = path
        self._beside: list[Path] = []  # Other files that it takes in; known from `accept_text` on.
        # Before the text is read: a change in between is seen at the next look.
        self._seen = self._file_marks()
        # Marks of what was given out or counts; a change is one from these.
        self._settled = self._seen
        self.text = text_of(path)

    @property
    def digest(self) -> str:
        """Name the text."""
        return digest_of(self.text)

    @property
    def editable(self) -> bool:
        """Tell whether its text is a description that can be written anew."""
        return self.path.suffix != ".json"

    def accept_text(self, site: Site, text: str) -> None:
        """Take a text, and what it describes, as what counts from here on."""
        self.text = text
        # Files that the new text takes in are watched from here on.
        self._beside = beside_of(site, self.path.parent)
        self._seen = self._settled = self._file_marks()

    def read_change(self) -> str | None:
        """Give the file's text if it was changed and is being written no more, else none.

        A change is given once. It takes two looks, so that a file that is written piece by piece
        is read whole.

        Raises:
            NotReadable: it was changed, and cannot be read now.

        """
        # Before the text, as at the start.
        marks = self._file_marks()
        still, self._seen = marks == self._seen, marks
        if not still or marks == self._settled:
            return None
        self._settled = marks
        # Told as an error: the gateway goes on by what it knows.
        if marks[0] is None:
            raise NotReadable(str(self.path), "is not there any more", "put it back")
        return text_of(self.path)

    def write_text(self, text: str) -> None:
        """Put another text in the file's place; a crash leaves the old or the new.

        Raises:
            OSError: it is not written; the old one stands.

        """
        # A link to a file stays a link.
        path = self.path.resolve()
        # A new file takes its place, and would have the mode of any new file.
        mode = path.stat().st_mode & 0o777
        write_whole(path, text.encode())
        path.chmod(mode)
        # What we wrote ourselves is no change to follow.
        self._seen = self._settled = self._file_marks()

    def _file_marks(self) -> list[_Mark]:
        return [_file_mark(path) for path in (self.path, *self._beside)]


def _file_mark(path: Path) -> _Mark:
    try:
        found = path.stat()
    except OSError:
        return None
    # All three: an editor may keep the time, or replace the file by one of the same length.
    return found.st_ino, found.st_size, found.st_mtime_ns
