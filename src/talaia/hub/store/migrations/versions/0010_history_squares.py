"""The history's sums hold how far values lie from their mean."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    for table in ("history_block", "history_rollup"):
        op.add_column(table, sa.Column("squares", sa.Double, nullable=True))


def downgrade() -> None:
    for table in ("history_block", "history_rollup"):
        op.drop_column(table, "squares")
