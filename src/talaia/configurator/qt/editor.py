"""The open document for all pages: each change goes through here, and each page hears of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from talaia.configurator.errors import ConfiguratorError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.configurator.description_paths import Path as Place
    from talaia.configurator.document import Document
    from talaia.model.site import Site

__all__ = ["Editor"]


class Editor(QObject):
    """One document and its file.

    Signals:
        changed: the site, the file or what is saved is another; pages show it anew.
        refused: why a change was not made, in words.
        wanted: a page asks to show a thing (path) and a field of it (path).

    """

    changed = Signal()
    refused = Signal(str)
    wanted = Signal(object, object)

    def __init__(self, document: Document, file: Path | None = None) -> None:
        """Begin with a document, and its file if it has one."""
        super().__init__()
        # Replaced as a whole when another is opened; pages must not keep it.
        self.document = document
        # Where it is saved; none for one that has no file yet. Set by the window after a save.
        self.file = file

    @property
    def site(self) -> Site:
        """The site as it is now."""
        return self.document.site

    def replace(self, document: Document, file: Path | None) -> None:
        """Open another document."""
        self.document, self.file = document, file
        self.changed.emit()

    def apply(self, what: str, change: Callable[[Site], Site]) -> bool:
        """Make a change; false where it is refused or nothing is different."""
        try:
            # Made on a copy: what raises half way has changed nothing.
            made = change(self.site)
        except ConfiguratorError as error:
            self.refused.emit(str(error))
            return False
        if not self.document.apply_change(what, made):
            return False
        # Takes back what the window still says of a change that was refused before.
        self.refused.emit("")
        self.changed.emit()
        return True

    def undo(self) -> None:
        """Take the last change back."""
        if self.document.undo():
            self.changed.emit()

    def redo(self) -> None:
        """Do it again."""
        if self.document.redo():
            self.changed.emit()

    def show_thing(self, node: Place, field: Place = ()) -> None:
        """Ask the window to show a thing."""
        self.wanted.emit(node, field)
