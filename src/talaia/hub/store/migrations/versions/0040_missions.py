"""Missions, and what became of each of their runs."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, ID, LONG, NAME

revision = "0040"
down_revision = "0039"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "missions",
        sa.Column("id", ID, primary_key=True),
        sa.Column("site", NAME, nullable=False),
        sa.Column("name", NAME, nullable=False),
        sa.Column(
            "owner_id",
            ID,
            sa.ForeignKey("users.id", ondelete="CASCADE", name="fk_missions_owner_id"),
            nullable=False,
        ),
        sa.Column("text", LONG, nullable=False),
        sa.Column("due_us", BIG, nullable=False),
        sa.Column("changed_us", BIG, nullable=False),
    )
    steps.create_index("ix_missions_site", "missions", ["site"])
    steps.create_index("ix_missions_due_us", "missions", ["due_us"])
    steps.create_index("ix_missions_owner_id", "missions", ["owner_id"])
    steps.create_table(
        "mission_runs",
        sa.Column("id", ID, primary_key=True),
        sa.Column("site", NAME, nullable=False),
        sa.Column("mission_id", BIG, nullable=False),
        sa.Column("name", NAME, nullable=False),
        sa.Column("who", NAME, nullable=False),
        sa.Column("begun_by", NAME, nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("why", sa.String(1000), nullable=False),
        sa.Column("began_us", BIG, nullable=False),
        sa.Column("ended_us", BIG, nullable=False),
        sa.Column("steps", LONG, nullable=False),
    )
    steps.create_index("ix_mission_runs_site_began_us", "mission_runs", ["site", "began_us"])


def downgrade() -> None:
    op.drop_table("mission_runs")
    op.drop_table("missions")
