"""Tile servers that admins allowed."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, ID, NAME

revision = "0038"
down_revision = "0037"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "map_sources",
        sa.Column("id", ID, primary_key=True),
        sa.Column("name", NAME, nullable=False),
        sa.Column("kind", sa.String(16), nullable=False),
        sa.Column("address", sa.String(500), nullable=False),
        sa.Column("attribution", NAME, nullable=False),
        sa.Column("most_zoom", sa.Integer, nullable=False),
        sa.Column("sealed_key", sa.String(1000), nullable=False),
        sa.Column("created_us", BIG, nullable=False),
    )


def downgrade() -> None:
    op.drop_table("map_sources")
