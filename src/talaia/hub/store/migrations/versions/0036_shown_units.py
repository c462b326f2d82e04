"""The units in which a person wants to see values."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps

revision = "0036"
down_revision = "0033"
branch_labels = None
depends_on = None


def upgrade() -> None:
    # A JSON object: stored unit to shown unit.
    steps.add_column(
        "users", sa.Column("shown_units", sa.String(2000), nullable=False, server_default="{}")
    )


def downgrade() -> None:
    op.drop_column("users", "shown_units")
