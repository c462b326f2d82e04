"""Tables of other hubs, and of the signed heads that they leave here."""

from __future__ import annotations

from sqlalchemy import BigInteger, Column, ForeignKey, Index, Integer, String, Table

from talaia.hub.store.dialects.column_types import LONG_TEXT, ROW_ID
from talaia.hub.store.tables import metadata

__all__ = ["witnessed_heads", "witnessed_hubs"]

_NAME = 200
_HASH = 64

# Of their tokens the hash; the key is that of their first heads.
witnessed_hubs = Table(
    "witnessed_hubs",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("name", String(_NAME), nullable=False),
    Column("token_hash", String(_HASH), nullable=False, unique=True),
    # Base64; empty until heads came.
    Column("public_key", String(_NAME), nullable=False),
    Column("keep_days", Integer, nullable=False),
    Column("created_us", BigInteger, nullable=False),
    # 0 until it sent anything.
    Column("heard_us", BigInteger, nullable=False),
    # The first thing that did not fit together; empty while all does.
    Column("problem", LONG_TEXT, nullable=False),
)

# Two of one row that say different things are both kept: they are the proof.
witnessed_heads = Table(
    "witnessed_heads",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("hub_id", ROW_ID, ForeignKey("witnessed_hubs.id", ondelete="CASCADE"), nullable=False),
    Column("row_id", BigInteger, nullable=False),
    Column("hash", String(_HASH), nullable=False),
    # By the other hub's clock, and by ours.
    Column("time_us", BigInteger, nullable=False),
    Column("received_us", BigInteger, nullable=False),
    # As it was signed.
    Column("line", LONG_TEXT, nullable=False),
    Index("ix_witnessed_heads_hub_id", "hub_id", "row_id"),
)
