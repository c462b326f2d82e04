"""Client protocols that an admin has opened, and who may drive what by them."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps

revision = "0021"
down_revision = "0020"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "client_protocols",
        sa.Column("protocol", sa.String(32), primary_key=True),
        sa.Column("is_open", sa.Boolean, nullable=False),
        sa.Column("origins", steps.LONG, nullable=False),
        sa.Column("changed_by", steps.NAME, nullable=False),
        sa.Column("changed_us", steps.BIG, nullable=False),
    )
    steps.create_table(
        "client_drivers",
        sa.Column(
            "user_id",
            steps.ID,
            sa.ForeignKey("users.id", ondelete="CASCADE", name="fk_client_drivers_user_id"),
            primary_key=True,
        ),
        sa.Column("site", steps.NAME, primary_key=True),
        sa.Column("device", steps.NAME, primary_key=True),
        sa.Column("given_by", steps.NAME, nullable=False),
        sa.Column("given_us", steps.BIG, nullable=False),
    )


def downgrade() -> None:
    op.drop_table("client_drivers")
    op.drop_table("client_protocols")
