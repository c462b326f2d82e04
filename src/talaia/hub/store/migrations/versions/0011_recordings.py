"""Recordings of raw topics that gateways have handed over; their files are in the data folder."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, HASH, LONG, NAME

revision = "0011"
down_revision = "0014"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "recordings",
        sa.Column("site", NAME, nullable=False),
        sa.Column("id", sa.String(64), nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("why", sa.String(2000), nullable=False),
        sa.Column("who", sa.String(2000), nullable=False),
        sa.Column("note", sa.String(2000), nullable=False),
        sa.Column("begin_us", BIG, nullable=False),
        sa.Column("end_us", BIG, nullable=False),
        sa.Column("size", BIG, nullable=False),
        sa.Column("have", BIG, nullable=False),
        sa.Column("messages", BIG, nullable=False),
        sa.Column("digest", HASH, nullable=False),
        sa.Column("topics", LONG, nullable=False),
        sa.PrimaryKeyConstraint("site", "id", name="pk_recordings"),
    )
    steps.create_index("ix_recordings_begin_us", "recordings", ["begin_us"])


def downgrade() -> None:
    op.drop_table("recordings")
