"""The tables of who leads, and of how sites are divided; the locks themselves are no part."""

from __future__ import annotations

from sqlalchemy import BigInteger, Column, Integer, String, Table

from talaia.hub.store.tables import metadata

__all__ = ["hub_lead", "hub_plan"]

_SHARD = String(40)

hub_lead = Table(
    "hub_lead",
    metadata,
    # As they came.
    Column("id", Integer, primary_key=True, autoincrement=False),
    # How often the lead of this shard has changed.
    Column("epoch", BigInteger, nullable=False),
    # Of the key that seals secrets: all hubs have the same one, or they could not read them.
    Column("seal_hash", String(64), nullable=False),
    Column("name", String(200), nullable=False),
    Column("shard", _SHARD, nullable=False, server_default="main"),
)

# One row, or none: the sites have never been divided.
hub_plan = Table(
    "hub_plan",
    metadata,
    # Always 1.
    Column("id", Integer, primary_key=True, autoincrement=False),
    # How they are, as all hubs that lead a shard have to have it; empty: not at all.
    Column("agreed", String(1000), nullable=False),
)
