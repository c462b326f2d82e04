"""Notes: what people write about moments and spans of their sites."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.notes.note_pages import NotePages
from talaia.hub.features.feature import Feature
from talaia.hub.store.sites.notes import NoteStore

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.store.audit import Audit

__all__ = ["NotesFeature"]


class NotesFeature(Feature):
    """Keeps them, and tells pages that they have changed.

    Attributes:
        store: where they are kept.

    """

    name = "notes"

    def __init__(self, core: Core, *, audit: Audit) -> None:
        """Keep them in the hub's database; ``audit`` holds who wrote, changed and removed what."""
        self.store = NoteStore(core.database, core.clock)
        pages = NotePages(store=self.store, browsers=core.browsers, audit=audit)
        self.routers = [pages.make_router()]
