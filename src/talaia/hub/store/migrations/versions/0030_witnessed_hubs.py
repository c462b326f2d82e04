"""Other hubs, and the signed heads of their audit logs that they leave here."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, HASH, ID, LONG, NAME

revision = "0030"
down_revision = "0029"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "witnessed_hubs",
        sa.Column("id", ID, primary_key=True),
        sa.Column("name", NAME, nullable=False),
        sa.Column("token_hash", HASH, nullable=False),
        sa.Column("public_key", NAME, nullable=False),
        sa.Column("keep_days", sa.Integer, nullable=False),
        sa.Column("created_us", BIG, nullable=False),
        sa.Column("heard_us", BIG, nullable=False),
        sa.Column("problem", LONG, nullable=False),
        sa.UniqueConstraint("token_hash", name="uq_witnessed_hubs_token_hash"),
    )
    steps.create_table(
        "witnessed_heads",
        sa.Column("id", ID, primary_key=True),
        sa.Column(
            "hub_id", ID, sa.ForeignKey("witnessed_hubs.id", ondelete="CASCADE"), nullable=False
        ),
        sa.Column("row_id", BIG, nullable=False),
        sa.Column("hash", HASH, nullable=False),
        sa.Column("time_us", BIG, nullable=False),
        sa.Column("received_us", BIG, nullable=False),
        sa.Column("line", LONG, nullable=False),
    )
    steps.create_index("ix_witnessed_heads_hub_id", "witnessed_heads", ["hub_id", "row_id"])


def downgrade() -> None:
    op.drop_table("witnessed_heads")
    op.drop_table("witnessed_hubs")
