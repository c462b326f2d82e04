"""The table of notes that people write about moments and spans of a site.

Times are microseconds since the epoch (UTC).
"""

from __future__ import annotations

from sqlalchemy import BigInteger, Column, ForeignKey, Index, Integer, String, Table

from talaia.hub.store.dialects.column_types import LONG_TEXT, ROW_ID
from talaia.hub.store.tables import metadata

__all__ = ["notes"]

_NAME = 200

notes = Table(
    "notes",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False),
    # What it is about; an empty device is the whole site, an empty signal the whole device.
    Column("device", String(_NAME), nullable=False),
    Column("signal", String(_NAME), nullable=False),
    # Both are the same of a note at a moment.
    Column("from_us", BigInteger, nullable=False),
    Column("to_us", BigInteger, nullable=False),
    Column("text", LONG_TEXT, nullable=False),
    # Who may change it. A number may be given again once its person is gone, so it goes with them;
    # the name stays.
    Column(
        "author_id",
        ROW_ID,
        ForeignKey("users.id", ondelete="SET NULL", name="fk_notes_author_id"),
        nullable=True,
    ),
    Column("who", String(_NAME), nullable=False),
    Column("created_us", BigInteger, nullable=False),
    # Of the last change; the same as of the beginning where there was none.
    Column("changed_us", BigInteger, nullable=False),
    Column("changed_by", String(_NAME), nullable=False),
    # Counts the changes from 1: of two who change it at once the second is told.
    Column("version", Integer, nullable=False),
    Index("ix_notes_site", "site", "from_us"),
    Index("ix_notes_author_id", "author_id"),
)
