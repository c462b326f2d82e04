"""The history could not be kept or read."""

from __future__ import annotations

from talaia.hub.errors import HubError

__all__ = ["HistoryAway", "HistoryBusy", "HistoryElsewhere", "HistoryError"]


class HistoryError(HubError):
    """A batch was not stored, or a window could not be read.

    Nothing that `append` raised this for counts as stored: the gateway keeps it and sends it
    again, and what was stored after all is recognised by its sequence numbers.
    """

    def __str__(self) -> str:
        return f"history: {super().__str__()}"


class HistoryAway(HistoryError):
    """The server that has a site's history cannot be used now; the hub goes on without it."""


class HistoryElsewhere(HistoryAway):
    """A site's history is another lead's; it may have been this one's a moment ago."""


class HistoryBusy(HistoryError):
    """So much is asked for at once that this has to wait its turn."""
