"""Passkeys, roles that require a second factor, and codes that are locked after many wrong ones."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, HASH, ID, LONG, NAME

revision = "0027"
down_revision = "0026"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.add_column(
        "roles",
        sa.Column("factor_required", sa.Boolean, nullable=False, server_default=sa.false()),
    )
    for name in ("code_wrong", "code_locked_us", "code_alert_us"):
        steps.add_column("users", sa.Column(name, BIG, nullable=False, server_default="0"))
    steps.create_table(
        "passkeys",
        sa.Column("id", ID, nullable=False),
        sa.Column("user_id", ID, nullable=False),
        sa.Column("name", NAME, nullable=False),
        # An id may have 1023 bytes, which is too long for an index.
        sa.Column("id_hash", HASH, nullable=False),
        sa.Column("credential_id", LONG, nullable=False),
        sa.Column("public_key", LONG, nullable=False),
        sa.Column("host", NAME, nullable=False),
        sa.Column("sign_count", BIG, nullable=False),
        sa.Column("created_us", BIG, nullable=False),
        sa.Column("used_us", BIG, nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_passkeys"),
        sa.UniqueConstraint("id_hash", name="uq_passkeys_id_hash"),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_passkeys_user_id", ondelete="CASCADE"
        ),
    )
    steps.create_index("ix_passkeys_user_id", "passkeys", ["user_id"])


def downgrade() -> None:
    op.drop_table("passkeys")
    for name in ("code_wrong", "code_locked_us", "code_alert_us"):
        op.drop_column("users", name)
    op.drop_column("roles", "factor_required")
