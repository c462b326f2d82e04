"""Files that are to be removed from a store that is elsewhere."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG

revision = "0044"
down_revision = "0043"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "file_removals",
        sa.Column("file_key", sa.String(400), primary_key=True),
        sa.Column("since_us", BIG, nullable=False),
    )


def downgrade() -> None:
    op.drop_table("file_removals")
