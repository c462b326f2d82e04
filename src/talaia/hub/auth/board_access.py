"""Who may see, change and share a board, decided from values alone.

A board grants no data: each of its tiles asks for its own by the policy, as every page does.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.auth.permissions import ANY, Right

if TYPE_CHECKING:
    from talaia.hub.auth.permissions import Grants, Who

__all__ = ["BoardShare", "BoardSubject", "may_change", "may_share", "sees_board"]


class BoardShare(StrEnum):
    """Who sees a board beside its owner and the hub's admins."""

    OWN = "own"
    # Everybody of one role.
    ROLE = "role"
    # Everybody with the right view on its site, or on something of it.
    VIEW = "view"
    # Everybody who is signed in, and every display.
    PUBLIC = "public"


class BoardSubject(NamedTuple):
    """What of a board decides who sees it; ``site`` is empty where it is for any."""

    owner: int
    share: BoardShare
    role: str
    site: str


def _holds(grants: Grants, right: Right, site: str) -> bool:
    """Tell whether a person has a right somewhere at a site; of none named, anywhere."""
    return any(
        permission.covers(right, site or permission.site, permission.device)
        for permission in grants.permissions
    )


def _administers(who: Who) -> bool:
    return not who.script and who.grants.has_right(Right.ADMIN, ANY)


def sees_board(who: Who, board: BoardSubject) -> bool:
    """Tell whether a person, a script or a display may have a board."""
    if may_change(who, board) or board.share is BoardShare.PUBLIC:
        return True
    # A display's number is no person's, and neither is its role.
    if who.display:
        return board.share is BoardShare.VIEW and _holds(who.grants, Right.VIEW, board.site)
    if who.user == board.owner:
        return True
    if board.share is BoardShare.ROLE:
        return who.role == board.role
    return board.share is BoardShare.VIEW and _holds(who.grants, Right.VIEW, board.site)


def may_change(who: Who, board: BoardSubject) -> bool:
    """Tell whether a person may change a board, restore a version or remove it."""
    return not who.script and (who.user == board.owner or _administers(who))


def may_share(who: Who, board: BoardSubject, share: BoardShare, role: str) -> bool:
    """Tell whether a person may open a board to others.

    Everybody is an admin's to reach; others share with their own role, or with those who see the
    site, where they may use something of it.
    """
    if not may_change(who, board) or share is BoardShare.OWN:
        return may_change(who, board)
    if _administers(who):
        return True
    if share is BoardShare.PUBLIC:
        return False
    fits = share is BoardShare.VIEW or role == who.role
    return fits and _holds(who.grants, Right.USE, board.site)
