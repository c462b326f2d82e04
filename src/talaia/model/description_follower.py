"""The one interface of every part that holds a description, or a piece of one."""

from __future__ import annotations

from typing import Protocol, TypeVar, runtime_checkable

__all__ = ["DescriptionFollower"]

Piece_contra = TypeVar("Piece_contra", contravariant=True)


@runtime_checkable
class DescriptionFollower(Protocol[Piece_contra]):
    """A part that takes another description while it runs.

    The parameter says how much of it the part holds: a hub's part follows its site as it is live,
    a gateway's part the whole change, an adapter what one connection serves. What is the same in
    both descriptions goes on without a break.
    """

    def redescribe(self, now: Piece_contra, /) -> None:
        """Go by this from here on. Returns at once; called on the event loop."""
        ...
