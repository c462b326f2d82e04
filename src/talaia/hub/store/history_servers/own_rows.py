"""Which rows of a shared database are this hub's own, where others have other sites there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement

__all__ = ["OwnRows", "every_row"]


class OwnRows(Protocol):
    """Says in SQL which sites' rows are meant."""

    def __call__(self, site: ColumnElement[Any], /) -> tuple[ColumnElement[bool], ...]:
        """Give conditions, all of which hold where the column ``site`` names an own site."""
        ...


def every_row(site: ColumnElement[Any], /) -> tuple[ColumnElement[bool], ...]:
    """Leave none out: all sites are this hub's own."""
    return ()
