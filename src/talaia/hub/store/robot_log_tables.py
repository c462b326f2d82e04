"""The tables of lines of robots' own logs.

Times are microseconds since the epoch (UTC).
"""

from __future__ import annotations

from sqlalchemy import BigInteger, Column, Index, Integer, PrimaryKeyConstraint, String, Table

from talaia.hub.store.dialects.column_types import LONG_TEXT, ROW_ID
from talaia.hub.store.tables import metadata

__all__ = ["robot_log", "robot_log_runs"]

_NAME = 200

robot_log = Table(
    "robot_log",
    metadata,
    Column("id", ROW_ID, primary_key=True),
    Column("site", String(_NAME), nullable=False),
    Column("time_us", BigInteger, nullable=False),
    # As ROS 2 counts: 10 debug, 20 info, 30 warning, 40 error, 50 fatal.
    Column("level", Integer, nullable=False),
    Column("node", String(_NAME), nullable=False),
    Column("text", LONG_TEXT, nullable=False),
    # Where in the source it was said; empty and 0: unknown.
    Column("function", String(_NAME), nullable=False),
    Column("file", String(_NAME), nullable=False),
    Column("line", BigInteger, nullable=False),
    # So many lines were not kept, and the text says why; 0: it is a line of the robot.
    Column("left_out", BigInteger, nullable=False),
    Index("ix_robot_log_site", "site", "time_us"),
    Index("ix_robot_log_node", "site", "node", "time_us"),
)

# Which lines of a gateway's run were taken: one that comes again is known by its number.
robot_log_runs = Table(
    "robot_log_runs",
    metadata,
    Column("site", String(_NAME), nullable=False),
    Column("boot", String(_NAME), nullable=False),
    # All with lower numbers.
    Column("below", BigInteger, nullable=False),
    Column("changed_us", BigInteger, nullable=False),
    PrimaryKeyConstraint("site", "boot", name="pk_robot_log_runs"),
)
