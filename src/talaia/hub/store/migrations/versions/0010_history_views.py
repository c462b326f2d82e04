"""The history knows spread and size of its blocks; each sensor gets rows and a view for SQL."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op
from sqlalchemy.dialects import mysql

from talaia.hub.store.migrations import steps

revision = "0010"
down_revision = "0004"
branch_labels = None
depends_on = None

_ID = sa.BigInteger().with_variant(sa.Integer, "sqlite")
_NAME = sa.String(200).with_variant(
    mysql.VARCHAR(200, charset="utf8mb4", collation="utf8mb4_bin"), "mysql", "mariadb"
)
_TEXT = sa.Text().with_variant(mysql.TEXT(charset="utf8mb4"), "mysql", "mariadb")


def upgrade() -> None:
    for table in ("history_block", "history_rollup"):
        steps.add_column(table, sa.Column("squares", sa.Double, nullable=True))
    steps.add_column("history_block", sa.Column("bytes", sa.Integer, nullable=True))
    steps.create_table(
        "history_recent",
        sa.Column("time_us", sa.BigInteger, nullable=False, autoincrement=False),
        sa.Column("channel_id", _ID, nullable=False, autoincrement=False),
        sa.Column("value", sa.Double, nullable=True),
        sa.Column("text", _TEXT, nullable=True),
        sa.PrimaryKeyConstraint("time_us", "channel_id", name="pk_history_recent"),
        sqlite_with_rowid=False,
    )
    steps.create_table(
        "history_sensor",
        sa.Column("site", _NAME, nullable=False),
        sa.Column("address", _NAME, nullable=False),
        sa.Column("view_name", sa.String(63), nullable=False),
        sa.Column("shown_name", _NAME, nullable=False),
        sa.Column("unit", _NAME, nullable=False),
        sa.Column("made_of", sa.String(32), nullable=False),
        sa.PrimaryKeyConstraint("site", "address", name="pk_history_sensor"),
        sa.UniqueConstraint("view_name", name="uq_history_sensor_view_name"),
    )


def downgrade() -> None:
    op.drop_table("history_sensor")
    op.drop_table("history_recent")
    op.drop_column("history_block", "bytes")
    for table in ("history_block", "history_rollup"):
        op.drop_column(table, "squares")
