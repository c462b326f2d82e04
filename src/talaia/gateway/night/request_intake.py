"""Puts together what the hub asks of the night, which comes in pieces. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.model.observing.requests import Proposal, RequestGroup  # noqa: TC001 - msgspec reads them

if TYPE_CHECKING:
    from talaia.wire.frames import RequestSync

__all__ = ["RequestIntake", "RequestSet"]

# Of one set; a hub that says more is not believed.
MOST_PIECES = 1000


class RequestSet(msgspec.Struct, frozen=True, kw_only=True):
    """All that is asked, as it is kept on disk.

    Attributes:
        revision: of the hub; 0: none yet.
        proposals: who pays.
        groups: those with a request that is pending.

    """

    revision: int = 0
    proposals: tuple[Proposal, ...] = ()
    groups: tuple[RequestGroup, ...] = ()


class RequestIntake:
    """Takes pieces; those of another revision than the newest are forgotten."""

    def __init__(self) -> None:
        """Begin with none."""
        self._revision, self._pieces = 0, 0
        self._found: dict[int, RequestSync] = {}

    def take_piece(self, piece: RequestSync) -> RequestSet | None:
        """Take one piece; gives the whole set when it was the last that was missing."""
        if not 0 < piece.pieces <= MOST_PIECES or piece.piece >= piece.pieces:
            return None
        if (piece.revision, piece.pieces) != (self._revision, self._pieces):
            self._revision, self._pieces = piece.revision, piece.pieces
            self._found.clear()
        self._found[piece.piece] = piece
        if len(self._found) < self._pieces:
            return None
        found = [self._found[index] for index in range(self._pieces)]
        self._found.clear()
        return RequestSet(
            revision=self._revision,
            proposals=tuple(one for part in found for one in part.proposals),
            groups=tuple(one for part in found for one in part.groups),
        )
