"""A lead for each shard, and how sites are divided among them."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps

revision = "0046"
down_revision = "0045"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.add_column(
        "hub_lead", sa.Column("shard", sa.String(40), nullable=False, server_default="main")
    )
    steps.create_table(
        "hub_plan",
        sa.Column("id", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("agreed", sa.String(1000), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_hub_plan"),
    )


def downgrade() -> None:
    op.drop_table("hub_plan")
    op.drop_column("hub_lead", "shard")
