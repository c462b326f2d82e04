"""Lines of robots' own logs, and which of each gateway's run are kept."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, ID, LONG, NAME

revision = "0043"
down_revision = "0042"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "robot_log",
        sa.Column("id", ID, primary_key=True),
        sa.Column("site", NAME, nullable=False),
        sa.Column("time_us", BIG, nullable=False),
        sa.Column("level", sa.Integer, nullable=False),
        sa.Column("node", NAME, nullable=False),
        sa.Column("text", LONG, nullable=False),
        sa.Column("function", NAME, nullable=False),
        sa.Column("file", NAME, nullable=False),
        sa.Column("line", BIG, nullable=False),
        sa.Column("left_out", BIG, nullable=False),
    )
    steps.create_index("ix_robot_log_site", "robot_log", ["site", "time_us"])
    steps.create_index("ix_robot_log_node", "robot_log", ["site", "node", "time_us"])
    steps.create_table(
        "robot_log_runs",
        sa.Column("site", NAME, nullable=False),
        sa.Column("boot", NAME, nullable=False),
        sa.Column("below", BIG, nullable=False),
        sa.Column("changed_us", BIG, nullable=False),
        sa.PrimaryKeyConstraint("site", "boot", name="pk_robot_log_runs"),
    )


def downgrade() -> None:
    op.drop_table("robot_log_runs")
    op.drop_table("robot_log")
