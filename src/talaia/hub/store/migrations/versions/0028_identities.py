"""People who sign in by a provider (OpenID Connect), and sessions that were begun like that."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, HASH, ID

revision = "0028"
down_revision = "0027"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "identities",
        # Of issuer and subject, which may be too long for an index.
        sa.Column("key_hash", HASH, nullable=False),
        sa.Column("user_id", ID, nullable=False),
        sa.Column("created_us", BIG, nullable=False),
        sa.PrimaryKeyConstraint("key_hash", name="pk_identities"),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_identities_user_id", ondelete="CASCADE"
        ),
    )
    steps.create_index("ix_identities_user_id", "identities", ["user_id"])
    steps.add_column(
        "sessions", sa.Column("provider", sa.Boolean, nullable=False, server_default=sa.false())
    )


def downgrade() -> None:
    op.drop_column("sessions", "provider")
    op.drop_table("identities")
