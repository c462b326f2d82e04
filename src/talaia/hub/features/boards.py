"""Boards: grids of tiles that people arrange, and those of descriptions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.sites.boards import BoardPages
from talaia.hub.features.feature import Feature
from talaia.hub.store.accounts.roles import Roles
from talaia.hub.store.sites.boards import Boards

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.store.audit import Audit

__all__ = ["BoardsFeature"]


class BoardsFeature(Feature):
    """Every board. What its tiles show, other features give, by their own rights.

    Attributes:
        kept: those that people made.

    """

    name = "boards"

    def __init__(self, core: Core, *, audit: Audit) -> None:
        """Keep them in the hub's database; the roles there can be shared with."""
        self.kept = Boards(core.database, core.clock)
        pages = BoardPages(
            boards=self.kept,
            roles=Roles(core.database),
            sites=core.known_sites,
            audit=audit,
        )
        self.routers = [pages.make_router()]
