"""Whether the broker is reached, since when, and what it refuses: told to admins on their page."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["BrokerContact", "BrokerPresence"]

# Refusals that are kept, each of another kind.
_MOST_REFUSALS = 20


class BrokerContact(NamedTuple):
    """How it stands.

    Attributes:
        address: host and port; empty: the hub was started without a broker.
        connected: it is reached now.
        since_us: so it is since then (µs since the epoch, UTC); 0: it was not tried yet.
        why: it is lost; empty while it is reached, and while nothing is to be published.
        refused: what it does not let the account do.

    """

    address: str = ""
    connected: bool = False
    since_us: int = 0
    why: str = ""
    refused: tuple[str, ...] = ()


class BrokerPresence:
    """Written by the bridge, read by the page."""

    def __init__(self) -> None:
        """Begin without a broker."""
        self._contact = BrokerContact()

    @property
    def contact(self) -> BrokerContact:
        """How it stands now."""
        return self._contact

    def name_broker(self, address: str) -> None:
        """Say which broker it is."""
        self._contact = BrokerContact(address)

    def report_connected(self, now_us: int) -> None:
        """Say that it is reached; what it refused on an earlier connection is forgotten."""
        self._contact = BrokerContact(self._contact.address, connected=True, since_us=now_us)

    def report_lost(self, now_us: int, why: str) -> None:
        """Say that it is not reached: since the first loss, for the reason of the newest try."""
        lost = self._contact.why and not self._contact.connected
        since_us = self._contact.since_us if lost else now_us
        self._contact = BrokerContact(self._contact.address, since_us=since_us, why=why)

    def report_left(self, now_us: int) -> None:
        """Say that the hub has left it, since nothing is to be published."""
        if self._contact.connected or self._contact.why:
            self._contact = BrokerContact(self._contact.address, since_us=now_us)

    def report_refusal(self, text: str) -> bool:
        """Keep what it refused; False if that is known."""
        refused = self._contact.refused
        if text in refused or len(refused) >= _MOST_REFUSALS:
            return False
        self._contact = self._contact._replace(refused=(*refused, text))
        return True
