"""Notes that people write about moments and spans."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from talaia.hub.store.migrations import steps
from talaia.hub.store.migrations.steps import BIG, ID, LONG, NAME

revision = "0039"
down_revision = "0038"
branch_labels = None
depends_on = None


def upgrade() -> None:
    steps.create_table(
        "notes",
        sa.Column("id", ID, primary_key=True),
        sa.Column("site", NAME, nullable=False),
        sa.Column("device", NAME, nullable=False),
        sa.Column("signal", NAME, nullable=False),
        sa.Column("from_us", BIG, nullable=False),
        sa.Column("to_us", BIG, nullable=False),
        sa.Column("text", LONG, nullable=False),
        sa.Column("author_id", ID, nullable=True),
        sa.Column("who", NAME, nullable=False),
        sa.Column("created_us", BIG, nullable=False),
        sa.Column("changed_us", BIG, nullable=False),
        sa.Column("changed_by", NAME, nullable=False),
        sa.Column("version", sa.Integer, nullable=False),
        sa.ForeignKeyConstraint(
            ["author_id"], ["users.id"], name="fk_notes_author_id", ondelete="SET NULL"
        ),
    )
    steps.create_index("ix_notes_site", "notes", ["site", "from_us"])
    steps.create_index("ix_notes_author_id", "notes", ["author_id"])


def downgrade() -> None:
    op.drop_table("notes")
