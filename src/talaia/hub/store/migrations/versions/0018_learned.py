"""What anomaly detectors have learned: one row for each detector of a signal."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op
from sqlalchemy.dialects import mysql

from talaia.hub.store.migrations import steps

revision = "0018"
down_revision = "0017"
branch_labels = None
depends_on = None

_BYTES = sa.LargeBinary().with_variant(mysql.LONGBLOB(), "mysql", "mariadb")


def upgrade() -> None:
    steps.create_table(
        "learned",
        sa.Column("site", steps.NAME, primary_key=True),
        sa.Column("address", steps.NAME, primary_key=True),
        sa.Column("detector", sa.String(20), primary_key=True),
        sa.Column("state", _BYTES, nullable=False),
        sa.Column("saved_us", steps.BIG, nullable=False),
    )


def downgrade() -> None:
    op.drop_table("learned")
