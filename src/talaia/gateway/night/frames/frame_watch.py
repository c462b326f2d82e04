"""What spoils a frame that is exposed: a lost guide star, a mount that stands. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.night.night_values import NightView

__all__ = ["LOST_S", "FrameWatch"]

# A star that is held again within so long, or a mount that says so, spoils no frame (s).
LOST_S = 10.0


class FrameWatch:
    """Looks at one frame after the other."""

    def __init__(self, guide_lost: Callable[[], str]) -> None:
        """Ask ``guide_lost`` why the star that was held is not held now."""
        self._guide_lost = guide_lost
        # Since when something is wrong (monotonic, s).
        self._since: float | None = None

    def forget_frame(self) -> None:
        """Begin with another frame."""
        self._since = None

    def lost_reason(self, view: NightView, *, guided: bool, tracked: bool) -> str:
        """Say why the frame is lost; empty: it is not.

        Args:
            view: how things stand.
            guided: the frame must be guided.
            tracked: the mount has to follow the sky.

        """
        why = self._guide_lost() if guided else ""
        if tracked and view.tracking is False:
            why = "the telescope does not track"
        if not why:
            self._since = None
            return ""
        if self._since is None:
            self._since = view.now
        return why if view.now - self._since >= LOST_S else ""
