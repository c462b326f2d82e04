"""Every version of every site's description."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps

revision = "0016"
down_revision = "0015"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "descriptions",
        sa.Column("id", steps.ID, primary_key=True),
        sa.Column("site", steps.NAME, nullable=False),
        sa.Column("number", steps.BIG, nullable=False),
        sa.Column("digest", steps.HASH, nullable=False),
        sa.Column("text", steps.LONG, nullable=False),
        sa.Column("time_us", steps.BIG, nullable=False),
        sa.Column("gateway", steps.BIG, nullable=False),
        sa.Column("who", steps.NAME, nullable=False),
        sa.Column("note", steps.NAME, nullable=False),
        sa.UniqueConstraint("site", "number", name="uq_descriptions_site"),
    )


def downgrade() -> None:
    op.drop_table("descriptions")
