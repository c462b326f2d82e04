"""The tables of missions and of their runs. Times are microseconds since the epoch (UTC)."""

from __future__ import annotations

from sqlalchemy import BigInteger, Column, ForeignKey, Index, String, Table

from talaia.hub.store.dialects.column_types import LONG_TEXT, ROW_ID
from talaia.hub.store.tables import metadata

__all__ = ["mission_runs", "missions"]

_NAME = 200

missions = Table(
    "missions",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False),
    Column("name", String(_NAME), nullable=False),
    # With whose rights its schedule runs: who saved it last. Without them it is nobody's.
    Column(
        "owner_id",
        ROW_ID,
        ForeignKey("users.id", ondelete="CASCADE", name="fk_missions_owner_id"),
        nullable=False,
    ),
    # JSON: `talaia.model.missions.mission.Mission`.
    Column("text", LONG_TEXT, nullable=False),
    # When its schedule is due next; 0: never.
    Column("due_us", BigInteger, nullable=False),
    Column("changed_us", BigInteger, nullable=False),
    Index("ix_missions_site", "site"),
    Index("ix_missions_due_us", "due_us"),
    Index("ix_missions_owner_id", "owner_id"),
)

mission_runs = Table(
    "mission_runs",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False),
    # Of its mission at that time: a run outlives the mission.
    Column("mission_id", BigInteger, nullable=False),
    Column("name", String(_NAME), nullable=False),
    # Whose rights it had, and "schedule" or who pressed start.
    Column("who", String(_NAME), nullable=False),
    Column("begun_by", String(_NAME), nullable=False),
    Column("state", String(16), nullable=False),
    Column("why", String(1000), nullable=False),
    Column("began_us", BigInteger, nullable=False),
    # 0 while it goes on.
    Column("ended_us", BigInteger, nullable=False),
    # JSON: each step with what became of it.
    Column("steps", LONG_TEXT, nullable=False),
    Index("ix_mission_runs_site_began_us", "site", "began_us"),
)
