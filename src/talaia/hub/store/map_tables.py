"""The table of tile servers that admins allowed."""

from __future__ import annotations

from sqlalchemy import BigInteger, Column, Integer, String, Table

from talaia.hub.store.dialects.column_types import ROW_ID
from talaia.hub.store.tables import metadata

__all__ = ["map_sources"]

map_sources = Table(
    "map_sources",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("name", String(200), nullable=False),
    Column("kind", String(16), nullable=False),
    # With {z}, {x} and {y}; empty for Google.
    Column("address", String(500), nullable=False),
    Column("attribution", String(200), nullable=False),
    Column("most_zoom", Integer, nullable=False),
    # The owner's key for the service; empty for none.
    Column("sealed_key", String(1000), nullable=False),
    Column("created_us", BigInteger, nullable=False),
)
