"""Tokens of people, and protocols that an admin has opened, for tests of clients."""

from __future__ import annotations

from talaia.hub.auth.permissions import Permission, Right


async def token_of(hub, name: str) -> str:
    """Make a token with all that its person may do."""
    person = await hub.people.find_by_name(name)
    given = [Permission(Right.USE), Permission(Right.VIEW)]
    ends_us = hub.hub.core.clock.wall_ns() // 1000 + 3600 * 10**6
    made = await hub.hub.people.tokens.add_token(person.id, f"of {name}", ends_us, given)
    return made[1]


async def open_protocol(hub, protocol: str, *origins: str, is_open: bool = True) -> None:
    """Open or shut a protocol as an admin does, past the page."""
    feature = hub.hub.client_protocols
    await feature.protocols._store.set_state(
        protocol, is_open=is_open, origins=origins, who="admin"
    )
    await feature.protocols.reload_table()
