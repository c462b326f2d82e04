"""The tables of boards that people made, and of every version of each.

Times are microseconds since the epoch (UTC).
"""

from __future__ import annotations

from sqlalchemy import BigInteger, Column, ForeignKey, Index, Integer, String, Table

from talaia.hub.store.dialects.column_types import LONG_TEXT, ROW_ID
from talaia.hub.store.tables import metadata

__all__ = ["board_versions", "boards"]

_NAME = 200

boards = Table(
    "boards",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    # What its address has: not guessed from other boards' numbers.
    Column("board_key", String(32), nullable=False, unique=True),
    Column(
        "owner_id",
        ROW_ID,
        ForeignKey("users.id", ondelete="CASCADE", name="fk_boards_owner_id"),
        nullable=False,
    ),
    # Who sees it: own, role, view or public; see `talaia.hub.auth.board_access`.
    Column("share", String(16), nullable=False),
    Column("role", String(_NAME), nullable=False),
    # Of the newest version, so that a list reads no boards.
    Column("name", String(_NAME), nullable=False),
    Column("site", String(_NAME), nullable=False),
    Column("kind", String(32), nullable=False),
    Column("number", Integer, nullable=False),
    Column("tiles", Integer, nullable=False),
    Column("changed_us", BigInteger, nullable=False),
    Index("ix_boards_owner_id", "owner_id"),
)

board_versions = Table(
    "board_versions",
    metadata,
    Column(
        "board_id",
        ROW_ID,
        ForeignKey("boards.id", ondelete="CASCADE", name="fk_board_versions_board_id"),
        primary_key=True,
    ),
    Column("number", Integer, primary_key=True),
    Column("time_us", BigInteger, nullable=False),
    Column("who", String(_NAME), nullable=False),
    Column("note", String(_NAME), nullable=False),
    # JSON: `talaia.model.boards.board.Board`.
    Column("text", LONG_TEXT, nullable=False),
)
