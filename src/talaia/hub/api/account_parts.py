"""What the routes of an account work on."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from talaia.hub.api.access import Access
    from talaia.hub.api.proving import Proving
    from talaia.hub.auth.passwords import Passwords
    from talaia.hub.live.seats import Seats
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.browsers import KnownBrowsers
    from talaia.hub.store.factors import Factors
    from talaia.hub.store.people import People
    from talaia.hub.store.sessions import Sessions

__all__ = ["AccountParts"]


class AccountParts(NamedTuple):
    """The parts of an account; what ends a session lets ``seats`` follow at once."""

    access: Access
    proving: Proving
    people: People
    passwords: Passwords
    sessions: Sessions
    factors: Factors
    browsers: KnownBrowsers
    seats: Seats
    audit: Audit
