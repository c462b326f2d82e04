"""Displays: screens that show chosen sites, and are nobody's session."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, HASH, ID, LONG, NAME

revision = "0029"
down_revision = "0028"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "displays",
        sa.Column("id", ID, primary_key=True),
        sa.Column("name", NAME, nullable=False),
        sa.Column("token_hash", HASH, nullable=False),
        sa.Column("sites", LONG, nullable=False),
        sa.Column("created_us", BIG, nullable=False),
        sa.Column("used_us", BIG, nullable=False),
        sa.UniqueConstraint("token_hash", name="uq_displays_token_hash"),
    )


def downgrade() -> None:
    op.drop_table("displays")
