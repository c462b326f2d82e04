"""The table of who leads: one row, of which the lock itself is no part."""

from __future__ import annotations

from sqlalchemy import BigInteger, Column, Integer, String, Table

from talaia.hub.store.tables import metadata

__all__ = ["hub_lead"]

hub_lead = Table(
    "hub_lead",
    metadata,
    # Always 1.
    Column("id", Integer, primary_key=True, autoincrement=False),
    # How often the lead has changed.
    Column("epoch", BigInteger, nullable=False),
    # Of the key that seals secrets: all hubs have the same one, or they could not read them.
    Column("seal_hash", String(64), nullable=False),
    Column("name", String(200), nullable=False),
)
