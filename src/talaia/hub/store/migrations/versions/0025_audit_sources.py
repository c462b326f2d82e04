"""Whose word a row of the audit log is: the hub's own, or a gateway's."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps

revision = "0025"
down_revision = "0024"
branch_labels = None
depends_on = None


def upgrade() -> None:
    # Empty in what was written before: those rows are chained without it.
    steps.add_column("audit", sa.Column("source", sa.String(16), nullable=False, server_default=""))


def downgrade() -> None:
    op.drop_column("audit", "source")
